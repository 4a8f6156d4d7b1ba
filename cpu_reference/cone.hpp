// The one-contact problem of Coulomb friction, solved exactly: given the relative velocity without the contact's own
// impulse, q, and the 3 x 3 Delassus block W in the frame (n, t1, t2), find r with
//   u = W r + q,   |r_t| <= mu r_n,   u_n + mu |u_t| >= mu |u_t|,   complementary in De Saxce's sense:
// it takes off (r = 0, u_n >= 0), sticks (u = 0) or slips (u_n = 0, |r_t| = mu r_n, u_t against r_t).
// kernels/cone.h is the twin. Survey 2.3 and 4.2 state the law; Bonnefon and Daviet (2011) enumerate the same cases.
#pragma once

#include "cpu_reference/math.hpp"

namespace lockstep::reference {

/// In the contact's frame: along the normal and the two tangents. A velocity, m/s, or an impulse, N s.
template <class real>
struct ConeVector {
  real normal, tangent_1, tangent_2;
};

/// Symmetric, 1/kg.
template <class real>
struct Delassus {
  real nn, t11, t22, n1, n2, t12;
};

/// Newton steps for the slip, at most. Enough for rounding on the blocks of real bodies (tests/cone_test.cpp).
template <class real>
constexpr int cone_steps = sizeof(real) == 8 ? 8 : 6;

/// By which part of itself the friction may miss the cone before it is put onto it.
template <class real>
constexpr real cone_tolerance = sizeof(real) == 8 ? real(1e-14) : real(1e-6);

/// The nearest tangent in the cone over the same normal impulse.
template <class real>
ConeVector<real> clamp_to_cone(ConeVector<real> r, real friction) {
  const real length = std::sqrt(r.tangent_1 * r.tangent_1 + r.tangent_2 * r.tangent_2);
  const real limit = friction * r.normal;
  const real scale = length > limit ? limit / length : real(1);
  return {r.normal, scale * r.tangent_1, scale * r.tangent_2};
}

/// The inverse of a symmetric 2 x 2 block of two tangents.
template <class real>
struct DiscInverse {
  real xx, xy, yy;
};
template <class real>
struct DiscVector {
  real x, y;
};

/// What an impulse (or a moment) does to the velocities of its rows.
template <class real>
DiscVector<real> disc_velocity(real x, real y, const DiscInverse<real>& inverse) {
  const real determinant = inverse.xx * inverse.yy - inverse.xy * inverse.xy;
  return {(inverse.yy * x - inverse.xy * y) / determinant, (inverse.xx * y - inverse.xy * x) / determinant};
}

/// The next impulse in a disc of the radius `limit`, from the old one and the velocity u with it. What sticks is found
/// at once, r - W^-1 u; what slips by a step of projection, P(r - rho u), which comes to rest only where it is opposed
/// to u (W^-1 u has another direction), with rho = 2 / trace W.
template <class real>
DiscVector<real> solve_friction_disc(real old_x, real old_y, real u_x, real u_y, const DiscInverse<real>& inverse,
                                     real limit) {
  const real stick_x = old_x - (inverse.xx * u_x + inverse.xy * u_y);
  const real stick_y = old_y - (inverse.xy * u_x + inverse.yy * u_y);
  if (!(std::sqrt(stick_x * stick_x + stick_y * stick_y) > limit)) return {stick_x, stick_y};
  const real rho = real(2) * (inverse.xx * inverse.yy - inverse.xy * inverse.xy) / (inverse.xx + inverse.yy);
  const real slip_x = old_x - rho * u_x, slip_y = old_y - rho * u_y;
  const real length = std::sqrt(slip_x * slip_x + slip_y * slip_y);
  const real scale = length > limit ? limit / length : real(1);
  return {scale * slip_x, scale * slip_y};
}

/// W diagonal and isotropic in the tangent plane: normal and friction decouple.
template <class real>
ConeVector<real> solve_central(ConeVector<real> q, real w_nn, real w_tt, real friction) {
  if (!(q.normal < 0)) return {0, 0, 0};
  return clamp_to_cone({-q.normal / w_nn, -q.tangent_1 / w_tt, -q.tangent_2 / w_tt}, friction);
}

/// Where the lambda of a slip is looked for.
template <class real>
struct SlipBracket {
  real low, high;

