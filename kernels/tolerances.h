// Lengths and speeds that follow the smaller shape of a pair. cpu_reference/tolerances.hpp is the twin and says more.
#ifndef LOCKSTEP_TOLERANCES_H
#define LOCKSTEP_TOLERANCES_H

#include "math.h"
#include "tolerance_shares.h"
#include "types.h"

static inline real pair_radius(real radius_a, real radius_b) {
  const real smaller = radius_a < radius_b ? radius_a : radius_b;
  const real larger = radius_a < radius_b ? radius_b : radius_a;
  return smaller > (real)0 ? smaller : larger;
}

static inline real solid_radius(global const Shape* shape) {
  return shape->size[3] > (real)0 ? shape->bounding_radius : (real)0;
}

static inline real own_margin(const StepParams* p, real bounding_radius, real inner_radius) {
  const real share = p->margin_share * bounding_radius;
  return share < inner_radius ? share : inner_radius;
}

static inline real used_margin(real largest, real displacement) {
  const real used = (real)MARGIN_AT_REST * largest + (real)MARGIN_OF_MOTION * displacement;
  return used < largest ? used : largest;
}

static inline real shape_displacement(real h, Vec3 v, global const Motion* motion, real bounding_radius) {
  const Vec3 w = make3(motion->w[0], motion->w[1], motion->w[2]);
  return motion->inverse_mass > (real)0 ? h * (length3(v) + length3(w) * bounding_radius) : (real)0;
}

static inline real pair_margin(const StepParams* p, real own_margin_a, real own_margin_b) {
  return p->margin + pair_radius(own_margin_a, own_margin_b);
}

static inline real slop_radius(real inner_radius, real bounding_radius) {
  const real beyond = (real)SLOP_OF_WIDTH * (bounding_radius - (real)THIN_ASPECT * inner_radius);
  const real most = (real)SLOP_OF_THIN * inner_radius, thin = beyond < most ? beyond : most;
  return thin > inner_radius ? thin : inner_radius;
}
static inline real pair_slop(const StepParams* p, real inner_radius, real bounding_radius) {
  return p->slop + p->slop_share * slop_radius(inner_radius, bounding_radius);
}

static inline real shape_margin(const StepParams* p, real own, real inverse_mass) {
  return (real)0.5 * p->margin + (inverse_mass > (real)0 ? own : (real)0);
}

#endif
