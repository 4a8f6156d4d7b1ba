#include "host/scene/compile_partitions.hpp"

#include <algorithm>

#include "host/scene/rounding.hpp"

namespace lockstep {

namespace {

// Bodies along an edge of a cell (docs/theory/other_solvers.md).
constexpr double bodies_along_edge = 6;

// The mean of a shape's three widths along its axes.
template <class real>
double width_of(u32 kind, const Shape<real>& shape) {
  const double a = double(shape.size[0]), b = double(shape.size[1]), c = double(shape.size[2]);
  switch (kind) {
    case SHAPE_SPHERE: return 2 * a;
    case SHAPE_CAPSULE: return 2 * (3 * a + b) / 3;
    case SHAPE_CYLINDER: return 2 * (2 * a + b) / 3;
    case SHAPE_BOX:
    case SHAPE_HULL: return 2 * (a + b + c) / 3;
    default: return 0;  // planes
  }
}

// The widths of the bodies of a world that can move: of their widest shapes.
template <class real>
std::vector<double> widths_of(const WorldRange& world, const Buffers<real>& b) {
  std::vector<double> widths(world.body_count, 0);
  for (u32 i = world.first_shape; i < world.first_shape + world.shape_count; ++i) {
    const ShapeInfo& info = b.shape_infos[i];
    if (b.body_infos[info.body].kind != BODY_DYNAMIC || (info.flags & SHAPE_IS_TRIGGER) != 0) continue;
    double& width = widths[info.body - world.first_body];
    width = std::max(width, width_of(info.kind, b.shapes[i]));
  }
  std::erase(widths, 0.0);
  return widths;
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
    const double wanted = worlds[0].settings.cell_size.value_or(0);
    const double size = wanted > 0 ? wanted : bodies_along_edge * median_of(widths_of(b.world_ranges[w], b));
    b.cell_sizes.push_back(rounded_positive<real>(size, "cell_size", {worlds[w]}));
  }
}

template void compile_partitions<float>(std::span<const Scene>, InitialState<float>&);
template void compile_partitions<double>(std::span<const Scene>, InitialState<double>&);

}  // namespace lockstep
