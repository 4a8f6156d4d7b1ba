// The normal impulses of the points of a pair, found together: a linear complementarity problem of up to four unknowns,
// solved exactly. kernels/solve_normals.h is the twin, LANES pairs at a time.
//
// With G the Delassus matrix of the normal rows, G_ij = n_i J_i M^-1 J_j^T n_j, and u the normal velocities under the
// impulses r_old, find r >= 0 with
//   A r + q >= 0, complementary,   A = G + diag(softness + eps G_ii),   q = u + bias - G r_old - eps G_ii r_old.
// Points of a face have G of rank three: the proximal term eps (Rockafellar 1976) chooses, among the impulses that do
// the same to the bodies, those next to the old ones, and is nothing where impulses stay.
//
// Which points press is found by pivoting on sets of them, from those that press under the old impulses: with the set
// held, A r = -q within it by an L D L^T factorisation (rows outside of the set are those of the identity); all points
// whose r or velocity is then of the wrong sign change sides (Kostreva 1978), and after `block_exchanges` only the last
// of them (Murty 1974), which ends for every positive definite A. One to two sets are usual.
#pragma once

#include <array>
#include <vector>

#include "cpu_reference/body_copies.hpp"
#include "cpu_reference/solve_contact.hpp"
#include "cpu_reference/tolerances.hpp"

