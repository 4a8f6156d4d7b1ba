// A blow on a pair of several points, some of which close and bounce: what its normals aim at together.
// kernels/prepare_blow.h is the twin.
//
// Each point on its own aims at -e u (Newton), and lets one that leaves be pushed back at e times its speed, so that a
// blow at one end of a body makes the other end close. The points of the pair share one impact instead, by Poisson's
// law with a complementarity problem for each phase (Glocker and Pfeiffer, Multiple impacts with friction in rigid
// multibody systems, 1995), u their normal velocities before the forces, G as in cpu_reference/solve_normals.hpp:
//   compression  P = LCP(G, u)                                no point closes
//   restitution  u' = u + G (1 + e) P,  L = LCP(G, u')        e P is given back, and L where that makes a point close
//   the pair aims at u' + G L.
// u' takes e of what compression changed, and L only takes energy: without friction a lone blow gains none. Where all
// points are pressed and none leaves, u' = -e u: Newton's law. A point that gets no impulse rests, with its law without
// restitution. Points without restitution, and those too far to come into touch at the speed of the closing ones, are
// left alone. Of the laws of cpu_reference/impact.hpp, which each point obeys for itself, the normals follow this where
// a point leaves.
#pragma once

#include "cpu_reference/solve_normals.hpp"

namespace lockstep::reference {

/// What prepare_contact() knows of a point.
template <class real>
struct BlowPoint {
  real gap, u_old, restitution;
  real rest_bias, rest_softness;  // of its law without restitution
  bool is_hit;                    // closes its gap, faster than what bounces
};

/// LCP(G, u). The second solve takes back what the proximal term left.
template <class real>
PerPoint<real> blow_impulses(const NormalMatrix<real>& g, const PerPoint<real>& u) {
  NormalMatrix<real> matrix = g;
  for (real& x : matrix.diagonal) x = x + normal_proximity<real> * x;
  Pressing presses;
  for (u32 k = 0; k < MANIFOLD_POINTS; ++k) presses[k] = u[k] < 0;
  std::optional<NormalFactor<real>> factor;
  const PerPoint<real> first = solve_normal_problem(matrix, u, presses, factor);
  PerPoint<real> q;
  for (u32 k = 0; k < MANIFOLD_POINTS; ++k) {
    q[k] = u[k] - normal_proximity<real> * g.diagonal[k] * first[k];
    presses[k] = first[k] > 0;
  }
  return solve_normal_problem(matrix, q, presses, factor);
}

template <class real>
PerPoint<real> plus(const PerPoint<real>& a, const PerPoint<real>& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]};
}

/// The rows of the pair are prepared, `points` what they were prepared from; `law` is ImpactLaw.
template <class real>
void prepare_blow(Buffers<real>& buffers, const StepParams<real>& params, u32 block, u32 lane, u32 law,
                  const std::array<BlowPoint<real>, MANIFOLD_POINTS>& points) {
  const u32 first = buffers.block_rows[block].first, count = buffers.block_bodies[block].count[lane];
  real closing = 0;
  for (u32 k = 0; k < count; ++k) closing = points[k].is_hit ? larger(-points[k].u_old, closing) : closing;
  if (count < 2 || !(closing > 0)) return;

  Pressing touches;
  NormalMatrix<real> g = {{1, 1, 1, 1}, 0, 0, 0, 0, 0, 0};
  PerPoint<real> u = {0, 0, 0, 0}, e = {0, 0, 0, 0};
  bool leaves = false;
  for (u32 k = 0; k < MANIFOLD_POINTS; ++k) {
    touches[k] = k < count && points[k].restitution > 0 && points[k].gap < params.dt * closing;
    if (!touches[k]) continue;
    g.diagonal[k] = buffers.contact_blocks[first + k].w_nn[lane];
    u[k] = points[k].u_old;
    e[k] = points[k].restitution;
    leaves = leaves || u[k] > params.restitution_threshold;
  }
  if (law != IMPACT_NEWTON && !leaves) return;
  const NormalCoupling<real>& w = buffers.normal_couplings[block];
  const auto entry = [&](u32 i, u32 j, const real* x) { return touches[i] && touches[j] ? x[lane] : real(0); };
  g.w_01 = entry(0, 1, w.w_01), g.w_02 = entry(0, 2, w.w_02), g.w_03 = entry(0, 3, w.w_03);
  g.w_12 = entry(1, 2, w.w_12), g.w_13 = entry(1, 3, w.w_13), g.w_23 = entry(2, 3, w.w_23);

  PerPoint<real> p = blow_impulses(g, u);
  for (u32 k = 0; k < MANIFOLD_POINTS; ++k) p[k] = (real(1) + e[k]) * p[k];
  const PerPoint<real> restored = plus(u, times(g, p)), last = blow_impulses(g, restored);
  const PerPoint<real> end = plus(restored, times(g, last));
  for (u32 k = 0; k < count; ++k) {
    if (!touches[k]) continue;
    const bool is_pressed = p[k] + last[k] > 0;
    const real least = is_pressed && points[k].gap > 0 ? real(0) : points[k].rest_bias;
    const bool bounces = is_pressed && -end[k] < least;
    ContactBlock<real>& row = buffers.contact_blocks[first + k];
    row.bias[lane] = bounces ? -end[k] : least;
    if (!buffers.softness_blocks.empty())
      buffers.softness_blocks[first + k].softness[lane] = bounces ? real(0) : points[k].rest_softness * row.w_nn[lane];
  }
}

}  // namespace lockstep::reference
