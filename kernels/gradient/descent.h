// The descent of a world along the projected gradient. cpu_reference/gradient/descent.hpp is the twin and states the
// method.
#ifndef LOCKSTEP_DESCENT_H
#define LOCKSTEP_DESCENT_H

#include "common.h"
#include "sweep_change.h"

// What the descent of a world has come to.
typedef struct Descent {
  real step, theta, beta;
  u32 change;   // bits of a float: the largest change of a relative velocity, m/s
  u32 moved;    // 1 or 0: the last step was good
  u32 settled;  // 1 or 0: it was the last
  u32 pad;
} Descent;

typedef struct DescentSums {
  real length, uphill, bend, pad;
} DescentSums;

// A row of contacts on its way: what y and r' are, and the metric D.
typedef struct GradientRow {
  real metric[PACK];
  ImpulseBlock y, next;
} GradientRow;

// A block of joints; `sides` is D in parts of K.
typedef struct GradientJoints {
  real sides[PACK];
  JointImpulseBlock y, next;
} GradientJoints;

// A body at r, and at r'; the lines of bodies are at y. Of its sums the first of a node of the tree is the node's.
typedef struct GradientBody {
  Velocity at, ahead;
  DescentSums sums;
} GradientBody;

static inline void descent_begin(global Descent* world) {
  world->step = (real)1;
  world->theta = (real)1;
  world->beta = (real)0;
  world->change = 0u;
  world->moved = 0u;
  world->settled = 0u;
}

// A node of the tree that sums a world of `count` bodies.
static inline void descent_add(u32 count, u32 stride, u32 node, global GradientBody* bodies) {
  DescentSums sum = bodies[node].sums;
  for (u32 k = 1u; k < SUM_WIDTH && node + k * stride < count; ++k) {
    const DescentSums more = bodies[node + k * stride].sums;
    sum.length = sum.length + more.length;
    sum.uphill = sum.uphill + more.uphill;
    sum.bend = sum.bend + more.bend;
  }
  bodies[node].sums = sum;
}

// One work-group: the tree of a world that is alone.
static inline void descent_sum_together(u32 count, global GradientBody* bodies) {
  u32 stride = 1u;
  do {
    for (u32 node = (u32)get_local_id(0) * SUM_WIDTH * stride; node < count;
         node += (u32)get_local_size(0) * SUM_WIDTH * stride)
      descent_add(count, stride, node, bodies);
    barrier(CLK_GLOBAL_MEM_FENCE);
    stride *= SUM_WIDTH;
  } while (stride < count);
}

// One work-item.
static inline void descent_sum_alone(u32 count, global GradientBody* bodies) {
  for (u32 stride = 1u; stride < count; stride *= SUM_WIDTH) {
    for (u32 node = 0u; node < count; node += SUM_WIDTH * stride) descent_add(count, stride, node, bodies);
  }
}

// Judges the step of a world, and chooses the next.
static inline void descent_decide(DescentSums sums, bool accelerated, real tolerance, global Descent* world) {
#if FEATURE_TOLERANCE
  const real change = (real)as_float(world->change);
  world->change = 0u;
#endif
  const real step_length = world->step;
  if (step_length > (real)1 && !(step_length * sums.bend <= sums.length)) {
    const real shorter = (real)0.5f * step_length;
    world->step = shorter > (real)1 ? shorter : (real)1;
    world->moved = 0u;
    return;
  }
  world->moved = 1u;
  world->step = (real)DESCENT_GROWTH * step_length;
  world->beta = (real)0;
  if (accelerated) {
    const real theta = world->theta, squared = theta * theta;
    const real next = (real)0.5f * (sqrt(squared * (squared + (real)4)) - squared);
    const bool uphill = sums.uphill > (real)0;
    world->beta = uphill ? (real)0 : theta * ((real)1 - theta) / (squared + next);
    world->theta = uphill ? (real)1 : next;
  }
#if FEATURE_TOLERANCE
  if (change <= tolerance) world->settled = 1u;
#endif
}

// ---- lanes of several worlds ---------------------------------------------------------------------------------------

typedef struct LaneDescent {
  lane step, beta;
  lane_mask moved, settled;
} LaneDescent;

