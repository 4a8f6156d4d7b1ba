#include "host/scene/compile_partitions.hpp"

#include <algorithm>

#include "host/scene/exact_math.hpp"
#include "host/scene/rounding.hpp"

namespace lockstep {

namespace {

// Bodies along an edge of a cell (docs/solvers.md).
constexpr double bodies_along_edge = 4;

// The diameters of spheres about the centres of mass that hold the bodies of a world which can move.
template <class real>
std::vector<double> diameters_of(const WorldRange& world, const Buffers<real>& b) {
  std::vector<double> diameters(world.body_count, 0);
  for (u32 i = world.first_shape; i < world.first_shape + world.shape_count; ++i) {
    const ShapeInfo& info = b.shape_infos[i];
    if (b.body_infos[info.body].kind != BODY_DYNAMIC || (info.flags & SHAPE_IS_SENSOR) != 0) continue;
    const Shape<real>& shape = b.shapes[i];
    const Vector3 offset = {double(shape.offset[0]), double(shape.offset[1]), double(shape.offset[2])};
    double& diameter = diameters[info.body - world.first_body];
    diameter = std::max(diameter, 2 * (exact::length(offset) + double(shape.reach)));
  }
  std::erase(diameters, 0.0);
  return diameters;
}

// Bodies that are much larger than most are few: their pairs are in no cell.
double median_of(std::vector<double> values) {
  if (values.empty()) return 1;  // nothing can move
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

template <class real>
void compile_partitions(std::span<const Scene> worlds, InitialState<real>& state) {
  Buffers<real>& b = state.buffers;
  b.cell_sizes.clear();
  for (std::size_t w = 0; w < worlds.size(); ++w) {
    const double wanted = worlds[0].settings.cell_size;
    const double size = wanted > 0 ? wanted : bodies_along_edge * median_of(diameters_of(b.world_ranges[w], b));
    b.cell_sizes.push_back(rounded_positive<real>(size, "cell_size", {worlds[w]}));
  }
}

template void compile_partitions<float>(std::span<const Scene>, InitialState<float>&);
template void compile_partitions<double>(std::span<const Scene>, InitialState<double>&);

}  // namespace lockstep
