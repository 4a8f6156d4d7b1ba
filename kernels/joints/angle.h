// The angle of a rotation about z. cpu_reference/joints/angle.hpp is the twin and gives the formula.
#ifndef LOCKSTEP_JOINT_ANGLE_H
#define LOCKSTEP_JOINT_ANGLE_H

#include "types.h"

// 2 atan2(z, w) for w >= 0.
static inline real rotation_angle(real z, real w) {
  const real r = w + sqrt(z * z + w * w);
  if (!(r > (real)0)) return (real)0;
  const real half_tangent = z / r;
  const real quarter = half_tangent / ((real)1 + sqrt((real)1 + half_tangent * half_tangent));
  const real t = quarter / ((real)1 + sqrt((real)1 + quarter * quarter));
  const real s = t * t;
  real sum = (real)1 / (real)25;
  for (u32 n = 23u; n > 1u; n -= 2u) sum = (real)1 / (real)n - s * sum;
  return (real)16 * (t - t * s * sum);
}

// atan2(y, x); r is the length of (x, y).
static inline real direction_angle(real x, real y, real r) {
  if (!(x < (real)0)) return rotation_angle(y, r + x);
  return y < (real)0 ? rotation_angle(x - r, -y) : rotation_angle(r - x, y);
}

#endif
