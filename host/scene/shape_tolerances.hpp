// What follows the sizes of shapes and bodies where a scene gives no length or speed: the slop is a share of the inner
// radius (host/scene/shape_size.hpp) of the shape of a pair that is less deep, the others are shares of the bounding
// radius of the smaller one, the margin no more than its inner radius. A cube of 1 m has an inner radius of 0.5 m and a
// bounding radius of 0.87 m. What poses take back of an overlap leaves no speed, and may go faster.
#pragma once

#include <array>

#include "host/features.hpp"
#include "host/scene/settings.hpp"
#include "host/shape_tolerance.hpp"

namespace lockstep {

inline std::array<ShapeTolerance, 3> shape_tolerances(const Settings& settings, Features features) {
  return {{{"slop", settings.slop, 2e-4},
           {"margin", settings.margin, 0.035},
           {"correction_limit", settings.correction_limit, has(features, Feature::separated_contacts) ? 6.0 : 0.6}}};
}

/// 1/s. Faster than what is left of a contact at rest by a few sweeps, and than what gravity gives on a slope in the
/// first sub-step of a soft contact, which carries nothing yet; slower than what the eye takes for a slide.
constexpr double stick_speed_share = 0.02;

/// 1/s, of the radius about the centre of mass that holds the body: what is slower may sleep.
constexpr double sleep_speed_share = 0.184;

}  // namespace lockstep
