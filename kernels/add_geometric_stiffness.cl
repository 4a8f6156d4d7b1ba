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

static inline Vec3 mean_rotation(u32 bodies, u32 body, global const BodyInfo* body_infos,
                                 global const Velocity* previous_velocities, global const JointInfo* joint_infos,
                                 global const u32* body_joint_starts, global const BodyJoint* body_joints) {
  const Velocity own = previous_velocities[body];
  Vec3 sum = vec3(own.w);
  real count = (real)1;
  for (u32 k = body_joint_starts[body]; k < body_joint_starts[body + 1u]; ++k) {
    u32 joint = body_joints[k].joint, at = body;
    for (u32 hop = 0u; hop < STIFF_ROW; ++hop) {
      const JointInfo info = joint_infos[joint];
      at = info.body_a == at ? info.body_b : info.body_a;
      if (at >= bodies || at == body || body_infos[at].kind != BODY_DYNAMIC) break;
      const Velocity velocity = previous_velocities[at];
      sum = add3(sum, vec3(velocity.w));
      count = count + (real)1;
      const u32 first = body_joint_starts[at];
      if (body_joint_starts[at + 1u] - first != 2u) break;
      joint = body_joints[body_joints[first].joint == joint ? first + 1u : first].joint;
    }
  }
  return scale3((real)1 / count, sum);
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
    real moments = (real)0;
    for (u32 k = first; k < end; ++k) {
      const BodyJoint at = body_joints[k];
      const JointInfo info = joint_infos[at.joint];
      const Joint joint = joints[at.joint];
      const Vec3 arm = vec3(info.body_a == i ? joint.anchor_a : joint.anchor_b);
      const real impulse = squared_joint_impulse(joint_impulses + at.slot / PACK, at.slot % PACK, info.free);
      moments = moments + sqrt(impulse * dot3(arm, arm));
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
    const Vec3 mean =
        mean_rotation(params.bodies, i, body_infos, previous_velocities, joint_infos, body_joint_starts, body_joints);
    const Vec3 own = unrotate3(q, sub3(vec3(velocity.w), mean));
    store3(motion.w, sub3(vec3(motion.w), rotate3(q, multiply3(make3(damped[0], damped[1], damped[2]), own))));
    motions[i] = motion;
  }
}
