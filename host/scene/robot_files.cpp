#include "host/scene/robot_files.hpp"

#include <fmt/format.h>

#include "host/scene/few_corners.hpp"
#include "host/scene/hull.hpp"

namespace lockstep {

void expect_real(const XmlNode& node, const MassProperties& solid) {
  constexpr double few_digits = 1e-3;  // those of a plate miss the triangle inequality by as much
  const Vector3 moments = principal_axes(solid.inertia).moments;
  for (unsigned i = 0; i < 3; ++i) {
    if (!(moments[i] > 0))
      node.fail(fmt::format("must be positive definite, has the principal moment {:.6g}", moments[i]));
    const double others = moments[(i + 1) % 3] + moments[(i + 2) % 3];
    if (moments[i] > others * (1 + few_digits))
      node.fail(
          fmt::format("must keep the triangle inequality of real bodies, its principal moment {:.6g} is more than "
                      "{:.6g}, the sum of the others",
                      moments[i], others));
  }
}

std::string set_hull_of_many(const std::vector<Vector3>& points, ShapeDescription& shape) {
  const std::string refusal = set_hull(points, shape);
  return refusal.empty() ? refusal : set_hull(few_corners(points), shape);
}

}  // namespace lockstep
