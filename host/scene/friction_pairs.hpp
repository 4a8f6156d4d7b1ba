// The friction of each pair of materials of a scene.
#pragma once

#include <optional>
#include <vector>

#include "host/scene/scene.hpp"

namespace lockstep {

struct PairFriction {
  double sliding = 0;                 // mu of what slides
  double static_friction = 0;         // mu of what slides slower than stick_speed; no less than `sliding`
  std::optional<double> stick_speed;  // m/s; unset: it follows the smaller of two shapes
  double torsion_radius = 0;          // m (kernels/friction_types.h)
  double rolling_coefficient = 0;     // m

  double across = 1;           // mu across the axis of anisotropy, over that along it
  bool axis_of_b = false;      // whose the axis is
  bool perpendicular = false;  // no friction along that axis: `sliding` is mu across it, and `across`, 0, that along it

  bool is_anisotropic() const { return across != 1; }
  /// Whether there is more than a round cone of slip.
  bool has_further_friction() const { return torsion_radius > 0 || rolling_coefficient > 0 || is_anisotropic(); }
  bool has_static_friction() const { return static_friction > sliding; }
};

/// Of materials a and b at a * count + b; a scene without materials has one. Coefficients of two materials combine to
/// their geometric mean, rolling coefficients and speeds to the larger; of two axes of anisotropy that of a counts.
/// Rules of the scene override what they name, and a rule's friction the static one too. Where there is no friction
/// nothing resists rotation about the normal. Throws Error (input), naming the location, for a static friction below
/// the other, and for a torsional friction of what has none.
std::vector<PairFriction> friction_pairs_of(const Scene& scene);

}  // namespace lockstep
