// A joint at the current poses of its bodies. kernels/joints/current_joint.h is the twin.
//
// A universal joint (Cardan's or Hooke's) has a cross, whose first arm is z of the frame on a and whose second is x of
// the frame on b. The locked angle keeps them perpendicular: with n = z_a x x_b the error is -z_a . x_b, and its rate
// n . (w_b - w_a). The joint's frame is that of the cross, (n x z_a, n, z_a): it turns with z_a in a, by the angle of
// the first arm, so that the locked row is that of y. (Shabana, Computational Dynamics, 2010, 3.3 has the conditions.)
//
// Angles are those in -pi .. pi; cpu_reference/joints/revolutions.hpp adds their revolutions.
//
// A screw ties what a hinge and a slider leave free: travel = lead angle, lead = pitch / 2 pi, m a radian. Its
// revolutions are not remembered: of all that its thread allows the angle is the one nearest to what the travel says,
// right as long as a step leaves less than half a pitch of error.
//
// Two kinds lock velocities that no condition on poses stands for (non-holonomic, survey 2.2), and are never off in
// them. A skate may not move along the axis, which is fixed in b: its edge turns with it. A ball that rolls has b's
// anchor in its centre, and its arms end where it touches, a radius down the axis, the normal of a plane that is fixed
// in a: what of b is there does not move against what of a is there. In the plane that is a velocity alone; across it
// the centre keeps its height.
#pragma once

#include "cpu_reference/joints/angle.hpp"
#include "cpu_reference/rigid_body.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// World frame. The axes are fixed in a, and what b's anchor and frame are in them is the joint's error. Both arms end
/// at b's anchor, or where b rolls: there the impulses act, on both bodies, so that a joint that has come apart still
/// keeps the angular momentum, and the velocity of a linear row is exactly the rate of its error.
template <class real>
struct CurrentJoint {
  Vec3<real> axes[3];
  Vec3<real> arm_a, arm_b;
  real error[JOINT_ROWS];  // m; rad: twice the vector part of the rotation from a's frame to b's, or where fewer angles
                           // are locked the sine by which b's axis is off
  Vec3<real> free_axis;
  real coordinate;  // the free one, m or rad
  real expected;    // of an angle that counts revolutions, rad: where its velocity brings it
  real lead;        // of a screw, m a radian; 0 of others
  real radius;      // of what rolls, m; 0 of others
};

/// The pose of a body; of the null body that of the world.
template <class real>
void joint_pose(const Buffers<real>& b, const StepParams<real>& params, u32 body, Vec3<real>& x, Quat<real>& q) {
  x = body < params.bodies ? vec3_of(b.positions[body]) : Vec3<real>{0, 0, 0};
  q = body < params.bodies ? quat(b.orientations[body]) : Quat<real>{0, 0, 0, 1};
}

template <class real>
Quat<real> joint_frame(const real (&q)[4]) {
  return {q[0], q[1], q[2], q[3]};
}

/// What only some joints have; 0 of the others, and of all in scenes that have none.
template <class real>
struct JointSizes {
  real lead;    // of a screw, m a radian
  real radius;  // of what rolls, m
};

template <class real>
JointSizes<real> joint_sizes(const Buffers<real>& b, u32 index) {
  return {b.screw_leads.empty() ? real(0) : b.screw_leads[index],
          b.rolling_radii.empty() ? real(0) : b.rolling_radii[index]};
}

/// Turns the frame in a about z to that of the cross; `second` is the second arm in that frame.
template <class real>
void rotate_to_cross(CurrentJoint<real>& current, Vec3<real> second) {
  const real level = std::sqrt(second.x * second.x + second.y * second.y);
  current.coordinate = direction_angle(second.x, second.y, level);
  if (!(level > 0)) return;  // both arms are one
  const real c = second.x / level, s = second.y / level;
  const Vec3<real> x = current.axes[0], y = current.axes[1];
  current.axes[0] = add3(scale3(c, x), scale3(s, y));
  current.axes[1] = sub3(scale3(c, y), scale3(s, x));
}

template <class real>
CurrentJoint<real> current_joint(const Joint<real>& joint, const JointInfo& info, JointSizes<real> sizes,
                                 Vec3<real> x_a, Quat<real> q_a, Vec3<real> x_b, Quat<real> q_b) {
  CurrentJoint<real> current = {};
  const Quat<real> frame_a = multiply4(q_a, joint_frame(joint.frame_a));
  const Quat<real> frame_b = multiply4(q_b, joint_frame(joint.frame_b));
  current.axes[0] = rotate3(frame_a, Vec3<real>{1, 0, 0});
  current.axes[1] = rotate3(frame_a, Vec3<real>{0, 1, 0});
  current.axes[2] = rotate3(frame_a, Vec3<real>{0, 0, 1});
  current.arm_b = rotate3(q_b, vec3(joint.anchor_b));
  current.arm_a = add3(sub3(x_b, x_a), current.arm_b);
  const Vec3<real> d = sub3(current.arm_a, rotate3(q_a, vec3(joint.anchor_a)));

  Quat<real> rotation = multiply4(Quat<real>{-frame_a.x, -frame_a.y, -frame_a.z, frame_a.w}, frame_b);
  if (rotation.w < 0) rotation = {-rotation.x, -rotation.y, -rotation.z, -rotation.w};
  if ((info.locked >> 5 & 1) != 0) {
    current.error[3] = real(2) * rotation.x;
    current.error[4] = real(2) * rotation.y;
    current.error[5] = real(2) * rotation.z;
  } else if (LOCKS_CROSS(info.locked)) {
    const Vec3<real> second = rotate3(rotation, Vec3<real>{1, 0, 0});
    current.error[4] = -second.z;
    rotate_to_cross(current, second);
  } else {
    const Vec3<real> axis_b = rotate3(rotation, Vec3<real>{0, 0, 1});
    current.error[3] = -axis_b.y;
    current.error[4] = axis_b.x;
  }
  for (u32 i = 0; i < 3; ++i) current.error[i] = dot3(current.axes[i], d);

  current.free_axis = current.axes[2];
  if (info.free == FREE_ANGLE && !LOCKS_CROSS(info.locked)) current.coordinate = rotation_angle(rotation.z, rotation.w);
  if (info.free == FREE_TRAVEL) current.coordinate = current.error[2];
  if (info.free == FREE_LENGTH) {
    current.coordinate = length3(d);
    if (current.coordinate > 0)
      current.free_axis = {d.x / current.coordinate, d.y / current.coordinate, d.z / current.coordinate};
  }
  current.lead = sizes.lead;
  if (sizes.lead != 0) {
    const real two_pi = real(6.283185307179586);
    const real revolutions = std::floor((current.error[2] / sizes.lead - current.coordinate) / two_pi + real(0.5));
    current.coordinate = current.coordinate + two_pi * revolutions;
    current.error[2] = current.error[2] - sizes.lead * current.coordinate;
  }
  if (LOCKS_SKATE(info.locked)) {
    current.axes[0] = rotate3(frame_b, Vec3<real>{1, 0, 0});
    current.axes[1] = rotate3(frame_b, Vec3<real>{0, 1, 0});
    current.axes[2] = rotate3(frame_b, Vec3<real>{0, 0, 1});
    current.error[2] = 0;
  }
  current.radius = sizes.radius;
  if (sizes.radius > 0) {
    const Vec3<real> down = scale3(-sizes.radius, current.axes[2]);
    current.arm_a = add3(current.arm_a, down);
    current.arm_b = add3(current.arm_b, down);
    current.error[0] = 0;
    current.error[1] = 0;
  }
  return current;
}

}  // namespace lockstep::reference
