// Lengths and speeds that follow the smaller shape of a pair. cpu_reference/tolerances.hpp is the twin and says more.
#ifndef LOCKSTEP_TOLERANCES_H
#define LOCKSTEP_TOLERANCES_H

#include "types.h"

static inline real pair_radius(real inner_radius_a, real inner_radius_b) {
  const real smaller = inner_radius_a < inner_radius_b ? inner_radius_a : inner_radius_b;
  const real larger = inner_radius_a < inner_radius_b ? inner_radius_b : inner_radius_a;
  return smaller > (real)0 ? smaller : larger;
}

static inline real pair_margin(const StepParams* p, real radius) { return p->margin + p->margin_share * radius; }
static inline real pair_slop(const StepParams* p, real radius) { return p->slop + p->slop_share * radius; }

static inline real shape_margin(const StepParams* p, real inner_radius, real inverse_mass) {
  return (real)0.5 * p->margin + (inverse_mass > (real)0 ? p->margin_share * inner_radius : (real)0);
}

#endif
