// The facets of a convex hull by qhull: only which points belong together, in no order that anyone may rely on.
#pragma once

#include <array>
#include <vector>

#include "host/scene/exact_math.hpp"
#include "kernels/types.h"

namespace lockstep {

/// Triangles of indices of points, turned either way; none where qhull finds no hull.
std::vector<std::array<u32, 3>> facets_by_qhull(const std::vector<Vector3>& points);

}  // namespace lockstep
