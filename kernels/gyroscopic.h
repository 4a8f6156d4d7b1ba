// Euler's equations of a rotating body, in its principal frame. cpu_reference/gyroscopic.hpp says the same in C++ and
// gives the formulas.
#ifndef LOCKSTEP_GYROSCOPIC_H
#define LOCKSTEP_GYROSCOPIC_H

#include "rigid_body.h"

#define GYROSCOPIC_ITERATIONS 8u
#define MAX_GYROSCOPIC_SUBSTEPS 64u

static inline Vec3 gyroscopic_ratios(Mass mass) {
  return make3((mass.inertia[2] - mass.inertia[1]) * mass.inverse_inertia[0],
               (mass.inertia[0] - mass.inertia[2]) * mass.inverse_inertia[1],
               (mass.inertia[1] - mass.inertia[0]) * mass.inverse_inertia[2]);
}
static inline Vec3 gyroscopic_term(Vec3 ratios, Vec3 w) {
  return make3(ratios.x * (w.y * w.z), ratios.y * (w.z * w.x), ratios.z * (w.x * w.y));
}

static inline Vec3 solve3(Vec3 row_x, Vec3 row_y, Vec3 row_z, Vec3 right) {
  const Vec3 yz = cross3(row_y, row_z);
  const Vec3 zx = cross3(row_z, row_x);
  const Vec3 xy = cross3(row_x, row_y);
  const Vec3 sum = add3(add3(scale3(right.x, yz), scale3(right.y, zx)), scale3(right.z, xy));
  return scale3((real)1 / dot3(row_x, yz), sum);
}

static inline Vec3 gyroscopic_substep(Vec3 ratios, Vec3 w, Vec3 delta_w, real theta, real dt) {
  const Vec3 start = add3(w, delta_w);
  const Vec3 a = scale3(dt * theta, ratios);
  Vec3 x = start;
  for (u32 i = 0u; i < GYROSCOPIC_ITERATIONS; ++i) {
    const Vec3 y = mean3(theta, w, x);
    const Vec3 defect = add3(sub3(x, start), scale3(dt, gyroscopic_term(ratios, y)));
    const Vec3 row_x = make3((real)1, a.x * y.z, a.x * y.y);
    const Vec3 row_y = make3(a.y * y.z, (real)1, a.y * y.x);
    const Vec3 row_z = make3(a.z * y.y, a.z * y.x, (real)1);
    x = sub3(x, solve3(row_x, row_y, row_z, defect));
  }
  return x;
}

static inline Vec3 gyroscopic_step(Vec3 ratios, Vec3 w, Vec3 delta_w, real theta, real dt) {
  if (theta == (real)0) return sub3(add3(w, delta_w), scale3(dt, gyroscopic_term(ratios, w)));

  const real angle_squared = dot3(w, w) * (dt * dt);
  u32 substeps = 1u;
  while (substeps < MAX_GYROSCOPIC_SUBSTEPS && (real)(substeps * substeps) < angle_squared) substeps += substeps;
  if ((real)(substeps * substeps) < angle_squared) return add3(w, delta_w);

  const real share = (real)1 / (real)substeps;
  for (u32 i = 0u; i < substeps; ++i) w = gyroscopic_substep(ratios, w, scale3(share, delta_w), theta, share * dt);
  return w;
}

#endif
