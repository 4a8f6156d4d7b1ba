// What tolerances.h says of one pair, for LANES of them. cpu_reference/tolerances.hpp is the twin.
#ifndef LOCKSTEP_LANE_TOLERANCES_H
#define LOCKSTEP_LANE_TOLERANCES_H

#include "lanes.h"
#include "tolerance_shares.h"

// As slop_radius.
static inline lane lane_slop_radius(lane inner_radius, lane bounding_radius) {
  const lane beyond = (lane)(real)SLOP_OF_WIDTH * (bounding_radius - (lane)(real)THIN_ASPECT * inner_radius);
  const lane most = (lane)(real)SLOP_OF_THIN * inner_radius, thin = beyond < most ? beyond : most;
  return thin > inner_radius ? thin : inner_radius;
}

static inline lane lane_pair_slop(const StepParams* p, lane inner_radius, lane bounding_radius) {
  return (lane)p->slop + (lane)p->slop_share * lane_slop_radius(inner_radius, bounding_radius);
}

static inline lane lane_pair_correction_limit(const StepParams* p, lane bounding_radius) {
  return (lane)p->correction_limit + (lane)p->correction_limit_share * bounding_radius;
}

#endif
