#include "host/scene/broad_phase.hpp"

#include <algorithm>
#include <vector>

#include "host/scene/exact_math.hpp"

namespace lockstep {

namespace {

// From here on the tree was faster (docs/lab/layouts_and_broad_phase.md): few shapes are soon compared, and it takes
// more launches.
constexpr double tree_ratio = 4;
constexpr std::size_t tree_shapes = 500;  // of a world

// Up to here one work-group compares all shapes faster than launches sort them into cells
// (docs/lab/layouts_and_broad_phase.md).
constexpr std::size_t few_shapes = 256;

// Whether the tree is better than the grid, whose cells hold the largest shape of all: `extents` are the radii of the
// spheres that hold the bounded shapes of a batch for a step.
bool prefers_tree(std::vector<double> extents, std::size_t worlds) {
  if (extents.size() < tree_shapes * worlds) return false;
  const auto middle = extents.begin() + static_cast<std::ptrdiff_t>(extents.size() / 2);
  std::nth_element(extents.begin(), middle, extents.end());
  return *std::max_element(extents.begin(), extents.end()) > tree_ratio * *middle;
}

}  // namespace

// How far a shape can come in a step at its first speed, so that a scene with bullets counts as one of unequal sizes.
template <class real>
Feature broad_phase_of(const Settings& settings, std::size_t worlds, const Buffers<real>& buffers) {
  if (settings.broad_phase == BroadPhase::grid) return Feature::grid;
  if (settings.broad_phase == BroadPhase::bvh) return Feature::bvh;
  if (buffers.shapes.size() <= few_shapes) return Feature::all_pairs;
  std::vector<double> extents;
  for (std::size_t i = 0; i < buffers.shapes.size(); ++i) {
    const ShapeInfo& shape = buffers.shape_infos[i];
    if (shape.kind == SHAPE_PLANE || (shape.flags & SHAPE_IS_IN_TREE) != 0) continue;
    const Motion<real>& motion = buffers.motions[shape.body];
    const Vector3 v = {double(motion.v[0]), double(motion.v[1]), double(motion.v[2])};
    extents.push_back(double(buffers.shapes[i].bounding_radius) + settings.dt * exact::length(v));
  }
  return prefers_tree(std::move(extents), worlds) ? Feature::bvh : Feature::grid;
}

template Feature broad_phase_of(const Settings&, std::size_t, const Buffers<float>&);
template Feature broad_phase_of(const Settings&, std::size_t, const Buffers<double>&);

}  // namespace lockstep
