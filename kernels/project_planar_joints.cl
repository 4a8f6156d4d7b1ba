#pragma OPENCL FP_CONTRACT OFF
// Keeps bodies in the planes of their planar joints (cpu_reference/project_planar_joints.hpp states the method).
#include "common.h"
#include "joints/current_joint.h"
#include "joints/displace.h"
#include "rigid_body.h"
#include "sleep.h"
#include "types.h"

kernel void project_planar_joints(const StepParams params, const u32 planar_count, global const BodyInfo* body_infos,
                                  global const Sleeper* sleepers, global const JointInfo* joint_infos,
                                  global const Joint* joints, global const u32* planar_joints, global Vec4* positions,
                                  global Vec4* orientations, global Motion* motions, global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(i, planar_count) {
    const JointInfo info = joint_infos[planar_joints[i]];
    const Joint joint = joints[planar_joints[i]];
    const bool b_moves = info.body_b < params.bodies && body_infos[info.body_b].kind == BODY_DYNAMIC;
    const u32 body = b_moves ? info.body_b : info.body_a, other = b_moves ? info.body_a : info.body_b;
    if (is_asleep(sleepers, body)) continue;
    Vec3 x, x_other;
    Quat q, q_other;
    joint_pose(body, params.bodies, positions, orientations, &x, &q);
    joint_pose(other, params.bodies, positions, orientations, &x_other, &q_other);
    const Quat frame = joint_frame(b_moves ? joint.frame_b : joint.frame_a);
    const Quat frame_other = joint_frame(b_moves ? joint.frame_a : joint.frame_b);
    const Vec3 z = make3((real)0, (real)0, (real)1);
    const Vec3 n = rotate3(multiply4(q_other, frame_other), z), u = rotate3(multiply4(q, frame), z);

    const Vec3 axis = cross3(u, n);
    const real along = dot3(u, n);
    if (along > (real)0) q = unit4(multiply4(make4(axis.x, axis.y, axis.z, (real)1 + along), q));
    const Vec3 anchor = add3(x, rotate3(q, vec3(b_moves ? joint.anchor_b : joint.anchor_a)));
    const Vec3 fixed = add3(x_other, rotate3(q_other, vec3(b_moves ? joint.anchor_a : joint.anchor_b)));
    x = sub3(x, scale3(dot3(n, sub3(anchor, fixed)), n));

    Motion motion = motions[body];
    const Vec3 v = vec3(motion.v), w = vec3(motion.w);
    store3(motion.v, sub3(v, scale3(dot3(n, v), n)));
    store3(motion.w, scale3(dot3(n, w), n));
    motions[body] = motion;
    store_displaced(body, x, q, positions, orientations, counters);
  }
}