// Of LANES worlds.
static inline LaneDescent lane_descents(const u32* worlds, global const Descent* descents) {
  real steps[LANES], betas[LANES];
  u32 moved[LANES], settled[LANES];
  for (u32 k = 0u; k < LANES; ++k) {
    global const Descent* world = descents + worlds[k];
    steps[k] = world->step;
    betas[k] = world->beta;
    settled[k] = world->settled;
    moved[k] = settled[k] == 0u ? world->moved : 0u;
  }
  LaneDescent lanes;
  lanes.step = LANE_LOAD(steps);
  lanes.beta = LANE_LOAD(betas);
  lanes.moved = LANE_MASK(LANE_LOAD_U32(moved) != (lane_u32)0u);
  lanes.settled = LANE_MASK(LANE_LOAD_U32(settled) != (lane_u32)0u);
  return lanes;
}

#if FEATURE_TOLERANCE
// The squares of the largest changes that each lane made, m^2/s^2.
static inline void descent_note(lane squared, const u32* worlds, global Descent* descents) {
  real changes[LANES];
  LANE_STORE(squared, changes);
  for (u32 k = 0u; k < LANES; ++k) {
    const float change = (float)sqrt(changes[k]);
    if (change > 0.0f) atomic_max(&descents[worlds[k]].change, as_uint(change));
  }
}
#endif

// To the sides' own slots among those of their bodies; those of bodies that cannot move have none.
#if LANES == 1
static inline void lane_scatter_to_slots(LaneLines r, global Real8* lines, global const u32* slots) {
  if (slots[0] != NONE) lines[slots[0]] = (Real8)(r.c0, r.c1, r.c2, r.c3, r.c4, r.c5, r.c6, r.c7);
}
#else
#define STORE_LINE(k, line) \
  if (slots[k] != NONE) lines[slots[k]] = line
static inline void scatter_to_slots8(Rows8 components, global Real8* lines, global const u32* slots) {
  const Rows8 m = transpose8(components);
  STORE_LINE(0, m.r0);
  STORE_LINE(1, m.r1);
  STORE_LINE(2, m.r2);
  STORE_LINE(3, m.r3);
  STORE_LINE(4, m.r4);
  STORE_LINE(5, m.r5);
  STORE_LINE(6, m.r6);
  STORE_LINE(7, m.r7);
}
static inline void lane_scatter_to_slots(LaneLines r, global Real8* lines, global const u32* slots) {
  Rows8 m;
#if LANES == 8
  m.r0 = r.c0, m.r1 = r.c1, m.r2 = r.c2, m.r3 = r.c3, m.r4 = r.c4, m.r5 = r.c5, m.r6 = r.c6, m.r7 = r.c7;
  scatter_to_slots8(m, lines, slots);
#else
  m.r0 = r.c0.lo, m.r1 = r.c1.lo, m.r2 = r.c2.lo, m.r3 = r.c3.lo;
  m.r4 = r.c4.lo, m.r5 = r.c5.lo, m.r6 = r.c6.lo, m.r7 = r.c7.lo;
  scatter_to_slots8(m, lines, slots);
  m.r0 = r.c0.hi, m.r1 = r.c1.hi, m.r2 = r.c2.hi, m.r3 = r.c3.hi;
  m.r4 = r.c4.hi, m.r5 = r.c5.hi, m.r6 = r.c6.hi, m.r7 = r.c7.hi;
  scatter_to_slots8(m, lines, slots + 8);
#endif
}
#endif

// What both sides are given, N s and N m s; one of them alone has what the step adds up to.
typedef struct LaneStep {
  Lane3 impulse_a, moment_a, impulse_b, moment_b;
  lane length, uphill, change;
} LaneStep;

static inline LaneLines lane_contribution(Lane3 impulse, Lane3 moment, lane_mask counted, lane length, lane uphill) {
  LaneLines contribution;
  contribution.c0 = impulse.x, contribution.c1 = impulse.y, contribution.c2 = impulse.z;
  contribution.c3 = counted ? length : (lane)0;
  contribution.c4 = moment.x, contribution.c5 = moment.y, contribution.c6 = moment.z;
  contribution.c7 = counted ? uphill : (lane)0;
  return contribution;
}

static inline void lane_store_contributions(LaneStep step, global Velocity* contributions, global const u32* slots_a,
                                            global const u32* slots_b) {
  const lane_mask has_a = LANE_MASK(LANE_LOAD_U32(slots_a) != (lane_u32)NONE);
  lane_scatter_to_slots(lane_contribution(step.impulse_a, step.moment_a, has_a, step.length, step.uphill),
                        (global Real8*)contributions, slots_a);
  lane_scatter_to_slots(lane_contribution(step.impulse_b, step.moment_b, !has_a, step.length, step.uphill),
                        (global Real8*)contributions, slots_b);
}

static inline lane lane_ahead(lane_mask moved, lane beta, lane next, lane r, lane y) {
  return moved ? next + beta * (next - r) : y;
}

#endif
