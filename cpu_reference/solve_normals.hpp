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
#include <optional>
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

/// Which points press.
using Pressing = std::array<bool, MANIFOLD_POINTS>;

/// L D L^T of a matrix on the points that press; of the others the rows are those of the identity.
template <class real>
struct NormalFactor {
  Pressing presses;
  PerPoint<real> inverse;
  real l10, l20, l21, l30, l31, l32;
};

template <class real>
NormalFactor<real> factorise(const NormalMatrix<real>& a, const Pressing& presses) {
  const auto diagonal = [&](u32 i) { return presses[i] ? a.diagonal[i] : real(1); };
  const auto entry = [&](u32 i, u32 j, real w) { return presses[i] && presses[j] ? w : real(0); };
  const real a01 = entry(0, 1, a.w_01), a02 = entry(0, 2, a.w_02), a03 = entry(0, 3, a.w_03);
  const real a12 = entry(1, 2, a.w_12), a13 = entry(1, 3, a.w_13), a23 = entry(2, 3, a.w_23);
  NormalFactor<real> f;
  f.presses = presses;
  f.inverse[0] = real(1) / diagonal(0);
  f.l10 = a01 * f.inverse[0], f.l20 = a02 * f.inverse[0], f.l30 = a03 * f.inverse[0];
  f.inverse[1] = real(1) / (diagonal(1) - f.l10 * a01);
  const real e21 = a12 - f.l20 * a01, e31 = a13 - f.l30 * a01;
  f.l21 = e21 * f.inverse[1], f.l31 = e31 * f.inverse[1];
  f.inverse[2] = real(1) / (diagonal(2) - f.l20 * a02 - f.l21 * e21);
  const real e32 = a23 - f.l30 * a02 - f.l31 * e21;
  f.l32 = e32 * f.inverse[2];
  f.inverse[3] = real(1) / (diagonal(3) - f.l30 * a03 - f.l31 * e31 - f.l32 * e32);
  return f;
}

/// A x = b on the points that press, x = 0 elsewhere.
template <class real>
PerPoint<real> solve_factor(const NormalFactor<real>& f, const PerPoint<real>& b) {
  const real y0 = f.presses[0] ? b[0] : real(0);
  const real y1 = (f.presses[1] ? b[1] : real(0)) - f.l10 * y0;
  const real y2 = (f.presses[2] ? b[2] : real(0)) - f.l20 * y0 - f.l21 * y1;
  const real y3 = (f.presses[3] ? b[3] : real(0)) - f.l30 * y0 - f.l31 * y1 - f.l32 * y2;
  const real x3 = y3 * f.inverse[3];
  const real x2 = y2 * f.inverse[2] - f.l32 * x3;
  const real x1 = y1 * f.inverse[1] - f.l21 * x2 - f.l31 * x3;
  const real x0 = y0 * f.inverse[0] - f.l10 * x1 - f.l20 * x2 - f.l30 * x3;
  return {x0, x1, x2, x3};
}