namespace lockstep::reference {

/// eps: small enough for one solve to be exact in all that is seen, large enough for a matrix of rank three in
/// rounding.
template <class real>
constexpr real normal_proximity = sizeof(real) == 8 ? real(1e-7) : real(1e-4);
/// By which part of the largest velocity of the pair a point may close that does not press: rounding.
template <class real>
constexpr real normal_rounding = sizeof(real) == 8 ? real(1e-14) : real(1e-6);
constexpr int block_exchanges = 4, normal_exchanges = 20;

/// Symmetric, of the four points; D^-1 and L where it is factorised.
template <class real>
struct NormalMatrix {
  real diagonal[MANIFOLD_POINTS];
  real w_01, w_02, w_03, w_12, w_13, w_23;
};

/// Four numbers, one of each point.
template <class real>
using PerPoint = std::array<real, MANIFOLD_POINTS>;

template <class real>
PerPoint<real> times(const NormalMatrix<real>& m, const PerPoint<real>& x) {
  return {m.diagonal[0] * x[0] + m.w_01 * x[1] + m.w_02 * x[2] + m.w_03 * x[3],
          m.w_01 * x[0] + m.diagonal[1] * x[1] + m.w_12 * x[2] + m.w_13 * x[3],
          m.w_02 * x[0] + m.w_12 * x[1] + m.diagonal[2] * x[2] + m.w_23 * x[3],
          m.w_03 * x[0] + m.w_13 * x[1] + m.w_23 * x[2] + m.diagonal[3] * x[3]};
}

/// A x = b on the points that press, x = 0 elsewhere.
template <class real>
PerPoint<real> solve_pressing(const NormalMatrix<real>& a, const PerPoint<real>& b,
                              const std::array<bool, MANIFOLD_POINTS>& presses) {
  const auto diagonal = [&](u32 i) { return presses[i] ? a.diagonal[i] : real(1); };
  const auto entry = [&](u32 i, u32 j, real w) { return presses[i] && presses[j] ? w : real(0); };
  const real a01 = entry(0, 1, a.w_01), a02 = entry(0, 2, a.w_02), a03 = entry(0, 3, a.w_03);
  const real a12 = entry(1, 2, a.w_12), a13 = entry(1, 3, a.w_13), a23 = entry(2, 3, a.w_23);
  const real inverse_0 = real(1) / diagonal(0);
  const real l10 = a01 * inverse_0, l20 = a02 * inverse_0, l30 = a03 * inverse_0;
  const real inverse_1 = real(1) / (diagonal(1) - l10 * a01);
  const real e21 = a12 - l20 * a01, e31 = a13 - l30 * a01;
  const real l21 = e21 * inverse_1, l31 = e31 * inverse_1;
  const real inverse_2 = real(1) / (diagonal(2) - l20 * a02 - l21 * e21);
  const real e32 = a23 - l30 * a02 - l31 * e21;
  const real l32 = e32 * inverse_2;
  const real inverse_3 = real(1) / (diagonal(3) - l30 * a03 - l31 * e31 - l32 * e32);

  const real y0 = presses[0] ? b[0] : real(0);
  const real y1 = (presses[1] ? b[1] : real(0)) - l10 * y0;
  const real y2 = (presses[2] ? b[2] : real(0)) - l20 * y0 - l21 * y1;
  const real y3 = (presses[3] ? b[3] : real(0)) - l30 * y0 - l31 * y1 - l32 * y2;
  const real x3 = y3 * inverse_3;
  const real x2 = y2 * inverse_2 - l32 * x3;
  const real x1 = y1 * inverse_1 - l21 * x2 - l31 * x3;
  const real x0 = y0 * inverse_0 - l10 * x1 - l20 * x2 - l30 * x3;
  return {x0, x1, x2, x3};
}

/// r >= 0, A r + q >= 0, complementary. The rows of points that are not there are zero, and `presses` says at which
/// points r was positive.
template <class real>
PerPoint<real> solve_normal_problem(const NormalMatrix<real>& a, const PerPoint<real>& q,
                                    std::array<bool, MANIFOLD_POINTS> presses) {
  real largest = 0;
  for (const real x : q) largest = larger(std::fabs(x), largest);
  const real least = -(normal_rounding<real> * largest);
  PerPoint<real> r;
  for (int exchange = 0;; ++exchange) {
    r = solve_pressing(a, {-q[0], -q[1], -q[2], -q[3]}, presses);
    if (exchange == normal_exchanges) break;
    const PerPoint<real> u = times(a, r);
    std::array<bool, MANIFOLD_POINTS> is_wrong;
    bool any = false;
    for (u32 i = 0; i < MANIFOLD_POINTS; ++i) {
      is_wrong[i] = presses[i] ? r[i] < 0 : u[i] + q[i] < least;
      any = any || is_wrong[i];
    }
    if (!any) break;
    bool done = false;
    for (u32 i = MANIFOLD_POINTS; i-- > 0;) {
      if (!is_wrong[i] || done) continue;
      presses[i] = !presses[i];
      done = exchange >= block_exchanges;
    }
  }
  for (real& x : r) x = x > 0 ? x : real(0);
  return r;
}

/// What a unit normal impulse at a point asks of the bodies, and they of it: u = n . (v_a - v_b) + m_a . w_a - m_b .
/// w_b.
template <class real>
struct NormalRow {
  Vec3<real> normal, moment_a, moment_b;
};

template <class real>
NormalRow<real> normal_row(const ContactBlock<real>& block, u32 lane) {
  const ContactArms<real> c = contact_arms<real>(block, lane);
  return {c.normal, cross3(c.arm_a, c.normal), cross3(c.arm_b, c.normal)};
}

template <class real>
real normal_velocity(const NormalRow<real>& row, const Motion<real>& a, const Motion<real>& b) {
  return dot3(row.normal, sub3(vec3(a.v), vec3(b.v))) + dot3(row.moment_a, vec3(a.w)) - dot3(row.moment_b, vec3(b.w));
}

/// Of rows that are prepared; of a pair of one contact, zero.
template <class real>
void couple_normals(const std::vector<ContactBlock<real>>& rows, u32 first, u32 count, u32 kind, u32 lane,
                    const PairMotions<real>& motions, real bounding_radius, NormalCoupling<real>& couplings) {
  const Motion<real>&a = motions.a, &b = motions.b;
  const auto coupling = [&](u32 i, u32 j) {
    if (j >= count) return real(0);
    const NormalRow<real> x = normal_row(rows[first + i], lane), y = normal_row(rows[first + j], lane);
    return (a.inverse_mass + b.inverse_mass) * dot3(x.normal, y.normal) +
           (dot3(x.moment_a, angular_velocity_change(a, kind, y.moment_a)) +
            dot3(x.moment_b, angular_velocity_change(b, kind, y.moment_b)));
  };
  couplings.hit_speed[lane] = real(HIT_SPEED_SHARE) * bounding_radius;
  couplings.w_01[lane] = coupling(0, 1);
  couplings.w_02[lane] = coupling(0, 2);
  couplings.w_03[lane] = coupling(0, 3);
  couplings.w_12[lane] = coupling(1, 2);
  couplings.w_13[lane] = coupling(1, 3);
  couplings.w_23[lane] = coupling(2, 3);
}

/// Whether the pair has been hit, or has a point that closes faster than its hit_speed.
template <class real>
bool is_pair_hit(const NormalCoupling<real>& couplings, const std::vector<ContactBlock<real>>& rows, u32 first,
                 u32 count, u32 lane, const Motion<real>& a, const Motion<real>& b) {
  if (couplings.hit_speed[lane] == 0) return true;
  for (u32 k = 0; k < count; ++k)
    if (normal_velocity(normal_row(rows[first + k], lane), a, b) < -couplings.hit_speed[lane]) return true;
  return false;
}

/// Solves the normals of a pair, `law(row)` what each asks for.
template <class real, class Law>
void solve_coupled_normals(const NormalCoupling<real>& couplings, const std::vector<ContactBlock<real>>& rows,
                           std::vector<ImpulseBlock<real>>& impulses, u32 first, u32 count, u32 kind, u32 lane,
                           Law&& law, Motion<real>& a, Motion<real>& b) {
  NormalMatrix<real> g = {{0, 0, 0, 0},         couplings.w_01[lane], couplings.w_02[lane], couplings.w_03[lane],
                          couplings.w_12[lane], couplings.w_13[lane], couplings.w_23[lane]};
  NormalRow<real> row[MANIFOLD_POINTS];
  PerPoint<real> old = {0, 0, 0, 0}, u = {0, 0, 0, 0}, q, softness = {0, 0, 0, 0};
  std::array<bool, MANIFOLD_POINTS> presses;
  for (u32 k = 0; k < count; ++k) {
    row[k] = normal_row(rows[first + k], lane);
    g.diagonal[k] = rows[first + k].w_nn[lane];
    old[k] = impulses[first + k].normal[lane];
    softness[k] = law(first + k).softness;
    u[k] = normal_velocity(row[k], a, b) + law(first + k).bias.normal;
  }
  NormalMatrix<real> matrix = g;
  const PerPoint<real> without = times(g, old);
  for (u32 k = 0; k < MANIFOLD_POINTS; ++k) {
    const real proximity = normal_proximity<real> * g.diagonal[k];
    matrix.diagonal[k] = g.diagonal[k] + (softness[k] + proximity);
    q[k] = u[k] - without[k] - proximity * old[k];
    presses[k] = g.diagonal[k] * old[k] > u[k];
  }
  const PerPoint<real> r = solve_normal_problem(matrix, q, presses);

  Vec3<real> impulse = {0, 0, 0}, moment_a = {0, 0, 0}, moment_b = {0, 0, 0};
  for (u32 k = 0; k < count; ++k) {
    const real d = r[k] - old[k];
    impulses[first + k].normal[lane] = r[k];
    impulse = add3(impulse, scale3(d, row[k].normal));
    moment_a = add3(moment_a, scale3(d, row[k].moment_a));
    moment_b = add3(moment_b, scale3(d, row[k].moment_b));
  }
  if (a.inverse_mass > 0) {
    store3(a.v, add3(vec3(a.v), scale3(a.inverse_mass, impulse)));
    store3(a.w, add3(vec3(a.w), angular_velocity_change(a, kind, moment_a)));
  }
  if (b.inverse_mass > 0) {
    store3(b.v, sub3(vec3(b.v), scale3(b.inverse_mass, impulse)));
    store3(b.w, sub3(vec3(b.w), angular_velocity_change(b, kind, moment_b)));
  }
}

}  // namespace lockstep::reference
