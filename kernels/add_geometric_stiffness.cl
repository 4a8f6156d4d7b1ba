#pragma OPENCL FP_CONTRACT OFF
// Gives light bodies between loaded joints the inertia with which a sub-step is stable
// (cpu_reference/add_geometric_stiffness.hpp states the method).
#include "common.h"
#include "gyroscopic.h"
#include "joints/current_joint.h"
#include "math.h"
#include "rigid_body.h"
#include "sleep.h"
#include "types.h"

// What the stage reads of bodies and joints.
typedef struct StiffnessStream {
  u32 bodies;
  real dt;
  global const Mass* masses;
  global const Vec4* positions;
  global const Vec4* orientations;
  global const Velocity* previous_velocities;
  global const JointInfo* joint_infos;
  global const Joint* joints;
  global const real* screw_leads;
  global const real* rolling_radii;
  global const u32* body_joint_starts;
  global const BodyJoint* body_joints;
  global const JointImpulseBlock* joint_impulses;
} StiffnessStream;

// N m s; `own` of each principal axis, `coupled` a bound of what couples it with the others.
typedef struct Stiffness {
  Vec3 own, coupled;
} Stiffness;

static inline Stiffness geometric_stiffness(const StiffnessStream* s, u32 body) {
  Stiffness sum;
  sum.own = sum.coupled = make3((real)0, (real)0, (real)0);
  const Quat q = quat(s->orientations[body]);
  for (u32 k = s->body_joint_starts[body]; k < s->body_joint_starts[body + 1u]; ++k) {
    const BodyJoint at = s->body_joints[k];
    const JointInfo info = s->joint_infos[at.joint];
    global const JointImpulseBlock* given = s->joint_impulses + at.slot / PACK;
    const u32 lane = at.slot % PACK;
    Vec3 x_a, x_b;
    Quat q_a, q_b;
    joint_pose(info.body_a, s->bodies, s->positions, s->orientations, &x_a, &q_a);
    joint_pose(info.body_b, s->bodies, s->positions, s->orientations, &x_b, &q_b);
    const CurrentJoint joint =
        current_joint(s->joints[at.joint], info.locked, info.free,
                      joint_sizes(s->screw_leads, s->rolling_radii, at.joint), x_a, q_a, x_b, q_b);
    Vec3 impulse = make3((real)0, (real)0, (real)0);
    for (u32 row = 0u; row < 3u; ++row) impulse = add3(impulse, scale3(given->locked[row][lane], joint.axes[row]));
    if (info.free == FREE_TRAVEL || info.free == FREE_LENGTH)
      impulse = add3(impulse, scale3(given->free[lane] + given->impedance[lane], joint.free_axis));
    const Vec3 f = unrotate3(q, impulse), r = unrotate3(q, info.body_a == body ? joint.arm_a : joint.arm_b);
    const real x = fabs(f.x * r.x), y = fabs(f.y * r.y), z = fabs(f.z * r.z);
    const real yz = (real)0.5f * fabs(f.y * r.z + f.z * r.y), zx = (real)0.5f * fabs(f.z * r.x + f.x * r.z),
               xy = (real)0.5f * fabs(f.x * r.y + f.y * r.x);
    sum.own = add3(sum.own, make3(y + z, z + x, x + y));
    sum.coupled = add3(sum.coupled, make3(xy + zx, yz + xy, zx + yz));
  }
  return sum;
}

static inline real sum_of_sizes(Vec3 v) { return fabs(v.x) + fabs(v.y) + fabs(v.z); }

static inline bool carries_little(const StiffnessStream* s, u32 body) {
  real bound = (real)0;
  for (u32 k = s->body_joint_starts[body]; k < s->body_joint_starts[body + 1u]; ++k) {
    const BodyJoint at = s->body_joints[k];
    const JointInfo info = s->joint_infos[at.joint];
    global const JointImpulseBlock* given = s->joint_impulses + at.slot / PACK;
    const u32 lane = at.slot % PACK;
    real impulse = sum_of_sizes(make3(given->locked[0][lane], given->locked[1][lane], given->locked[2][lane]));
    if (info.free == FREE_TRAVEL || info.free == FREE_LENGTH)
      impulse = impulse + (fabs(given->free[lane]) + fabs(given->impedance[lane]));
    global const real* anchor = s->joints[at.joint].anchor_b;
    real arm = sum_of_sizes(make3(anchor[0], anchor[1], anchor[2])) +
               joint_sizes(s->screw_leads, s->rolling_radii, at.joint).radius;
    if (info.body_a == body) {
      const Vec3 x_b = info.body_b < s->bodies ? vec3_of(s->positions[info.body_b]) : make3((real)0, (real)0, (real)0);
      arm = arm + sum_of_sizes(sub3(x_b, vec3_of(s->positions[body])));
    }
    bound = bound + impulse * arm;
  }
  const Mass mass = s->masses[body];
  return (real)STIFF_INERTIA_SHARE * s->dt * bound * sum_of_sizes(vec3(mass.inverse_inertia)) < (real)0.984375f;
}

