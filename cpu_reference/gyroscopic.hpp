// Euler's equations of a rotating body (survey eq. 8), in its principal frame where the inertia I is diagonal:
//
//   I w' + w x I w = tau        or, divided by I,        w' + r (w_y w_z, w_z w_x, w_x w_y) = I^-1 tau
//
// with the ratios r = ((I_z - I_y) / I_x, (I_x - I_z) / I_y, (I_y - I_x) / I_z), which lie within [-1, 1] for every
// real body. kernels/gyroscopic.h says the same in OpenCL C.
#pragma once

#include "cpu_reference/rigid_body.hpp"

namespace lockstep::reference {

/// Newton's method converges to rounding in this many iterations (measured in double over 200,000 random bodies)
/// when a body turns by up to one radian in a step: 4 at a quarter of a radian, 5 at the midpoint, 8 at worst.
constexpr u32 gyroscopic_iterations = 8;
/// Faster turns are taken in parts of up to a radian, at most this many. Beyond, nothing is left to be resolved: the
/// moment is left out.
constexpr u32 max_gyroscopic_substeps = 64;

template <class real>
Vec3<real> gyroscopic_ratios(const Mass<real>& mass) {
  return {(mass.inertia[2] - mass.inertia[1]) * mass.inverse_inertia[0],
          (mass.inertia[0] - mass.inertia[2]) * mass.inverse_inertia[1],
          (mass.inertia[1] - mass.inertia[0]) * mass.inverse_inertia[2]};
}
template <class real>
Vec3<real> gyroscopic_term(Vec3<real> ratios, Vec3<real> w) {
  return {ratios.x * (w.y * w.z), ratios.y * (w.z * w.x), ratios.z * (w.x * w.y)};
}

/// Cramer's rule for three equations given row by row.
template <class real>
Vec3<real> solve3(Vec3<real> row_x, Vec3<real> row_y, Vec3<real> row_z, Vec3<real> right) {
  const Vec3<real> yz = cross3(row_y, row_z);
  const Vec3<real> zx = cross3(row_z, row_x);
  const Vec3<real> xy = cross3(row_x, row_y);
  const Vec3<real> sum = add3(add3(scale3(right.x, yz), scale3(right.y, zx)), scale3(right.z, xy));
  return scale3(real(1) / dot3(row_x, yz), sum);
}

/// Solves  x - w - delta_w + dt r y y = 0  with  y = (1 - theta) w + theta x  by Newton's method.
template <class real>
Vec3<real> gyroscopic_substep(Vec3<real> ratios, Vec3<real> w, Vec3<real> delta_w, real theta, real dt) {
  const Vec3<real> start = add3(w, delta_w);
  const Vec3<real> a = scale3(dt * theta, ratios);
  Vec3<real> x = start;
  for (u32 i = 0; i < gyroscopic_iterations; ++i) {
    const Vec3<real> y = mean3(theta, w, x);
    const Vec3<real> defect = add3(sub3(x, start), scale3(dt, gyroscopic_term(ratios, y)));
    const Vec3<real> row_x = {real(1), a.x * y.z, a.x * y.y};
    const Vec3<real> row_y = {a.y * y.z, real(1), a.y * y.x};
    const Vec3<real> row_z = {a.z * y.y, a.z * y.x, real(1)};
    x = sub3(x, solve3(row_x, row_y, row_z, defect));
  }
  return x;
}

/// The angular velocity after dt, body frame: I (w' - w) + dt w_th x I w_th = dt tau, w_th = (1 - theta) w + theta w',
/// where delta_w = dt I^-1 tau. theta = 0 is explicit, one evaluation, and gains energy; theta = 1/2 conserves the
/// energy of a free body and, turned by integrate_orientation with w_1/2, its angular momentum (Simo and Wong 1991);
/// theta = 1 never gains any.
template <class real>
Vec3<real> gyroscopic_step(Vec3<real> ratios, Vec3<real> w, Vec3<real> delta_w, real theta, real dt) {
  if (theta == real(0)) return sub3(add3(w, delta_w), scale3(dt, gyroscopic_term(ratios, w)));

  const real angle_squared = dot3(w, w) * (dt * dt);
  u32 substeps = 1;
  while (substeps < max_gyroscopic_substeps && real(substeps * substeps) < angle_squared) substeps += substeps;
  if (real(substeps * substeps) < angle_squared) return add3(w, delta_w);

  const real share = real(1) / real(substeps);
  for (u32 i = 0; i < substeps; ++i) w = gyroscopic_substep(ratios, w, scale3(share, delta_w), theta, share * dt);
  return w;
}

}  // namespace lockstep::reference
