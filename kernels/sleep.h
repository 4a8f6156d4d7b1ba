// Who sleeps, and who can disturb sleepers. cpu_reference/sleep.hpp is the twin.
#ifndef LOCKSTEP_SLEEP_H
#define LOCKSTEP_SLEEP_H

#include "common.h"

// What nobody of the scene does is compiled out. Not for the null body.
static inline bool is_asleep(global const Sleeper* sleepers, u32 body) {
#if FEATURE_SLEEPING
  return sleepers[body].island < ISLAND_WAKES;
#else
  return false;
#endif
}

static inline bool wakes(global const Sleeper* sleepers, u32 body) {
#if FEATURE_SLEEPING
  return sleepers[body].island == ISLAND_WAKES;
#else
  return false;
#endif
}

static inline bool has_velocity(global const Motion* m) {
  return m->v[0] != (real)0 || m->v[1] != (real)0 || m->v[2] != (real)0 || m->w[0] != (real)0 || m->w[1] != (real)0 ||
         m->w[2] != (real)0;
}

// Whether the body, of so many, is awake, or kinematic and on its way.
static inline bool is_moving(u32 body, u32 bodies, global const BodyInfo* body_infos, global const Motion* motions,
                             global const Sleeper* sleepers) {
  if (body >= bodies) return false;
  const u32 kind = body_infos[body].kind;
  return kind == BODY_DYNAMIC ? !is_asleep(sleepers, body) : kind == BODY_KINEMATIC && has_velocity(&motions[body]);
}

// Whether the broad phase asks what a shape of this kind may touch: a trigger feels sleepers too.
static inline bool looks_for_others(ShapeInfo shape, u32 bodies, global const BodyInfo* body_infos,
                                    global const Motion* motions, global const Sleeper* sleepers) {
  return (shape.flags & SHAPE_IS_TRIGGER) != 0u || is_moving(shape.body, bodies, body_infos, motions, sleepers);
}

// Whether the joint is of bodies that sleep.
static inline bool joint_sleeps(JointInfo joint, u32 bodies, global const Sleeper* sleepers) {
#if FEATURE_SLEEPING
  return (joint.body_a < bodies && is_asleep(sleepers, joint.body_a)) ||
         (joint.body_b < bodies && is_asleep(sleepers, joint.body_b));
#else
  return false;
#endif
}

#endif
