// A body that a planar joint ties to what cannot move has three coordinates and no others (a 2-D world). Sweeps leave a
// rest in the locked ones, which contacts push further; at the end of each sub-step this takes it away. With n the axis
// of the fixed side, u that of the body, and d from the fixed anchor to the body's:
//
//   q' = unit(u x n, 1 + u . n) q      the shortest rotation from u to n, where that is less than a quarter
//   x' = x - n (n . d)                 d with the new orientation
//   w' = n (n . w),   v' = v - n (n . v)
//
// What the body does in the plane stays as it is.
#pragma once

#include "cpu_reference/joints/current_joint.hpp"
#include "cpu_reference/rigid_body.hpp"
#include "cpu_reference/sleep.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
void project_planar_joints(Buffers<real>& b, const StepParams<real>& params) {
  if (step_aborted(b.counters)) return;
  for (const u32 index : b.planar_joints) {
    const JointInfo info = b.joint_infos[index];
    const Joint<real>& joint = b.joints[index];
    const bool b_moves = info.body_b < params.bodies && b.body_infos[info.body_b].kind == BODY_DYNAMIC;
    const u32 body = b_moves ? info.body_b : info.body_a, other = b_moves ? info.body_a : info.body_b;
    if (is_asleep(b, body)) continue;
    Vec3<real> x, x_other;
    Quat<real> q, q_other;
    joint_pose(b, params, body, x, q);
    joint_pose(b, params, other, x_other, q_other);
    const Quat<real> frame = joint_frame(b_moves ? joint.frame_b : joint.frame_a);
    const Quat<real> frame_other = joint_frame(b_moves ? joint.frame_a : joint.frame_b);
    const Vec3<real> z = {0, 0, 1};
    const Vec3<real> n = rotate3(multiply4(q_other, frame_other), z), u = rotate3(multiply4(q, frame), z);

    const Vec3<real> axis = cross3(u, n);
    const real along = dot3(u, n);
    if (along > 0) q = unit4(multiply4(Quat<real>{axis.x, axis.y, axis.z, real(1) + along}, q));
    const Vec3<real> anchor = add3(x, rotate3(q, vec3(b_moves ? joint.anchor_b : joint.anchor_a)));
    const Vec3<real> fixed = add3(x_other, rotate3(q_other, vec3(b_moves ? joint.anchor_a : joint.anchor_b)));
    x = sub3(x, scale3(dot3(n, sub3(anchor, fixed)), n));

    Motion<real>& motion = b.motions[body];
    const Vec3<real> v = vec3(motion.v), w = vec3(motion.w);
    store3(motion.v, sub3(v, scale3(dot3(n, v), n)));
    store3(motion.w, scale3(dot3(n, w), n));
    Vec4<real>& position = b.positions[body];
    position.x = x.x;
    position.y = x.y;
    position.z = x.z;
    b.orientations[body] = make_vec4(q);
    if (is_bad_pose(x, q)) report_bad(b.counters, STATUS_BAD_POSE, body);
  }
}

}  // namespace lockstep::reference
