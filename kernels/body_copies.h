// Bodies split among the pairs in contact (mass splitting): what Jacobi's sweeps and the warm start share.
// cpu_reference/body_copies.hpp is the twin and states the method.
#ifndef LOCKSTEP_BODY_COPIES_H
#define LOCKSTEP_BODY_COPIES_H

#include "common.h"
#include "solve_contact.h"

#if FEATURE_JACOBI

// One copy of each body: as fast, and lighter.
static inline void body_copy_lighten(lane copies, LaneBody* body) {
  body->inverse_mass = copies * body->inverse_mass;
  body->xx = copies * body->xx;
#if FEATURE_GENERAL_CONTACTS
  body->yy = copies * body->yy, body->zz = copies * body->zz;
  body->xy = copies * body->xy, body->xz = copies * body->xz, body->yz = copies * body->yz;
#endif
}

static inline LaneBody body_copy_load(global const Motion* motions, global const u32* bodies,
                                      global const real* copies) {
  LaneBody body = lane_load_bodies(motions, bodies);
  body_copy_lighten(LANE_LOAD(copies), &body);
  return body;
}

// To the pairs' own slots.
static inline void body_copy_store(LaneBody body, global Velocity* body_copies, global const u32* slots) {
  lane_scatter_movable(lane_first_half(body), (global Real8*)body_copies, 1u, slots);
}

// The velocity of a body from those of its copies, in the order of their slots. The fourth and the eighth real of the
// lines are no velocities.
static inline void body_copy_mean(u32 body, global const u32* body_copy_starts, global const Velocity* body_copies,
                                  global Motion* motions) {
  const u32 begin = body_copy_starts[body], end = body_copy_starts[body + 1u];
  if (begin == end) return;
  global const Real8* copies = (global const Real8*)body_copies;
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
