// The angle of a rotation about z, without a function of the C library. kernels/joints/angle.h is the twin.
#pragma once

#include "cpu_reference/math.hpp"

namespace lockstep::reference {

/// 2 atan2(z, w) for w >= 0: the angle, -pi .. pi, of a rotation about z with these parts of its quaternion (of any
/// length). The angle is halved three times by tan(x/2) = tan(x) / (1 + sqrt(1 + tan(x)^2)), down to pi/16, where the
/// series of the arc tangent is good to a double.
template <class real>
real rotation_angle(real z, real w) {
  const real r = w + std::sqrt(z * z + w * w);
  if (!(r > 0)) return 0;
  const real half = z / r;
  const real quarter = half / (real(1) + std::sqrt(real(1) + half * half));
  const real t = quarter / (real(1) + std::sqrt(real(1) + quarter * quarter));
  const real s = t * t;
  real sum = real(1) / real(25);
  for (u32 n = 23; n > 1; n -= 2) sum = real(1) / real(n) - s * sum;
  return real(16) * (t - t * s * sum);
}

/// atan2(y, x): the angle of a direction in the plane, -pi .. pi; r is its length. By tan(angle / 2) = y / (r + x), and
/// (r - x) / y where x is below 0, so that nothing cancels.
template <class real>
real direction_angle(real x, real y, real r) {
  if (!(x < 0)) return rotation_angle(y, r + x);
  return y < 0 ? rotation_angle(x - r, -y) : rotation_angle(r - x, y);
}

}  // namespace lockstep::reference
