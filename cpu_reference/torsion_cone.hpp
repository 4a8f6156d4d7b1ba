// The one-contact problem of Coulomb friction that resists slip and torsion together (Contensou 1963; Leine and
// Glocker, A set-valued force law for spatial Coulomb-Contensou friction, 2003), with the ellipsoid that stands for
// their limit surface (Howe and Cutkosky, Practical force-motion models for sliding manipulation, 1996):
//   |(r_t, r_s)| <= mu r_n,   r_s = moment about the normal / torsion radius,   u_s = torsion radius * w_n.
// In these units it is the cone of cpu_reference/cone.hpp with one tangent more, and the same cases: it takes off,
// sticks (u_t = 0, u_s = 0), or slips, (u_t, u_s) against (r_t, r_s). A fast rotation about the normal leaves little of
// the friction to resist a slow slip, and the other way round. kernels/torsion_cone.h is the twin.
#pragma once

#include "cpu_reference/cone.hpp"

namespace lockstep::reference {

/// A ConeVector and the torsion: m/s, or N s.
template <class real>
struct TorsionVector {
  real normal, tangent_1, tangent_2, torsion;
};

/// Symmetric, 1/kg: the block of a contact and what it shares with the torsion.
template <class real>
struct TorsionDelassus {
  real nn, t11, t22, n1, n2, t12, ss, ns, s1, s2;
};

/// Newton steps for the slip, at most (tests/torsion_cone_test.cpp).
template <class real>
constexpr int torsion_cone_steps = sizeof(real) == 8 ? 14 : 10;

/// S of an ellipse of friction (kernels/friction_types.h), the unit matrix of a round cone: with r_t = S r'_t and
/// u'_t = S u_t the cone of r' is round, and its block is S W S. Of a degenerate ellipse S projects on a direction;
/// across it r' does nothing, and gets w_nn as its own block and no velocity, so that it is 0.
template <class real>
struct Ellipse {
  real s_11 = 1, s_12 = 0, s_22 = 1;
  real degenerate = 0;
};

template <class real>
TorsionVector<real> stretch(const Ellipse<real>& s, TorsionVector<real> r) {
  return {r.normal, s.s_11 * r.tangent_1 + s.s_12 * r.tangent_2, s.s_12 * r.tangent_1 + s.s_22 * r.tangent_2,
          r.torsion};
}

template <class real>
TorsionVector<real> shrink(const Ellipse<real>& s, TorsionVector<real> r) {
  const real s_11 = s.s_11 + s.degenerate * (real(1) - s.s_11), s_12 = s.s_12 - s.degenerate * s.s_12,
             s_22 = s.s_22 + s.degenerate * (real(1) - s.s_22);
  const real determinant = s_11 * s_22 - s_12 * s_12;
  return {r.normal, (s_22 * r.tangent_1 - s_12 * r.tangent_2) / determinant,
          (s_11 * r.tangent_2 - s_12 * r.tangent_1) / determinant, r.torsion};
}

template <class real>
TorsionDelassus<real> stretch(const Ellipse<real>& s, const TorsionDelassus<real>& w) {
  const real w_11 = w.t11 * s.s_11 + w.t12 * s.s_12, w_12 = w.t11 * s.s_12 + w.t12 * s.s_22;  // rows of W S
  const real w_21 = w.t12 * s.s_11 + w.t22 * s.s_12, w_22 = w.t12 * s.s_12 + w.t22 * s.s_22;
  TorsionDelassus<real> r = w;
  const real own = s.degenerate * w.nn;
  r.t11 = s.s_11 * w_11 + s.s_12 * w_21 + own * (real(1) - s.s_11);
  r.t12 = s.s_11 * w_12 + s.s_12 * w_22 - own * s.s_12;
  r.t22 = s.s_12 * w_12 + s.s_22 * w_22 + own * (real(1) - s.s_22);
  r.n1 = s.s_11 * w.n1 + s.s_12 * w.n2;
  r.n2 = s.s_12 * w.n1 + s.s_22 * w.n2;
  r.s1 = s.s_11 * w.s1 + s.s_12 * w.s2;
  r.s2 = s.s_12 * w.s1 + s.s_22 * w.s2;
  return r;
}

/// The nearest tangent and torsion in the cone over the same normal impulse.
template <class real>
TorsionVector<real> clamp_to_torsion_cone(TorsionVector<real> r, real friction) {
  const real length = std::sqrt(r.tangent_1 * r.tangent_1 + r.tangent_2 * r.tangent_2 + r.torsion * r.torsion);
  const real limit = friction * r.normal;
  const real scale = length > limit ? limit / length : real(1);
  return {r.normal, scale * r.tangent_1, scale * r.tangent_2, scale * r.torsion};
}

/// As solve_general, with p = r_t det(A + lambda I) w_nn by the cofactors of A + lambda I, in parts of w_nn: a torsion
/// radius is small, and products of three entries would leave the range of a float.
template <class real>
TorsionVector<real> solve_torsion_cone(TorsionVector<real> q, const TorsionDelassus<real>& w, real friction) {
  if (!(q.normal < 0)) return {0, 0, 0, 0};
  const real inverse_nn = real(1) / w.nn, alone = -q.normal;
  const real g1 = w.n1 * inverse_nn, g2 = w.n2 * inverse_nn, g3 = w.ns * inverse_nn;
  const real a11 = (w.t11 - g1 * w.n1) * inverse_nn, a22 = (w.t22 - g2 * w.n2) * inverse_nn;
  const real a33 = (w.ss - g3 * w.ns) * inverse_nn, a12 = (w.t12 - g1 * w.n2) * inverse_nn;
  const real a13 = (w.s1 - g1 * w.ns) * inverse_nn, a23 = (w.s2 - g2 * w.ns) * inverse_nn;
  const real b1 = q.tangent_1 - g1 * q.normal, b2 = q.tangent_2 - g2 * q.normal, b3 = q.torsion - g3 * q.normal;

  real lambda = 0;
  SlipBracket<real> bracket = {0, 0};
  real p1, p2, p3, length;
  for (int step = 0;; ++step) {
    const real x = a11 + lambda, y = a22 + lambda, z = a33 + lambda;
    const real c11 = y * z - a23 * a23, c22 = x * z - a13 * a13, c33 = x * y - a12 * a12;
    const real c12 = a13 * a23 - a12 * z, c13 = a12 * a23 - a13 * y, c23 = a12 * a13 - a23 * x;
    const real determinant = x * c11 + a12 * c12 + a13 * c13;
    p1 = -(c11 * b1 + c12 * b2 + c13 * b3);
    p2 = -(c12 * b1 + c22 * b2 + c23 * b3);
    p3 = -(c13 * b1 + c23 * b2 + c33 * b3);
    const real squared = p1 * p1 + p2 * p2 + p3 * p3;
    const real normal = alone * determinant - (g1 * p1 + g2 * p2 + g3 * p3), limit = friction * normal;
    if (step == 0) {
      const real inverse = inverse_nn / determinant;
      if (limit >= 0 && squared <= limit * limit) return {normal * inverse, p1 * inverse, p2 * inverse, p3 * inverse};
      bracket.high = (std::fabs(b1) + std::fabs(b2) + std::fabs(b3)) *
                     (real(1) + friction * (std::fabs(g1) + std::fabs(g2) + std::fabs(g3))) / (friction * alone);
    }
    length = std::sqrt(squared);
    const real excess = length - limit;
    if (step == torsion_cone_steps<real> || !(std::fabs(excess) > cone_tolerance<real> * length)) break;

    // derivatives in lambda, as in solve_general
    const real d1 = a12 * b2 + a13 * b3 - (y + z) * b1, d2 = a12 * b1 + a23 * b3 - (x + z) * b2;
    const real d3 = a13 * b1 + a23 * b2 - (x + y) * b3;
    const real rate = alone * (c11 + c22 + c33) - (g1 * d1 + g2 * d2 + g3 * d3);
    const real slope = friction * (rate - normal * ((p1 * d1 + p2 * d2 + p3 * d3) / squared));
    lambda = bracket.next(lambda, excess, slope);
  }

  // On the ray that was found the impulse is put exactly onto the cone, and u_n to zero.
  const bool found = length > 0;
  real e1 = found ? p1 / length : real(0), e2 = found ? p2 / length : real(0), e3 = found ? p3 / length : real(0);
  real along = w.nn + friction * (w.n1 * e1 + w.n2 * e2 + w.ns * e3);
  const bool pushes = along > 0;
  e1 = pushes ? e1 : real(0);
  e2 = pushes ? e2 : real(0);
  e3 = pushes ? e3 : real(0);
  along = pushes ? along : w.nn;
  const real normal = -q.normal / along, limit = friction * normal;
  return {normal, limit * e1, limit * e2, limit * e3};
}

}  // namespace lockstep::reference
