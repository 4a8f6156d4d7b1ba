// Vectors and quaternions of the reference. kernels/math.h says the same in OpenCL C, written by hand, operation by
// operation.
#pragma once

#if defined(__FAST_MATH__)
#error "the reference promises bits: build it without fast-math"
#endif

#include <cmath>

#include "kernels/types.h"

namespace lockstep::reference {

template <class real>
struct Vec3 {
  real x, y, z;
};

/// A unit quaternion x y z w rotates body into world coordinates (survey 2.1.2).
template <class real>
struct Quat {
  real x, y, z, w;
};

template <class real>
Vec3<real> vec3(const real* p) {
  return {p[0], p[1], p[2]};
}
template <class real>
Vec3<real> add3(Vec3<real> a, Vec3<real> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class real>
Vec3<real> sub3(Vec3<real> a, Vec3<real> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class real>
Vec3<real> scale3(real s, Vec3<real> a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class real>
real dot3(Vec3<real> a, Vec3<real> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class real>
Vec3<real> cross3(Vec3<real> a, Vec3<real> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class real>
real length3(Vec3<real> a) {
  return std::sqrt(dot3(a, a));
}
template <class real>
Vec3<real> absolute3(Vec3<real> a) {
  return {std::abs(a.x), std::abs(a.y), std::abs(a.z)};
}

template <class real>
Quat<real> quat(Vec4<real> q) {
  return {q.x, q.y, q.z, q.w};
}
/// Hamilton product: first b, then a.
template <class real>
Quat<real> multiply4(Quat<real> a, Quat<real> b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
template <class real>
Quat<real> unit4(Quat<real> q) {
  const real s = real(1) / std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {s * q.x, s * q.y, s * q.z, s * q.w};
}
/// Body to world: v + 2 u x (u x v + w v) with u the vector part.
template <class real>
Vec3<real> rotate3(Quat<real> q, Vec3<real> v) {
  const Vec3<real> u = {q.x, q.y, q.z};
  const Vec3<real> t = add3(cross3(u, v), scale3(q.w, v));
  return add3(v, scale3(real(2), cross3(u, t)));
}
/// World to body.
template <class real>
Vec3<real> unrotate3(Quat<real> q, Vec3<real> v) {
  return rotate3(Quat<real>{-q.x, -q.y, -q.z, q.w}, v);
}

}  // namespace lockstep::reference
