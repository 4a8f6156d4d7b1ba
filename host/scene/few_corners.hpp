// Points whose hull has more corners than a shape can have.
#pragma once

#include <vector>

#include "host/scene/exact_math.hpp"

namespace lockstep {

/// At most most_hull_vertices of the points, whose hull is nearly that of all, and lies within it: those farthest out
/// in 98 directions, then, one by one, that which is farthest outside of the hull of those there are; all in parts of
/// the size along x, y and z. The same from every compiler. Points that are not finite are given back as they are, for
/// convex_hull() to refuse.
std::vector<Vector3> few_corners(const std::vector<Vector3>& points);

}  // namespace lockstep