/// r >= 0, A r + q >= 0, complementary. The rows of points that are not there are zero, `presses` says at which points
/// r was positive, and `factor` is one of A, or of no set: what it is left as serves the next solve.
template <class real>
PerPoint<real> solve_normal_problem(const NormalMatrix<real>& a, const PerPoint<real>& q, Pressing presses,
                                    std::optional<NormalFactor<real>>& factor) {
  real largest = 0;
  for (const real x : q) largest = larger(std::fabs(x), largest);
  const real least = -(normal_rounding<real> * largest);
  PerPoint<real> r;
  for (int exchange = 0;; ++exchange) {
    if (!factor || factor->presses != presses) factor = factorise(a, presses);
    r = solve_factor(*factor, {-q[0], -q[1], -q[2], -q[3]});
    if (exchange == normal_exchanges) break;
    const PerPoint<real> u = times(a, r);
    Pressing is_wrong;
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
                    const PairMotions<real>& motions, NormalCoupling<real>& couplings) {
  const Motion<real>&a = motions.a, &b = motions.b;
  const auto coupling = [&](u32 i, u32 j) {
    if (j >= count) return real(0);
    const NormalRow<real> x = normal_row(rows[first + i], lane), y = normal_row(rows[first + j], lane);
    return (a.inverse_mass + b.inverse_mass) * dot3(x.normal, y.normal) +
           (dot3(x.moment_a, angular_velocity_change(a, kind, y.moment_a)) +
            dot3(x.moment_b, angular_velocity_change(b, kind, y.moment_b)));
  };
  couplings.w_01[lane] = coupling(0, 1);
  couplings.w_02[lane] = coupling(0, 2);
  couplings.w_03[lane] = coupling(0, 3);
  couplings.w_12[lane] = coupling(1, 2);
  couplings.w_13[lane] = coupling(1, 3);
  couplings.w_23[lane] = coupling(2, 3);
}

/// The speed that its load takes from a contact of the pair in a sub-step, of all the largest, m/s.
template <class real>
real pair_load(const std::vector<ContactBlock<real>>& rows, const std::vector<ImpulseBlock<real>>& impulses, u32 first,
               u32 count, u32 lane) {
  real load = 0;
  for (u32 k = 0; k < count; ++k) load = larger(rows[first + k].w_nn[lane] * impulses[first + k].normal[lane], load);
  return load;
}

/// From which speed on a closing point hits a pair that rests on springs, m/s: by the least load of the step so far,
/// for what comes down leaves an impulse that is no load. `before`: the hit_speed of the last sub-step.
template <class real>
real next_hit_speed(u32 substep, real bounding_radius, real load, real before) {
  const real speed = real(HIT_SPEED_SHARE) * bounding_radius + real(HIT_LOAD_SHARE) * load;
  const real least = std::fabs(before);
  return substep == 0 || speed < least ? speed : least;
}

template <class real>
void clear_lane(NormalCoupling<real>& couplings, u32 lane) {
  for (real* field : {couplings.w_01, couplings.w_02, couplings.w_03, couplings.w_12, couplings.w_13, couplings.w_23,
                      couplings.hit_speed})
    field[lane] = 0;
}

/// The normals of a pair in one solve of it, `bias` that of their laws: what its solves before and behind friction
/// share.
template <class real>
struct PairNormals {
  u32 count;
  NormalRow<real> row[MANIFOLD_POINTS];
  PerPoint<real> bias;
  NormalMatrix<real> g, matrix;  // and with softness and proximity
  std::optional<NormalFactor<real>> factor;
};

/// `law(row)` is what each point asks for.
template <class real, class Law>
PairNormals<real> pair_normals(const NormalCoupling<real>& couplings, const std::vector<ContactBlock<real>>& rows,
                               u32 first, u32 count, u32 lane, Law&& law) {
  const NormalMatrix<real> g = {{0, 0, 0, 0},         couplings.w_01[lane], couplings.w_02[lane], couplings.w_03[lane],
                                couplings.w_12[lane], couplings.w_13[lane], couplings.w_23[lane]};
  PairNormals<real> normals = {count, {}, {0, 0, 0, 0}, g, g, {}};
  for (u32 k = 0; k < count; ++k) {
    const auto contact_law = law(first + k);
    normals.row[k] = normal_row(rows[first + k], lane);
    normals.bias[k] = contact_law.bias.normal;
    const real w_nn = rows[first + k].w_nn[lane];
    normals.g.diagonal[k] = w_nn;
    normals.matrix.diagonal[k] = w_nn + (contact_law.softness + normal_proximity<real> * w_nn);
  }
  return normals;
}

/// Whether a point closes faster than the speed.
template <class real>
bool is_pair_hit(const PairNormals<real>& normals, real hit_speed, const Motion<real>& a, const Motion<real>& b) {
  for (u32 k = 0; k < normals.count; ++k)
    if (normal_velocity(normals.row[k], a, b) < -hit_speed) return true;
  return false;
}

template <class real>
void solve_normals(PairNormals<real>& normals, std::vector<ImpulseBlock<real>>& impulses, u32 first, u32 kind, u32 lane,
                   Motion<real>& a, Motion<real>& b) {
  const NormalMatrix<real>& g = normals.g;
  const u32 count = normals.count;
  PerPoint<real> old = {0, 0, 0, 0}, u = {0, 0, 0, 0}, q;
  for (u32 k = 0; k < count; ++k) {
    old[k] = impulses[first + k].normal[lane];
    u[k] = normal_velocity(normals.row[k], a, b) + normals.bias[k];
  }
  const PerPoint<real> without = times(g, old);
  Pressing presses;
  for (u32 k = 0; k < MANIFOLD_POINTS; ++k) {
    const real proximity = normal_proximity<real> * g.diagonal[k];
    q[k] = u[k] - without[k] - proximity * old[k];
    presses[k] = g.diagonal[k] * old[k] > u[k];
  }
  const PerPoint<real> r = solve_normal_problem(normals.matrix, q, presses, normals.factor);

  Vec3<real> impulse = {0, 0, 0}, moment_a = {0, 0, 0}, moment_b = {0, 0, 0};
  for (u32 k = 0; k < count; ++k) {
    const real d = r[k] - old[k];
    impulses[first + k].normal[lane] = r[k];
    impulse = add3(impulse, scale3(d, normals.row[k].normal));
    moment_a = add3(moment_a, scale3(d, normals.row[k].moment_a));
    moment_b = add3(moment_b, scale3(d, normals.row[k].moment_b));
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
