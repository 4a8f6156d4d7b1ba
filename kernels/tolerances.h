// Lengths and speeds that follow the smaller shape of a pair. cpu_reference/tolerances.hpp is the twin and says more.
#ifndef LOCKSTEP_TOLERANCES_H
#define LOCKSTEP_TOLERANCES_H

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

static inline real pair_margin(const StepParams* p, real own_margin_a, real own_margin_b) {
  return p->margin + pair_radius(own_margin_a, own_margin_b);
}
static inline real pair_slop(const StepParams* p, real radius) { return p->slop + p->slop_share * radius; }

static inline real shape_margin(const StepParams* p, real own, real inverse_mass) {
  return (real)0.5 * p->margin + (inverse_mass > (real)0 ? own : (real)0);
}

#endif
