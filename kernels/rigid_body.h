// What the motion stages share: access to a body's line, its inertia, its rotation and its pivot.
// cpu_reference/rigid_body.hpp says the same in C++ and gives the formulas.
#ifndef LOCKSTEP_RIGID_BODY_H
#define LOCKSTEP_RIGID_BODY_H

#include "math.h"

// What no body of the scene has is compiled out: the test is a constant.
#if FEATURE_PIVOTS
#define IS_PIVOTED(pivots, i) ((pivots)[i].pivoted != (real)0)
#else
#define IS_PIVOTED(pivots, i) false
#endif
#if FEATURE_LOADS || FEATURE_PARTICLES
#define IS_LOADED true
#else
#define IS_LOADED false
#endif
#if FEATURE_GYROSCOPIC
#define IS_GYROSCOPIC(params, info) ((params).gyroscopic != 0u && (info).isotropic == 0u)
#else
#define IS_GYROSCOPIC(params, info) false
#endif

static inline Vec3 vec3(const real* p) { return make3(p[0], p[1], p[2]); }
static inline Vec3 vec3_of(Vec4 a) { return make3(a.x, a.y, a.z); }
static inline void store3(real* p, Vec3 a) {
  p[0] = a.x;
  p[1] = a.y;
  p[2] = a.z;
}
static inline Vec3 multiply3(Vec3 a, Vec3 b) { return make3(a.x * b.x, a.y * b.y, a.z * b.z); }
static inline Vec3 mean3(real theta, Vec3 old_value, Vec3 new_value) {
  return add3(scale3((real)1 - theta, old_value), scale3(theta, new_value));
}

// Inverse inertia times a moment.
static inline Vec3 apply_inverse_inertia(Motion body, Vec3 moment) {
  return make3(body.inertia_xx * moment.x + body.inertia_xy * moment.y + body.inertia_xz * moment.z,
               body.inertia_xy * moment.x + body.inertia_yy * moment.y + body.inertia_yz * moment.z,
               body.inertia_xz * moment.x + body.inertia_yz * moment.y + body.inertia_zz * moment.z);
}

static inline bool is_bad3(Vec3 a) {
  const real d = (a.x - a.x) + (a.y - a.y) + (a.z - a.z);
  return !(d == (real)0);
}
static inline bool is_bad_velocity(Vec3 v, Vec3 w, real speed_limit) {
  return !(dot3(v, v) <= speed_limit * speed_limit) || is_bad3(w);
}
static inline bool is_bad_pose(Vec3 x, Quat q) {
  const real d = (q.x - q.x) + (q.y - q.y) + (q.z - q.z) + (q.w - q.w);
  return !(d == (real)0) || is_bad3(x);
}
static inline void report_bad(volatile global u32* counters, u32 status, u32 body) {
  atomic_or(&counters[COUNTER_STATUS], status);
  atomic_max(&counters[COUNTER_BAD_BODY], NONE - body);
}

static inline Velocity make_velocity(Vec3 v, Vec3 w) {
  Velocity velocity;
  store3(velocity.v, v);
  store3(velocity.w, w);
  velocity.pad_v = (real)0;
  velocity.damped = (real)0;
  return velocity;
}
static inline Vec4 make_vec4(Quat q) {
  Vec4 a;
  a.x = q.x;
  a.y = q.y;
  a.z = q.z;
  a.w = q.w;
  return a;
}

// tan(z) / z for y = z^2, as a fraction.
typedef struct TangentRatio {
  real numerator, denominator;
} TangentRatio;
static inline TangentRatio tangent_ratio(real y) {
  const real n = y * ((real)1 / (real)6409935 - y * ((real)1 / (real)13749310575.0));
  const real d = y * ((real)1 / (real)305235 - y * ((real)2 / (real)416645775));
  TangentRatio ratio;
  ratio.numerator = (real)1 - y * ((real)1 / (real)7 - y * ((real)4 / (real)855 - y * ((real)1 / (real)20349 - n)));
  ratio.denominator = (real)1 - y * ((real)10 / (real)21 - y * ((real)4 / (real)133 - y * ((real)8 / (real)14535 - d)));
  return ratio;
}
#define HALF_PI_SQUARED ((real)2.4674011002723395)

