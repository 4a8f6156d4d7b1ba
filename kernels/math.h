// Vectors and quaternions of the kernels. cpu_reference/math.hpp says the same in C++, written by hand, operation by
// operation.
#ifndef LOCKSTEP_MATH_H
#define LOCKSTEP_MATH_H

#include "types.h"

typedef struct Vec3 {
  real x, y, z;
} Vec3;

// A unit quaternion x y z w rotates body into world coordinates (survey 2.1.2).
typedef struct Quat {
  real x, y, z, w;
} Quat;

static inline Vec3 make3(real x, real y, real z) {
  Vec3 v;
  v.x = x;
  v.y = y;
  v.z = z;
  return v;
}
static inline Quat make4(real x, real y, real z, real w) {
  Quat q;
  q.x = x;
  q.y = y;
  q.z = z;
  q.w = w;
  return q;
}
static inline Vec3 add3(Vec3 a, Vec3 b) { return make3(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline Vec3 sub3(Vec3 a, Vec3 b) { return make3(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline Vec3 scale3(real s, Vec3 a) { return make3(s * a.x, s * a.y, s * a.z); }
static inline real dot3(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline Vec3 cross3(Vec3 a, Vec3 b) {
  return make3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline real length3(Vec3 a) { return sqrt(dot3(a, a)); }
static inline Vec3 absolute3(Vec3 a) { return make3(fabs(a.x), fabs(a.y), fabs(a.z)); }

static inline Quat quat(Vec4 q) { return make4(q.x, q.y, q.z, q.w); }
// Hamilton product: first b, then a.
static inline Quat multiply4(Quat a, Quat b) {
  return make4(a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
               a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z);
}
static inline Quat unit4(Quat q) {
  const real s = (real)1 / sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return make4(s * q.x, s * q.y, s * q.z, s * q.w);
}
// Body to world: v + 2 u x (u x v + w v) with u the vector part.
static inline Vec3 rotate3(Quat q, Vec3 v) {
  const Vec3 u = make3(q.x, q.y, q.z);
  const Vec3 t = add3(cross3(u, v), scale3(q.w, v));
  return add3(v, scale3((real)2, cross3(u, t)));
}
// World to body.
static inline Vec3 unrotate3(Quat q, Vec3 v) { return rotate3(make4(-q.x, -q.y, -q.z, q.w), v); }

#endif
