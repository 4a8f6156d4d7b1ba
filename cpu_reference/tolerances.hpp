// Lengths and speeds that follow the smaller shape of a pair, where a scene does not give them: slop, margin, the speed
// at which overlap is taken back. kernels/tolerances.h is the twin.
#pragma once

#include "kernels/types.h"

namespace lockstep::reference {

/// The inner radius (Shape::size) of the smaller of two shapes, m; 0 where neither has an inside.
template <class real>
real pair_radius(real inner_radius_a, real inner_radius_b) {
  const real smaller = inner_radius_a < inner_radius_b ? inner_radius_a : inner_radius_b;
  const real larger = inner_radius_a < inner_radius_b ? inner_radius_b : inner_radius_a;
  return smaller > 0 ? smaller : larger;
}

template <class real>
real pair_margin(const StepParams<real>& p, real pair_radius) {
  return p.margin + p.margin_share * pair_radius;
}
template <class real>
real pair_slop(const StepParams<real>& p, real pair_radius) {
  return p.slop + p.slop_share * pair_radius;
}
template <class real>
real pair_correction_limit(const StepParams<real>& p, real pair_radius) {
  return p.correction_limit + p.correction_limit_share * pair_radius;
}

/// By how much the broad phase widens a shape, m: two shapes together by no less than their margin. What cannot move
/// meets what can, whose own radius is enough.
template <class real>
real shape_margin(const StepParams<real>& p, real inner_radius, real inverse_mass) {
  return real(0.5) * p.margin + (inverse_mass > 0 ? p.margin_share * inner_radius : real(0));
}

}  // namespace lockstep::reference
