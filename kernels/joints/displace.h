// Moves a body by an impulse and a moment, as displacements. cpu_reference/joints/displace.hpp is the twin.
#ifndef LOCKSTEP_JOINT_DISPLACE_H
#define LOCKSTEP_JOINT_DISPLACE_H

#include "gyroscopic.h"
#include "rigid_body.h"

// Writes the pose of a body that can move.
static inline void store_displaced(u32 body, Vec3 x, Quat q, global Vec4* positions, global Vec4* orientations,
                                   global u32* counters) {
  if (is_bad_pose(x, q)) report_bad(counters, STATUS_BAD_POSE, body);
  Vec4 position = positions[body];
  position.x = x.x;
  position.y = x.y;
  position.z = x.z;
  positions[body] = position;
  orientations[body] = make_vec4(q);
}

// What it writes, and what says of which bodies.
typedef struct MovedBodies {
  global const BodyInfo* infos;
  global Vec4* positions;
  global Vec4* orientations;
  global Motion* motions;
  global u32* counters;
} MovedBodies;

// Of the parameters of a kernel.
#define MOVED_BODIES \
  { body_infos, positions, orientations, motions, counters }

// Bodies that cannot move are never written.
static inline void displace(const StepParams* params, u32 body, Motion motion, Vec3 x, Quat q, Vec3 impulse,
                            Vec3 moment, MovedBodies to) {
  if (!(motion.inverse_mass > (real)0)) return;
  const Vec3 rotation = apply_inverse_inertia(motion, moment), z = scale3((real)0.5, rotation);
  x = add3(x, scale3(motion.inverse_mass, impulse));
  q = correct_orientation(q, rotation);
  store_displaced(body, x, q, to.positions, to.orientations, to.counters);
  if (is_carried(params, to.infos[body])) {
    store3(motion.w, rotate_by(make4(z.x, z.y, z.z, (real)1), vec3(motion.w)));
    to.motions[body] = motion;
  }
}

#endif
