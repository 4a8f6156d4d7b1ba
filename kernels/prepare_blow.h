// A blow on LANES pairs of several points: what their normals aim at together. cpu_reference/prepare_blow.hpp is the
// twin and states the law.
#ifndef LOCKSTEP_PREPARE_BLOW_H
#define LOCKSTEP_PREPARE_BLOW_H

#include "solve_normals.h"

#if FEATURE_COUPLED_NORMALS

// What prepare_row knows of a row.
typedef struct LaneBlowPoint {
  lane gap, u_old, restitution;
  lane rest_bias, rest_softness;  // of its law without restitution
  lane_mask is_hit;               // closes its gap, faster than what bounces
} LaneBlowPoint;

// LCP(G, u). The second solve takes back what the proximal term left.
static inline LanePoints lane_blow_impulses(const LaneNormalMatrix* g, LanePoints u) {
  LaneNormalMatrix matrix = *g;
  LanePressing presses;
  for (u32 k = 0u; k < MANIFOLD_POINTS; ++k) {
    matrix.diagonal[k] = matrix.diagonal[k] + (lane)NORMAL_PROXIMITY * matrix.diagonal[k];
    presses.at[k] = u.x[k] < (lane)0;
  }
  const LanePoints first = lane_solve_normal_problem(&matrix, u, presses);
  LanePoints q;
  for (u32 k = 0u; k < MANIFOLD_POINTS; ++k) {
    q.x[k] = u.x[k] - (lane)NORMAL_PROXIMITY * g->diagonal[k] * first.x[k];
    presses.at[k] = first.x[k] > (lane)0;
  }
  return lane_solve_normal_problem(&matrix, q, presses);
}

static inline LanePoints lane_plus(LanePoints a, LanePoints b) {
  LanePoints sum;
  for (u32 k = 0u; k < MANIFOLD_POINTS; ++k) sum.x[k] = a.x[k] + b.x[k];
  return sum;
}

// The rows of a block are prepared, `points` what they were prepared from.
static inline void prepare_blows(const StepParams* params, u32 first, u32 row_count, lane_u32 count,
                                 const LaneBlowPoint* points, global const ImpactBlock* impacts,
                                 global const NormalCoupling* couplings, global ContactBlock* rows,
                                 global SoftnessBlock* softness_rows) {
  if (row_count < 2u) return;
  lane closing = (lane)0;
  for (u32 k = 0u; k < row_count; ++k)
    closing = LANE_MASK(count > (lane_u32)k) & points[k].is_hit ? lane_larger(-points[k].u_old, closing) : closing;
  lane_mask is_blow = LANE_MASK(count > (lane_u32)1) & (closing > (lane)0);
  if (!LANE_ANY(is_blow)) return;

  const lane zero = (lane)0;
  lane_mask touches[MANIFOLD_POINTS], leaves = zero > zero;
  LaneNormalMatrix g;
  LanePoints u, e;
  for (u32 k = 0u; k < MANIFOLD_POINTS; ++k) {
    touches[k] = zero > zero;
    g.diagonal[k] = (lane)1;
    u.x[k] = e.x[k] = zero;
    if (k >= row_count) continue;
    touches[k] = is_blow & LANE_MASK(count > (lane_u32)k) & (points[k].restitution > zero) &
                 (points[k].gap < (lane)params->dt * closing);
    g.diagonal[k] = touches[k] ? LANE_LOAD(rows[k].w_nn + first) : g.diagonal[k];
    u.x[k] = touches[k] ? points[k].u_old : zero;
    e.x[k] = touches[k] ? points[k].restitution : zero;
    leaves = leaves | (u.x[k] > (lane)params->restitution_threshold);
  }
#if FEATURE_IMPACT_LAWS
  is_blow = is_blow & (LANE_MASK(LANE_LOAD_U32(impacts->law + first) == (lane_u32)IMPACT_NEWTON) | leaves);
  if (!LANE_ANY(is_blow)) return;
#endif
  g.w_01 = touches[0] & touches[1] ? LANE_LOAD(couplings->w_01 + first) : zero;
  g.w_02 = touches[0] & touches[2] ? LANE_LOAD(couplings->w_02 + first) : zero;
  g.w_03 = touches[0] & touches[3] ? LANE_LOAD(couplings->w_03 + first) : zero;
  g.w_12 = touches[1] & touches[2] ? LANE_LOAD(couplings->w_12 + first) : zero;
  g.w_13 = touches[1] & touches[3] ? LANE_LOAD(couplings->w_13 + first) : zero;
  g.w_23 = touches[2] & touches[3] ? LANE_LOAD(couplings->w_23 + first) : zero;

  LanePoints p = lane_blow_impulses(&g, u);
  for (u32 k = 0u; k < MANIFOLD_POINTS; ++k) p.x[k] = ((lane)1 + e.x[k]) * p.x[k];
  const LanePoints restored = lane_plus(u, lane_normal_times(&g, p)), last = lane_blow_impulses(&g, restored);
  const LanePoints end = lane_plus(restored, lane_normal_times(&g, last));
  for (u32 k = 0u; k < MANIFOLD_POINTS; ++k) {
    if (k >= row_count) continue;
    const lane_mask changes = is_blow & touches[k], is_pressed = p.x[k] + last.x[k] > zero;
    const lane least = (is_pressed & (points[k].gap > zero)) ? zero : points[k].rest_bias;
    const lane_mask bounces = is_pressed & (-end.x[k] < least);
    const lane bias = bounces ? -end.x[k] : least;
    LANE_STORE(changes ? bias : LANE_LOAD(rows[k].bias + first), rows[k].bias + first);
#if FEATURE_SOFT_CONTACTS
    const lane softness = bounces ? zero : points[k].rest_softness * LANE_LOAD(rows[k].w_nn + first);
    LANE_STORE(changes ? softness : LANE_LOAD(softness_rows[k].softness + first), softness_rows[k].softness + first);
#endif
  }
}

#endif

#endif
