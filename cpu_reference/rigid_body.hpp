// What the motion stages share: access to a body's line, its inertia, its rotation and its pivot.
// kernels/rigid_body.h says the same in OpenCL C.
#pragma once

#include <algorithm>
#include <vector>

#include "cpu_reference/math.hpp"

namespace lockstep::reference {

/// Whether the body turns about a fixed point; scenes without such bodies have no pivots.
template <class real>
bool is_pivoted(const std::vector<Pivot<real>>& pivots, u32 i) {
  return !pivots.empty() && pivots[i].pivoted != real(0);
}
/// Whether a dynamic body feels w x I w; of an isotropic body it is zero.
template <class real>
bool is_gyroscopic(const StepParams<real>& params, const BodyInfo& info) {
  return params.gyroscopic != 0 && info.isotropic == 0;
}

template <class real>
Vec3<real> vec3_of(Vec4<real> a) {
  return {a.x, a.y, a.z};
}
template <class real>
void store3(real* p, Vec3<real> a) {
  p[0] = a.x;
  p[1] = a.y;
  p[2] = a.z;
}
/// Component by component: a diagonal matrix times a vector.
template <class real>
Vec3<real> multiply3(Vec3<real> a, Vec3<real> b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
/// (1 - theta) old + theta new; exactly the old value at theta = 0 and the new one at theta = 1.
template <class real>
Vec3<real> mean3(real theta, Vec3<real> old_value, Vec3<real> new_value) {
  return add3(scale3(real(1) - theta, old_value), scale3(theta, new_value));
}

/// Inverse inertia times a moment, world frame.
template <class real>
Vec3<real> apply_inverse_inertia(const Motion<real>& body, Vec3<real> moment) {
  return {body.inertia_xx * moment.x + body.inertia_xy * moment.y + body.inertia_xz * moment.z,
          body.inertia_xy * moment.x + body.inertia_yy * moment.y + body.inertia_yz * moment.z,
          body.inertia_xz * moment.x + body.inertia_yz * moment.y + body.inertia_zz * moment.z};
}

// x - x is zero for every finite x and NaN for the others; a test that NaN fails is written as "not good".
template <class real>
bool is_bad3(Vec3<real> a) {
  const real d = (a.x - a.x) + (a.y - a.y) + (a.z - a.z);
  return !(d == real(0));
}
template <class real>
bool is_bad_velocity(Vec3<real> v, Vec3<real> w, real speed_limit) {
  return !(dot3(v, v) <= speed_limit * speed_limit) || is_bad3(w);
}
template <class real>
bool is_bad_pose(Vec3<real> x, Quat<real> q) {
  const real d = (q.x - q.x) + (q.y - q.y) + (q.z - q.z) + (q.w - q.w);
  return !(d == real(0)) || is_bad3(x);
}
/// Names the body of smallest index, whichever was found first.
inline void report_bad(std::vector<u32>& counters, u32 status, u32 body) {
  counters[COUNTER_STATUS] |= status;
  counters[COUNTER_BAD_BODY] = std::max(counters[COUNTER_BAD_BODY], NONE - body);
}

/// Whether a list was full or somebody woke: stages that write persistent state then leave it alone (STATUS_ABORTED).
inline bool step_aborted(const std::vector<u32>& counters) { return (counters[COUNTER_STATUS] & STATUS_ABORTED) != 0; }

template <class real>
Velocity<real> make_velocity(Vec3<real> v, Vec3<real> w) {
  return {{v.x, v.y, v.z}, real(0), {w.x, w.y, w.z}, real(0)};
}
template <class real>
Vec4<real> make_vec4(Quat<real> q) {
  return {q.x, q.y, q.z, q.w};
}

/// tan(z) / z for y = z^2, as a fraction: the eleventh convergent of z / (1 - y / (3 - y / (5 - ...))) (Lambert 1768),
/// exact to rounding in double for |z| up to pi / 2, where the denominator is zero.
template <class real>
struct TangentRatio {
  real numerator, denominator;
};
template <class real>
TangentRatio<real> tangent_ratio(real y) {
  const real n = y * (real(1) / real(6409935) - y * (real(1) / real(13749310575.0)));
  const real d = y * (real(1) / real(305235) - y * (real(2) / real(416645775)));
  return {real(1) - y * (real(1) / real(7) - y * (real(4) / real(855) - y * (real(1) / real(20349) - n))),
          real(1) - y * (real(10) / real(21) - y * (real(4) / real(133) - y * (real(8) / real(14535) - d)))};
}
/// Half angles are taken modulo pi beyond pi / 2.
template <class real>
constexpr real half_pi_squared = real(2.4674011002723395);

/// The rotation of a body that rotates with w for dt, by the angle |w| dt: (N z, D) along the quaternion
/// (sin |z| z / |z|, cos |z|), z = w dt / 2 and N / D = tan |z| / |z|. Not of unit length.
template <class real>
Quat<real> rotation_by(Vec3<real> w, real dt) {
  Vec3<real> z = scale3(real(0.5) * dt, w);
  real y = dot3(z, z);
  if (y > half_pi_squared<real>) {
    const real pi = real(3.14159265358979323846);
    const real angle = std::sqrt(y);
    const real rest = angle - std::floor(angle / pi + real(0.5)) * pi;
    z = scale3(rest / angle, z);
    y = rest * rest < half_pi_squared<real> ? rest * rest : half_pi_squared<real>;  // a huge angle is all rounding
  }
  const TangentRatio<real> ratio = tangent_ratio(y);
  return {ratio.numerator * z.x, ratio.numerator * z.y, ratio.numerator * z.z, ratio.denominator};
}

/// v rotated by a quaternion of any length. What is added to v is small where v is nearly along the axis, and so is its
/// rounding.
template <class real>
Vec3<real> rotate_by(Quat<real> rotation, Vec3<real> v) {
  const Vec3<real> u = {rotation.x, rotation.y, rotation.z};
  const Vec3<real> t = add3(cross3(u, v), scale3(rotation.w, v));
  return add3(v, scale3(real(2) / (dot3(u, u) + rotation.w * rotation.w), cross3(u, t)));
}

/// The orientation after rotating with w (world frame) for dt: that of the differential equation q' = G(q) w
/// (survey eq. 1) for a constant w.
template <class real>
Quat<real> integrate_orientation(Quat<real> q, Vec3<real> w, real dt) {
  return unit4(multiply4(rotation_by(w, dt), q));
}

/// The orientation after a small rotation vector: the Cayley map, which rotates by 2 atan(|angle| / 2). It misses by a
/// twelfth of the angle's cube, which does not count where an iteration corrects what it leaves.
template <class real>
Quat<real> correct_orientation(Quat<real> q, Vec3<real> angle) {
  const real h = real(0.5);
  return unit4(multiply4(Quat<real>{h * angle.x, h * angle.y, h * angle.z, real(1)}, q));
}

template <class real>
FreeRotation<real> make_free_rotation(Quat<real> rotation, Vec3<real> w, real slack) {
  return {{rotation.x, rotation.y, rotation.z, rotation.w}, {w.x, w.y, w.z}, slack};
}
template <class real>
Quat<real> free_rotation(const FreeRotation<real>& free) {
  return {free.rotation[0], free.rotation[1], free.rotation[2], free.rotation[3]};
}
/// Whether no impulse has changed the angular velocity since.
template <class real>
bool is_free(const FreeRotation<real>& free, Vec3<real> w) {
  const Vec3<real> change = sub3(w, vec3(free.w));
  return dot3(change, change) <= free.slack;
}

/// A vector that keeps its components in the body frame while the body turns.
template <class real>
Vec3<real> carry3(Quat<real> old_q, Quat<real> new_q, Vec3<real> a) {
  return rotate3(new_q, unrotate3(old_q, a));
}

/// R I^-1 R^T, in the world frame (survey 2.1.5); zero for immovable bodies. An isotropic body needs no rotation, and
/// its off-diagonals are exactly zero.
template <class real>
void set_inverse_inertia(Motion<real>& motion, const Mass<real>& mass, const BodyInfo& info, Quat<real> q) {
  const Vec3<real> i = vec3(mass.inverse_inertia);
  if (info.kind != BODY_DYNAMIC) {
    motion.inertia_xx = motion.inertia_yy = motion.inertia_zz = real(0);
    motion.inertia_xy = motion.inertia_xz = motion.inertia_yz = real(0);
  } else if (info.isotropic != 0) {
    motion.inertia_xx = motion.inertia_yy = motion.inertia_zz = i.x;
    motion.inertia_xy = motion.inertia_xz = motion.inertia_yz = real(0);
  } else {
    const Vec3<real> a = rotate3(q, Vec3<real>{real(1), real(0), real(0)});
    const Vec3<real> b = rotate3(q, Vec3<real>{real(0), real(1), real(0)});
    const Vec3<real> c = rotate3(q, Vec3<real>{real(0), real(0), real(1)});
    motion.inertia_xx = i.x * (a.x * a.x) + i.y * (b.x * b.x) + i.z * (c.x * c.x);
    motion.inertia_yy = i.x * (a.y * a.y) + i.y * (b.y * b.y) + i.z * (c.y * c.y);
    motion.inertia_zz = i.x * (a.z * a.z) + i.y * (b.z * b.z) + i.z * (c.z * c.z);
    motion.inertia_xy = i.x * (a.x * a.y) + i.y * (b.x * b.y) + i.z * (c.x * c.y);
    motion.inertia_xz = i.x * (a.x * a.z) + i.y * (b.x * b.z) + i.z * (c.x * c.z);
    motion.inertia_yz = i.x * (a.y * a.z) + i.y * (b.y * b.z) + i.z * (c.y * c.z);
  }
}

/// com_offset x m g: the moment of gravity about the pivot, body frame.
template <class real>
Vec3<real> gravity_moment_body(const Pivot<real>& pivot, const Mass<real>& mass, Quat<real> q, Vec3<real> gravity) {
  return cross3(vec3(pivot.com_offset_body), scale3(mass.mass, unrotate3(q, gravity)));
}
/// From the pivot to the centre of mass, world frame.
template <class real>
Vec3<real> com_offset_world(const Pivot<real>& pivot, Quat<real> q) {
  return rotate3(q, vec3(pivot.com_offset_body));
}

}  // namespace lockstep::reference
