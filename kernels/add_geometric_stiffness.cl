#pragma OPENCL FP_CONTRACT OFF
// Lets light bodies between joints that carry much rotate by what a sub-step stands
// (cpu_reference/add_geometric_stiffness.hpp states the method).
#include "common.h"
#include "math.h"
#include "rigid_body.h"
#include "sleep.h"
#include "types.h"

static inline real squared_joint_impulse(global const JointImpulseBlock* given, u32 lane, u32 free) {
  real sum = (real)0;
  for (u32 i = 0u; i < 3u; ++i) sum = sum + given->locked[i][lane] * given->locked[i][lane];
  if (free == FREE_ANGLE || free == FREE_NOTHING) return sum;
  const real along = given->free[lane] + given->impedance[lane];
  return sum + along * along;
}

kernel void add_geometric_stiffness(const StepParams params, global const BodyInfo* body_infos,
                                    global const Mass* masses, global const Pivot* pivots,
                                    global const Sleeper* sleepers, global const Vec4* orientations,
                                    global const Velocity* previous_velocities, global const JointInfo* joint_infos,
                                    global const Joint* joints, global const u32* body_joint_starts,
                                    global const BodyJoint* body_joints, global const JointImpulseBlock* joint_impulses,
                                    global Motion* motions, global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(i, params.bodies) {
    const u32 first = body_joint_starts[i], end = body_joint_starts[i + 1u];
    if (first == end || is_asleep(sleepers, i) || IS_PIVOTED(pivots, i)) continue;
    real moments = (real)0, shared = (real)0;
    Vec3 others = make3((real)0, (real)0, (real)0);
    for (u32 k = first; k < end; ++k) {
      const BodyJoint at = body_joints[k];
      const JointInfo info = joint_infos[at.joint];
      const Joint joint = joints[at.joint];
      const bool is_a = info.body_a == i;
      const Vec3 arm = vec3(is_a ? joint.anchor_a : joint.anchor_b);
      const real impulse = squared_joint_impulse(joint_impulses + at.slot / PACK, at.slot % PACK, info.free);
      const real moment = sqrt(impulse * dot3(arm, arm));
      moments = moments + moment;
      const u32 other = is_a ? info.body_b : info.body_a;
      if (other >= params.bodies || body_infos[other].kind != BODY_DYNAMIC) continue;
      shared = shared + moment;
      const Velocity velocity = previous_velocities[other];
      others = add3(others, scale3(moment, vec3(velocity.w)));
    }

    const real least = (real)STIFF_INERTIA_SHARE * params.dt * moments;
    Mass mass = masses[i];
    real damped[3];
    for (u32 axis = 0u; axis < 3u; ++axis) {
      const real share = least * mass.inverse_inertia[axis];
      damped[axis] = share > (real)1 ? (real)1 - (real)1 / share : (real)0;
      if (share > (real)1) mass.inverse_inertia[axis] = (real)1 / least;
    }
    if (!(damped[0] > (real)0 || damped[1] > (real)0 || damped[2] > (real)0)) continue;

    Motion motion = motions[i];
    const Quat q = quat(orientations[i]);
    set_inverse_inertia(&motion, mass, body_infos[i], q);
    const Velocity velocity = previous_velocities[i];
    const Vec3 w = vec3(velocity.w);
    const Vec3 mean = shared > (real)0 ? scale3((real)1 / shared, others) : w;
    const Vec3 common = scale3((real)0.5f, add3(w, mean));
    const Vec3 own = unrotate3(q, sub3(w, scale3((real)STIFF_ROTATION_KEPT, common)));
    store3(motion.w, sub3(vec3(motion.w), rotate3(q, multiply3(make3(damped[0], damped[1], damped[2]), own))));
    motions[i] = motion;
  }
}