// The rotation of a body that rotates with w for dt; not of unit length.
static inline Quat rotation_by(Vec3 w, real dt) {
  Vec3 z = scale3((real)0.5 * dt, w);
  real y = dot3(z, z);
  if (y > HALF_PI_SQUARED) {
    const real pi = (real)3.14159265358979323846;
    const real angle = sqrt(y);
    const real rest = angle - floor(angle / pi + (real)0.5) * pi;
    z = scale3(rest / angle, z);
    y = rest * rest < HALF_PI_SQUARED ? rest * rest : HALF_PI_SQUARED;
  }
  const TangentRatio ratio = tangent_ratio(y);
  return make4(ratio.numerator * z.x, ratio.numerator * z.y, ratio.numerator * z.z, ratio.denominator);
}

static inline Vec3 rotate_by(Quat rotation, Vec3 v) {
  const Vec3 u = make3(rotation.x, rotation.y, rotation.z);
  const Vec3 t = add3(cross3(u, v), scale3(rotation.w, v));
  return add3(v, scale3((real)2 / (dot3(u, u) + rotation.w * rotation.w), cross3(u, t)));
}

static inline Quat integrate_orientation(Quat q, Vec3 w, real dt) { return unit4(multiply4(rotation_by(w, dt), q)); }

static inline Quat correct_orientation(Quat q, Vec3 angle) {
  const real h = (real)0.5;
  return unit4(multiply4(make4(h * angle.x, h * angle.y, h * angle.z, (real)1), q));
}

static inline FreeRotation make_free_rotation(Quat rotation, Vec3 w, real slack) {
  FreeRotation free;
  free.rotation[0] = rotation.x;
  free.rotation[1] = rotation.y;
  free.rotation[2] = rotation.z;
  free.rotation[3] = rotation.w;
  store3(free.w, w);
  free.slack = slack;
  return free;
}
static inline Quat free_rotation(FreeRotation free) {
  return make4(free.rotation[0], free.rotation[1], free.rotation[2], free.rotation[3]);
}
static inline bool is_free(FreeRotation free, Vec3 w) {
  const Vec3 change = sub3(w, vec3(free.w));
  return dot3(change, change) <= free.slack;
}

static inline Vec3 carry3(Quat old_q, Quat new_q, Vec3 a) { return rotate3(new_q, unrotate3(old_q, a)); }

static inline void set_inverse_inertia(Motion* motion, Mass mass, BodyInfo info, Quat q) {
  const Vec3 i = vec3(mass.inverse_inertia);
  if (info.kind != BODY_DYNAMIC) {
    motion->inertia_xx = motion->inertia_yy = motion->inertia_zz = (real)0;
    motion->inertia_xy = motion->inertia_xz = motion->inertia_yz = (real)0;
  } else if (info.isotropic != 0u) {
    motion->inertia_xx = motion->inertia_yy = motion->inertia_zz = i.x;
    motion->inertia_xy = motion->inertia_xz = motion->inertia_yz = (real)0;
  } else {
    const Vec3 a = rotate3(q, make3((real)1, (real)0, (real)0));
    const Vec3 b = rotate3(q, make3((real)0, (real)1, (real)0));
    const Vec3 c = rotate3(q, make3((real)0, (real)0, (real)1));
    motion->inertia_xx = i.x * (a.x * a.x) + i.y * (b.x * b.x) + i.z * (c.x * c.x);
    motion->inertia_yy = i.x * (a.y * a.y) + i.y * (b.y * b.y) + i.z * (c.y * c.y);
    motion->inertia_zz = i.x * (a.z * a.z) + i.y * (b.z * b.z) + i.z * (c.z * c.z);
    motion->inertia_xy = i.x * (a.x * a.y) + i.y * (b.x * b.y) + i.z * (c.x * c.y);
    motion->inertia_xz = i.x * (a.x * a.z) + i.y * (b.x * b.z) + i.z * (c.x * c.z);
    motion->inertia_yz = i.x * (a.y * a.z) + i.y * (b.y * b.z) + i.z * (c.y * c.z);
  }
}

static inline Vec3 gravity_moment_body(Pivot pivot, Mass mass, Quat q, Vec3 gravity) {
  return cross3(vec3(pivot.com_offset_body), scale3(mass.mass, unrotate3(q, gravity)));
}
static inline Vec3 com_offset_world(Pivot pivot, Quat q) { return rotate3(q, vec3(pivot.com_offset_body)); }

#endif
