#include "host/scene/broad_phase.hpp"

#include <algorithm>

namespace lockstep {

namespace {

// From here on the tree was faster (docs/performance.md).
constexpr double tree_ratio = 4;

}  // namespace

bool prefers_tree(std::vector<double> extents) {
  if (extents.empty()) return false;
  const auto middle = extents.begin() + static_cast<std::ptrdiff_t>(extents.size() / 2);
  std::nth_element(extents.begin(), middle, extents.end());
  return *std::max_element(extents.begin(), extents.end()) > tree_ratio * *middle;
}

}  // namespace lockstep
