// Which search of the broad phase suits a scene. The choice changes speed only: all find the same pairs.
#pragma once

#include <cstddef>
#include <vector>

namespace lockstep {

/// True where comparing every shape with every other is best.
bool prefers_all_pairs(std::size_t shapes);

/// True for the tree, false for the grid, whose cells hold the largest shape of all: `extents` are the radii of the
/// spheres that hold the bounded shapes of a batch for a step.
bool prefers_tree(std::vector<double> extents, std::size_t worlds);

}  // namespace lockstep