static inline bool is_too_light(const Mass mass, Vec3 stiffness, real dt) {
  const Vec3 shares = multiply3(scale3((real)STIFF_INERTIA_SHARE * dt, stiffness), vec3(mass.inverse_inertia));
  return shares.x > (real)1 || shares.y > (real)1 || shares.z > (real)1;
}

static inline Vec3 mean_rotation(const StiffnessStream* s, u32 body) {
  const Velocity own = s->previous_velocities[body];
  Vec3 sum = vec3(own.w);
  real count = (real)1;
  for (u32 k = s->body_joint_starts[body]; k < s->body_joint_starts[body + 1u]; ++k) {
    u32 joint = s->body_joints[k].joint, at = body;
    for (u32 hop = 0u; hop < STIFF_ROW; ++hop) {
      const JointInfo info = s->joint_infos[joint];
      at = info.body_a == at ? info.body_b : info.body_a;
      if (at >= s->bodies || at == body) break;
      const u32 first = s->body_joint_starts[at];
      if (s->body_joint_starts[at + 1u] - first != 2u) break;
      const Stiffness stiffness = geometric_stiffness(s, at);
      if (!is_too_light(s->masses[at], stiffness.own, s->dt)) break;
      const Velocity velocity = s->previous_velocities[at];
      sum = add3(sum, vec3(velocity.w));
      count = count + (real)1;
      joint = s->body_joints[s->body_joints[first].joint == joint ? first + 1u : first].joint;
    }
  }
  return scale3((real)1 / count, sum);
}

kernel void add_geometric_stiffness(const StepParams params, global const BodyInfo* body_infos,
                                    global const Mass* masses, global const Pivot* pivots,
                                    global const Sleeper* sleepers, global const Vec4* positions,
                                    global const Vec4* orientations, global const JointInfo* joint_infos,
                                    global const Joint* joints, global const real* screw_leads,
                                    global const real* rolling_radii, global const u32* body_joint_starts,
                                    global const BodyJoint* body_joints, global const JointImpulseBlock* joint_impulses,
                                    global Velocity* previous_velocities, global Motion* motions,
                                    global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  const StiffnessStream s = {params.bodies,       params.dt,   masses,        positions,   orientations,
                             previous_velocities, joint_infos, joints,        screw_leads, rolling_radii,
                             body_joint_starts,   body_joints, joint_impulses};
  FOR_EACH(i, params.bodies) {
    if (body_joint_starts[i] == body_joint_starts[i + 1u] || is_asleep(sleepers, i) || IS_PIVOTED(pivots, i)) continue;
    if (carries_little(&s, i)) continue;
    const Stiffness stiffness = geometric_stiffness(&s, i);
    Mass mass = masses[i];
    if (!is_too_light(mass, stiffness.own, params.dt)) continue;

    Vec3 k = add3(stiffness.own, stiffness.coupled);
    if (body_infos[i].isotropic != 0u) {
      const real yz = k.y < k.z ? k.z : k.y;
      k.x = k.y = k.z = k.x < yz ? yz : k.x;
    }
    const real least[3] = {k.x, k.y, k.z};
    real damped[3];
    for (u32 axis = 0u; axis < 3u; ++axis) {
      const real inertia = (real)STIFF_INERTIA_SHARE * params.dt * least[axis];
      const real share = inertia * mass.inverse_inertia[axis];
      damped[axis] = share > (real)1 ? (real)1 - (real)1 / share : (real)0;
      if (share > (real)1) mass.inverse_inertia[axis] = (real)1 / inertia;
    }
    Motion motion = motions[i];
    Quat q = quat(orientations[i]);
    const Velocity velocity = previous_velocities[i];
    if (acts_in_middle(&params, body_infos[i], false)) q = orientation_in_middle(q, vec3(velocity.w), params.dt);
    set_inverse_inertia(&motion, mass, body_infos[i], q);
    const Vec3 own = unrotate3(q, sub3(vec3(velocity.w), mean_rotation(&s, i)));
    const Vec3 lost = multiply3(make3(damped[0], damped[1], damped[2]), own);
    if (dot3(lost, lost) > (real)0) previous_velocities[i].damped = (real)1;
    store3(motion.w, sub3(vec3(motion.w), rotate3(q, lost)));
    motions[i] = motion;
  }
}
