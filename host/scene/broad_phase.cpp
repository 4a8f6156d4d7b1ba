#include "host/scene/broad_phase.hpp"

#include <algorithm>

namespace lockstep {

namespace {

// From here on the tree was faster (docs/performance.md): few shapes are soon compared, and it takes more launches.
constexpr double tree_ratio = 4;
constexpr std::size_t tree_shapes = 500;  // of a world

// Up to here one work-group compares all shapes faster than launches sort them into cells (docs/performance.md).
constexpr std::size_t few_shapes = 256;

}  // namespace

bool prefers_all_pairs(std::size_t shapes) { return shapes <= few_shapes; }

bool prefers_tree(std::vector<double> extents, std::size_t worlds) {
  if (extents.size() < tree_shapes * worlds) return false;
  const auto middle = extents.begin() + static_cast<std::ptrdiff_t>(extents.size() / 2);
  std::nth_element(extents.begin(), middle, extents.end());
  return *std::max_element(extents.begin(), extents.end()) > tree_ratio * *middle;
}

}  // namespace lockstep
