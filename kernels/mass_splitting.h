// Bodies split among the pairs in contact (mass splitting): what Jacobi's sweeps and the warm start share.
// cpu_reference/mass_splitting.hpp is the twin and states the method.
#ifndef LOCKSTEP_MASS_SPLITTING_H
#define LOCKSTEP_MASS_SPLITTING_H

#include "common.h"
#include "solve_contact.h"

#if FEATURE_JACOBI

// One part of each body: as fast, and lighter.
static inline void part_lighten(lane parts, LaneBody* body) {
  body->inverse_mass = parts * body->inverse_mass;
  body->xx = parts * body->xx;
#if FEATURE_GENERAL_CONTACTS
  body->yy = parts * body->yy, body->zz = parts * body->zz;
  body->xy = parts * body->xy, body->xz = parts * body->xz, body->yz = parts * body->yz;
#endif
}

static inline LaneBody part_load(global const Motion* motions, global const u32* bodies, global const real* parts) {
  LaneBody body = lane_load_bodies(motions, bodies);
  part_lighten(LANE_LOAD(parts), &body);
  return body;
}

// To the pairs' own slots.
static inline void part_store(LaneBody body, global Velocity* body_parts, global const u32* slots) {
  lane_scatter_movable(lane_first_half(body), (global Real8*)body_parts, 1u, slots);
}

// The velocity of a body from those of its parts, in the order of their slots. The fourth and the eighth real of the
// lines are no velocities.
static inline void part_mean(u32 body, global const u32* part_starts, global const Velocity* body_parts,
                             global Motion* motions) {
  const u32 begin = part_starts[body], end = part_starts[body + 1u];
  if (begin == end) return;
  global const Real8* copies = (global const Real8*)body_parts;
  global Real8* line = (global Real8*)(motions + body);
  const Real8 start = line[0];
  Real8 change = copies[begin] - start;
  for (u32 k = begin + 1u; k < end; ++k) change = change + (copies[k] - start);
  Real8 next = start + change / (Real8)(real)(end - begin);
  next.s3 = start.s3;
  next.s7 = start.s7;
  line[0] = next;
}

#endif

#endif
