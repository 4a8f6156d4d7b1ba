// Lengths and speeds that follow the smaller shape of a pair, where a scene does not give them: slop, margin, the speed
// at which overlap is taken back. kernels/tolerances.h is the twin.
#pragma once

#include "kernels/types.h"

namespace lockstep::reference {

/// The smaller of two radii, of shapes that have an inside: a radius of 0 counts as none. Of inner radii (Shape::size)
/// how deep the less deep shape is, m; of bounding radii how large the smaller one is.
template <class real>
real pair_radius(real radius_a, real radius_b) {
  const real smaller = radius_a < radius_b ? radius_a : radius_b;
  const real larger = radius_a < radius_b ? radius_b : radius_a;
  return smaller > 0 ? smaller : larger;
}

/// The bounding radius of a shape that has an inside, m; else 0: a triangle of a surface is as large as its mesh is
/// coarse.
template <class real>
real solid_radius(const Shape<real>& shape) {
  return shape.size[3] > 0 ? shape.bounding_radius : real(0);
}

/// How close another shape comes before this one asks for contacts, m: a share of its bounding radius, and for what is
/// thin no more than its inner radius. 0 where the margin is given, and of what has no inside.
template <class real>
real own_margin(const StepParams<real>& p, real bounding_radius, real inner_radius) {
  const real share = p.margin_share * bounding_radius;
  return share < inner_radius ? share : inner_radius;
}

/// That of the shape that asks for less.
template <class real>
real pair_margin(const StepParams<real>& p, real own_margin_a, real own_margin_b) {
  return p.margin + pair_radius(own_margin_a, own_margin_b);
}
template <class real>
real pair_slop(const StepParams<real>& p, real inner_radius) {
  return p.slop + p.slop_share * inner_radius;
}
template <class real>
real pair_correction_limit(const StepParams<real>& p, real bounding_radius) {
  return p.correction_limit + p.correction_limit_share * bounding_radius;
}

/// By how much the broad phase widens a shape, m: two shapes together by no less than their margin. What cannot move
/// meets what can, whose own margin is enough.
template <class real>
real shape_margin(const StepParams<real>& p, real own_margin, real inverse_mass) {
  return real(0.5) * p.margin + (inverse_mass > 0 ? own_margin : real(0));
}

}  // namespace lockstep::reference
