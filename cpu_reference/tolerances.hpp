// Lengths and speeds that follow the smaller shape of a pair, where a scene does not give them: slop, margin, the speed
// at which overlap is taken back. kernels/tolerances.h is the twin.
#pragma once

#include "cpu_reference/math.hpp"
#include "kernels/tolerance_shares.h"
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

/// How close another shape comes at most before this one asks for contacts, m: a share of its bounding radius, and for
/// what is thin no more than its inner radius. 0 where the margin is given, and of what has no inside.
template <class real>
real own_margin(const StepParams<real>& p, real bounding_radius, real inner_radius) {
  const real share = p.margin_share * bounding_radius;
  return share < inner_radius ? share : inner_radius;
}

/// The part of a margin that is used, m: all of it only by what moves, since a blow within the step changes where it
/// goes; what rests would have contacts with all that is near. `displacement`: of the movable bodies in the step, m.
template <class real>
real used_margin(real largest, real displacement) {
  const real used = real(MARGIN_AT_REST) * largest + real(MARGIN_OF_MOTION) * displacement;
  return used < largest ? used : largest;
}

/// How far a point of a shape moves in the step, m, at most; 0 for a body that cannot be pushed. `v`: of its centre.
template <class real>
real shape_displacement(real h, Vec3<real> v, const Motion<real>& motion, real bounding_radius) {
  return motion.inverse_mass > 0 ? h * (length3(v) + length3(vec3(motion.w)) * bounding_radius) : real(0);
}

/// The largest margin of a pair: that of the shape that asks for less.
template <class real>
real pair_margin(const StepParams<real>& p, real own_margin_a, real own_margin_b) {
  return p.margin + pair_radius(own_margin_a, own_margin_b);
}

/// The radius that the slop is a share of, m: the inner radius, and more for plates and cards, which stand on edges.
template <class real>
real slop_radius(real inner_radius, real bounding_radius) {
  const real beyond = real(SLOP_OF_WIDTH) * (bounding_radius - real(THIN_ASPECT) * inner_radius);
  const real most = real(SLOP_OF_THIN) * inner_radius, thin = beyond < most ? beyond : most;
  return thin > inner_radius ? thin : inner_radius;
}
template <class real>
real pair_slop(const StepParams<real>& p, real inner_radius, real bounding_radius) {
  return p.slop + p.slop_share * slop_radius(inner_radius, bounding_radius);
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