  /// The next lambda by Newton's method, from the excess at this one and its slope. Where it would leave the bracket,
  /// it stops at the end; where the slope leads nowhere, the bracket is halved.
  real next(real lambda, real excess, real slope) {
    low = excess > 0 ? lambda : low;
    high = excess > 0 ? high : lambda;
    real next = lambda + excess / slope;
    next = next < low ? low : next;
    next = next > high ? high : next;
    return slope > 0 ? next : real(0.5) * (low + high);
  }
};

/// Full W. With r_n eliminated by u_n = 0 a slip obeys (A + lambda I) r_t = -b, A = W_tt - W_tn W_nt / w_nn,
/// b = q_t - W_tn q_n / w_nn, for the lambda >= 0 at which |r_t| = mu r_n. Like the secular equation of a trust region
/// (More and Sorensen 1983), mu r_n / |r_t| - 1 is almost linear in lambda: Newton from 0, kept inside a bracket. It
/// looks at r times det(A + lambda I), a ratio that needs no division by the determinant.
template <class real>
ConeVector<real> solve_general(ConeVector<real> q, const Delassus<real>& w, real friction) {
  if (!(q.normal < 0)) return {0, 0, 0};
  const real inverse_nn = real(1) / w.nn, g1 = w.n1 * inverse_nn, g2 = w.n2 * inverse_nn;
  const real a11 = w.t11 - g1 * w.n1, a22 = w.t22 - g2 * w.n2, a12 = w.t12 - g1 * w.n2;
  const real b1 = q.tangent_1 - g1 * q.normal, b2 = q.tangent_2 - g2 * q.normal;
  const real alone = -q.normal * inverse_nn;

  real lambda = 0;
  SlipBracket<real> bracket = {0, 0};
  real p1, p2, length;
  for (int step = 0;; ++step) {
    const real x = a11 + lambda, y = a22 + lambda, determinant = x * y - a12 * a12;
    p1 = a12 * b2 - y * b1;
    p2 = a12 * b1 - x * b2;
    const real squared = p1 * p1 + p2 * p2;
    const real normal = alone * determinant - (g1 * p1 + g2 * p2), limit = friction * normal;
    if (step == 0) {
      const real inverse = real(1) / determinant;
      if (limit >= 0 && squared <= limit * limit) return {normal * inverse, p1 * inverse, p2 * inverse};
      bracket.high = (std::fabs(b1) + std::fabs(b2)) * (w.nn + friction * (std::fabs(w.n1) + std::fabs(w.n2))) /
                     (friction * -q.normal);
    }
    length = std::sqrt(squared);
    const real excess = length - limit;
    if (step == cone_steps<real> || !(std::fabs(excess) > cone_tolerance<real> * length)) break;

    // derivatives in lambda: of r_n times the determinant, and of mu r_n / |r_t| times |r_t| times it
    const real rate = alone * (x + y) + (g1 * b1 + g2 * b2);
    const real slope = friction * (rate + normal * ((p1 * b1 + p2 * b2) / squared));
    lambda = bracket.next(lambda, excess, slope);
  }

  // On the ray that was found the impulse is put exactly onto the cone, and u_n to zero.
  const bool found = length > 0;
  real e1 = found ? p1 / length : real(0), e2 = found ? p2 / length : real(0);
  real along = w.nn + friction * (w.n1 * e1 + w.n2 * e2);
  const bool pushes = along > 0;
  e1 = pushes ? e1 : real(0);
  e2 = pushes ? e2 : real(0);
  along = pushes ? along : w.nn;
  const real normal = -q.normal / along;
  return {normal, friction * normal * e1, friction * normal * e2};
}

}  // namespace lockstep::reference
