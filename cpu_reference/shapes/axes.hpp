// The axes of a turned shape, and parts of shapes that several pairs need. kernels/shapes/axes.h is the twin.
#pragma once

#include "cpu_reference/shapes/manifold.hpp"

namespace lockstep::reference {

/// The axes of a frame in another one: the columns of its rotation matrix.
template <class real>
struct Axes {
  Vec3<real> x, y, z;
};

/// Of a unit quaternion (survey 2.1.2).
template <class real>
Axes<real> axes_of(Quat<real> q) {
  const real x2 = q.x + q.x, y2 = q.y + q.y, z2 = q.z + q.z;
  const real xx = q.x * x2, yy = q.y * y2, zz = q.z * z2;
  const real xy = q.x * y2, xz = q.x * z2, yz = q.y * z2;
  const real wx = q.w * x2, wy = q.w * y2, wz = q.w * z2;
  Axes<real> axes;
  axes.x = Vec3<real>{real(1) - (yy + zz), xy + wz, xz - wy};
  axes.y = Vec3<real>{xy - wz, real(1) - (xx + zz), yz + wx};
  axes.z = Vec3<real>{xz + wy, yz - wx, real(1) - (xx + yy)};
  return axes;
}

/// The axes of the other frame in this one.
template <class real>
Axes<real> transposed(Axes<real> axes) {
  return {{axes.x.x, axes.y.x, axes.z.x}, {axes.x.y, axes.y.y, axes.z.y}, {axes.x.z, axes.y.z, axes.z.z}};
}

template <class real>
Vec3<real> axis_of(Axes<real> axes, u32 k) {
  return k == 0 ? axes.x : k == 1 ? axes.y : axes.z;
}

template <class real>
Vec3<real> into_frame(Axes<real> axes, Vec3<real> v) {
  return Vec3<real>{dot3(axes.x, v), dot3(axes.y, v), dot3(axes.z, v)};
}

template <class real>
Vec3<real> out_of_frame(Axes<real> axes, Vec3<real> v) {
  return add3(add3(scale3(v.x, axes.x), scale3(v.y, axes.y)), scale3(v.z, axes.z));
}

template <class real>
real clamp_to(real x, real limit) {
  return x < -limit ? -limit : x > limit ? limit : x;
}

/// From core point b to core point a, or `fallback` where they coincide but for the rounding of shapes of
/// this size.
template <class real>
Vec3<real> direction_between(Vec3<real> a, Vec3<real> b, real size, Vec3<real> fallback) {
  const Vec3<real> d = sub3(a, b);
  const real distance = length3(d);
  return distance > real(1e-6) * size ? Vec3<real>{d.x / distance, d.y / distance, d.z / distance} : fallback;
}

/// The i-th sixteenth of the way around, from x by way of y.
template <class real>
Vec3<real> around_sixteenth(Vec3<real> x, Vec3<real> y, u32 i) {
  const real cosines[5] = {real(1), real(0.92387953251128674), real(0.70710678118654752), real(0.38268343236508977),
                           real(0)};
  const u32 k = i & 7;
  const real c = k < 5 ? cosines[k] : -cosines[8 - k], s = k < 5 ? cosines[4 - k] : cosines[k - 4];
  const real side = (i & 8) == 0 ? real(1) : real(-1);
  return add3(scale3(side * c, x), scale3(side * s, y));
}

/// Adds a point to a manifold whose normal is set.
template <class real>
Manifold<real> with_point(Manifold<real> m, Vec3<real> anchor_a, Vec3<real> anchor_b, u32 feature) {
  m.points[m.count].anchor_a = anchor_a;
  m.points[m.count].anchor_b = anchor_b;
  m.points[m.count].feature = feature;
  m.count = m.count + 1;
  return m;
}

/// A manifold without points yet.
template <class real>
Manifold<real> manifold_along(Vec3<real> normal, u32 frame, real radius_a, real radius_b) {
  Manifold<real> m = {};
  m.normal = normal;
  m.frame = frame;
  m.radius_a = radius_a;
  m.radius_b = radius_b;
  return m;
}

}  // namespace lockstep::reference
