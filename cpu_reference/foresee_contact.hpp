// Where a contact will be within the sub-step, by the velocities of its start. kernels/foresee_contact.h is the twin.
//
// A law of the velocity at the end alone lets points that go along arcs drift out of their contact, to first order:
// what rocks or rolls on its rim gains or loses energy. Where overlap is taken back by poses (feature
// separated_contacts) contacts act where they are at (1 - theta) h, as joints do, and their normal law is that of the
// end: with J the row of the normal, and v_free the velocities after the forces, it is biased by
//   c (J(h) - J((1 - theta) h)) v_free,   c = 1 where old velocities move the bodies too, else 1/2
// so that old and new velocities are along the chord to second order. Energy stays as the midpoint rule has it.
//
// Anchors are points of the bodies, but the lowest point of a rim runs on it: it stays in the plane of the axis and the
// normal, which goes round the normal with what is across the axis of the angular velocity.
//
// What a body that rotates by itself carries is foreseen by predict_arms, whatever takes overlap back.
#pragma once

#include <cmath>

#include "cpu_reference/current_contact.hpp"
#include "cpu_reference/rigid_body.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// By how much a rim may run on in the time foreseen, rad: of what lies flat any point may be the lowest next.
template <class real>
constexpr real rim_foresight = real(0.5);

/// Whether nothing can push the body and it rotates.
template <class real>
bool rotates_by_itself(const Motion<real>& body) {
  return body.inverse_mass == real(0) && dot3(vec3(body.w), vec3(body.w)) > real(0);
}

/// One side of a contact: its body at the start of the sub-step, and the axis of its rim, world frame, or 0.
template <class real>
struct ForeseenSide {
  Pose<real> pose;
  Vec3<real> v, w, axis;
};

/// The pose after `time`, a small rotation.
template <class real>
Pose<real> predicted_pose(const Pose<real>& pose, Vec3<real> v, Vec3<real> w, real time) {
  return {add3(pose.position, scale3(time, v)), correct_orientation(pose.orientation, scale3(time, w))};
}

/// The angular velocity that takes the point of a contact along: that of the body, or with a rim.
template <class real>
Vec3<real> rim_velocity(Vec3<real> w, Vec3<real> axis, Vec3<real> normal, real step) {
  const real along = dot3(axis, w), cosine = dot3(axis, normal);
  const real square = real(1) - cosine * cosine;
  const real runs = cosine * (dot3(normal, w) - cosine * along) / square;
  const bool follows = square > 0 && std::fabs(step * runs) < rim_foresight<real>;
  return add3(w, scale3((follows ? runs : real(0)) - along, axis));
}

/// The contact after `time`; `normal` is that of now.
template <class real>
CurrentContact<real> contact_after(const ContactPoint<real>& point, u32 frame, const ForeseenSide<real>& a,
                                   const ForeseenSide<real>& b, Vec3<real> normal, real step, real time) {
  return current_contact(point, frame, predicted_pose(a.pose, a.v, rim_velocity(a.w, a.axis, normal, step), time),
                         predicted_pose(b.pose, b.v, rim_velocity(b.w, b.axis, normal, step), time));
}

/// Points of a body that rotates by itself go along arcs, whose chord is along the velocity in the middle of the
/// sub-step; along that of its start what rests on a turntable is moved outwards. The velocities of such pairs are
/// taken where the contact will be, with the velocities of the start, at the time for which that makes their mean the
/// chord to second order: (1 - theta) u_old + theta u_new, u_new taken at h / (2 theta).
template <class real>
void predict_arms(const StepParams<real>& p, const ContactPoint<real>& point, u32 frame, const ForeseenSide<real>& a,
                  const ForeseenSide<real>& b, CurrentContact<real>& current) {
  if (!(p.theta > real(0)) || frame == NORMAL_OF_IMPACT) return;
  const real time = real(0.5) * p.dt / p.theta;
  const CurrentContact<real> predicted =
      current_contact(point, frame, predicted_pose(a.pose, a.v, a.w, time), predicted_pose(b.pose, b.v, b.w, time));
  current.arm_a = predicted.arm_a;
  current.arm_b = predicted.arm_b;
}

}  // namespace lockstep::reference
