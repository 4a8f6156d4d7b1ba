// The normal impulses of the points of LANES pairs, found together. cpu_reference/solve_normals.hpp is the twin and
// states the problem and the method.
#ifndef LOCKSTEP_SOLVE_NORMALS_H
#define LOCKSTEP_SOLVE_NORMALS_H

#include "solve_contact.h"

#if FEATURE_COUPLED_NORMALS

#if REAL_IS_DOUBLE
#define NORMAL_PROXIMITY ((real)1e-7)
#define NORMAL_ROUNDING ((real)1e-14)
#else
#define NORMAL_PROXIMITY ((real)1e-4)
#define NORMAL_ROUNDING ((real)1e-6)
#endif
#define BLOCK_EXCHANGES 4
#define NORMAL_EXCHANGES 20

// Four numbers of each pair, one of each point.
typedef struct LanePoints {
  lane x[MANIFOLD_POINTS];
} LanePoints;

// Symmetric.
typedef struct LaneNormalMatrix {
  lane diagonal[MANIFOLD_POINTS];
  lane w_01, w_02, w_03, w_12, w_13, w_23;
} LaneNormalMatrix;

typedef struct LanePressing {
  lane_mask at[MANIFOLD_POINTS];
} LanePressing;

static inline LanePoints lane_normal_times(const LaneNormalMatrix* m, LanePoints p) {
  LanePoints y;
  y.x[0] = m->diagonal[0] * p.x[0] + m->w_01 * p.x[1] + m->w_02 * p.x[2] + m->w_03 * p.x[3];
  y.x[1] = m->w_01 * p.x[0] + m->diagonal[1] * p.x[1] + m->w_12 * p.x[2] + m->w_13 * p.x[3];
  y.x[2] = m->w_02 * p.x[0] + m->w_12 * p.x[1] + m->diagonal[2] * p.x[2] + m->w_23 * p.x[3];
  y.x[3] = m->w_03 * p.x[0] + m->w_13 * p.x[1] + m->w_23 * p.x[2] + m->diagonal[3] * p.x[3];
  return y;
}

// A x = -q on the points that press, x = 0 elsewhere.
static inline LanePoints lane_solve_pressing(const LaneNormalMatrix* a, LanePoints q, LanePressing presses) {
  const lane_mask p0 = presses.at[0], p1 = presses.at[1], p2 = presses.at[2], p3 = presses.at[3];
  const lane zero = (lane)0, one = (lane)1;
  const lane a01 = p0 & p1 ? a->w_01 : zero, a02 = p0 & p2 ? a->w_02 : zero, a03 = p0 & p3 ? a->w_03 : zero;
  const lane a12 = p1 & p2 ? a->w_12 : zero, a13 = p1 & p3 ? a->w_13 : zero, a23 = p2 & p3 ? a->w_23 : zero;
  const lane inverse_0 = one / (p0 ? a->diagonal[0] : one);
  const lane l10 = a01 * inverse_0, l20 = a02 * inverse_0, l30 = a03 * inverse_0;
  const lane inverse_1 = one / ((p1 ? a->diagonal[1] : one) - l10 * a01);
  const lane e21 = a12 - l20 * a01, e31 = a13 - l30 * a01;
  const lane l21 = e21 * inverse_1, l31 = e31 * inverse_1;
  const lane inverse_2 = one / ((p2 ? a->diagonal[2] : one) - l20 * a02 - l21 * e21);
  const lane e32 = a23 - l30 * a02 - l31 * e21;
  const lane l32 = e32 * inverse_2;
  const lane inverse_3 = one / ((p3 ? a->diagonal[3] : one) - l30 * a03 - l31 * e31 - l32 * e32);

  const lane y0 = p0 ? -q.x[0] : zero;
  const lane y1 = (p1 ? -q.x[1] : zero) - l10 * y0;
  const lane y2 = (p2 ? -q.x[2] : zero) - l20 * y0 - l21 * y1;
  const lane y3 = (p3 ? -q.x[3] : zero) - l30 * y0 - l31 * y1 - l32 * y2;
  LanePoints r;
  r.x[3] = y3 * inverse_3;
  r.x[2] = y2 * inverse_2 - l32 * r.x[3];
  r.x[1] = y1 * inverse_1 - l21 * r.x[2] - l31 * r.x[3];
  r.x[0] = y0 * inverse_0 - l10 * r.x[1] - l20 * r.x[2] - l30 * r.x[3];
  return r;
}

static inline LanePoints lane_solve_normal_problem(const LaneNormalMatrix* a, LanePoints q, LanePressing presses) {
  lane largest = (lane)0;
  for (u32 k = 0u; k < MANIFOLD_POINTS; ++k) largest = lane_larger(fabs(q.x[k]), largest);
  const lane least = -((lane)NORMAL_ROUNDING * largest);
  LanePoints r;
  for (int exchange = 0;; ++exchange) {
    r = lane_solve_pressing(a, q, presses);
    if (exchange == NORMAL_EXCHANGES) break;
    const LanePoints u = lane_normal_times(a, r);
    lane_mask wrong[MANIFOLD_POINTS];
    for (u32 k = 0u; k < MANIFOLD_POINTS; ++k)
      wrong[k] = (presses.at[k] & (r.x[k] < (lane)0)) | ((u.x[k] + q.x[k] < least) & !presses.at[k]);
    if (!LANE_ANY(wrong[0] | wrong[1] | wrong[2] | wrong[3])) break;
    if (exchange >= BLOCK_EXCHANGES) {
      wrong[2] = wrong[2] & !wrong[3];
      wrong[1] = wrong[1] & !(wrong[2] | wrong[3]);
      wrong[0] = wrong[0] & !(wrong[1] | wrong[2] | wrong[3]);
    }
    for (u32 k = 0u; k < MANIFOLD_POINTS; ++k) presses.at[k] = presses.at[k] ^ wrong[k];
  }
  for (u32 k = 0u; k < MANIFOLD_POINTS; ++k) r.x[k] = r.x[k] > (lane)0 ? r.x[k] : (lane)0;
  return r;
}

// What a unit normal impulse at a point asks of the bodies, and they of it: u = n . (v_a - v_b) + m_a . w_a - m_b .
// w_b.
typedef struct LaneNormalRow {
  Lane3 normal, moment_a, moment_b;
} LaneNormalRow;

static inline LaneNormalRow lane_normal_row(global const ContactBlock* block, u32 first) {
  LaneNormalRow row;
  row.normal = LANE_NORMAL(block, first);
  row.moment_a = lane_cross3(LANE_ARM_A(block, first), row.normal);
  row.moment_b = lane_cross3(LANE_ARM_B(block, first), row.normal);
  return row;
}

static inline lane lane_coupling(const LaneNormalRow* x, const LaneNormalRow* y, lane_mask general, const LaneBody* a,
                                 const LaneBody* b) {
  return (a->inverse_mass + b->inverse_mass) * lane_dot3(x->normal, y->normal) +
         (lane_dot3(x->moment_a, lane_angular_velocity_change(*a, general, y->moment_a)) +
          lane_dot3(x->moment_b, lane_angular_velocity_change(*b, general, y->moment_b)));
}

// Of rows that are prepared; zero where there are none.
static inline void couple_normals(u32 first, u32 row_count, lane_u32 count, lane_mask general, const LaneBody* a,
                                  const LaneBody* b, global const ContactBlock* rows,
                                  global NormalCoupling* couplings) {
  lane w[6];
  for (u32 k = 0u; k < 6u; ++k) w[k] = (lane)0;
  if (row_count > 1u) {
    LaneNormalRow row[MANIFOLD_POINTS];
    for (u32 k = 0u; k < MANIFOLD_POINTS; ++k) {
      if (k < row_count) row[k] = lane_normal_row(rows + k, first);
    }
    w[0] = lane_coupling(&row[0], &row[1], general, a, b);
    if (row_count > 2u) {
      w[1] = lane_coupling(&row[0], &row[2], general, a, b);
      w[3] = lane_coupling(&row[1], &row[2], general, a, b);
    }
    if (row_count > 3u) {
      w[2] = lane_coupling(&row[0], &row[3], general, a, b);
      w[4] = lane_coupling(&row[1], &row[3], general, a, b);
      w[5] = lane_coupling(&row[2], &row[3], general, a, b);
    }
  }
  const lane_mask two = LANE_MASK(count > (lane_u32)1), three = LANE_MASK(count > (lane_u32)2);
  const lane_mask four = LANE_MASK(count > (lane_u32)3);
  lane_store_where(two, w[0], couplings->w_01 + first);
  lane_store_where(three, w[1], couplings->w_02 + first);
  lane_store_where(four, w[2], couplings->w_03 + first);
  lane_store_where(three, w[3], couplings->w_12 + first);
  lane_store_where(four, w[4], couplings->w_13 + first);
  lane_store_where(four, w[5], couplings->w_23 + first);
}

// How large the load of a pair is, and from which speed on a closing point hits it (cpu_reference/solve_normals.hpp).
static inline lane lane_pair_load(u32 first, u32 row_count, global const ContactBlock* rows,
                                  global const ImpulseBlock* impulses) {
  lane load = (lane)0;
  for (u32 k = 0u; k < row_count; ++k)
    load = lane_larger(LANE_LOAD(rows[k].w_nn + first) * LANE_LOAD(impulses[k].normal + first), load);
  return load;
}

static inline lane lane_next_hit_speed(u32 substep, lane bounding_radius, lane load, lane before) {
  const lane speed = (lane)HIT_SPEED_SHARE * bounding_radius + (lane)HIT_LOAD_SHARE * load;
  const lane least = fabs(before);
  if (substep == 0u) return speed;
  return speed < least ? speed : least;
}

static inline lane lane_normal_velocity(const LaneNormalRow* row, const LaneBody* a, const LaneBody* b) {
  return lane_dot3(row->normal, lane_sub3(a->v, b->v)) + lane_dot3(row->moment_a, a->w) -
         lane_dot3(row->moment_b, b->w);
}

// Which pairs have been hit, or have a point that closes faster than their hit_speed.
static inline lane_mask lane_hit_pairs(u32 first, u32 row_count, global const NormalCoupling* couplings,
                                       global const ContactBlock* rows, const LaneBody* a, const LaneBody* b) {
  lane least = (lane)0;
  for (u32 k = 0u; k < row_count; ++k) {
    const LaneNormalRow row = lane_normal_row(rows + k, first);
    const lane velocity = lane_normal_velocity(&row, a, b);
    least = velocity < least ? velocity : least;
  }
  const lane hit_speed = LANE_LOAD(couplings->hit_speed + first);
  return (hit_speed < (lane)0) | (least < -hit_speed);
}

// Solves the normals of `pairs`; a block has `row_count` rows, of which `rows` is the first.
static inline void solve_coupled_normals(const u32 purpose, u32 first, u32 row_count, lane_mask pairs,
                                         lane_mask general, global const NormalCoupling* couplings,
                                         global const ContactBlock* rows, global const SoftnessBlock* softness_rows,
                                         global ImpulseBlock* impulses, LaneBody* a, LaneBody* b) {
  LaneNormalMatrix g;
  g.w_01 = LANE_LOAD(couplings->w_01 + first), g.w_02 = LANE_LOAD(couplings->w_02 + first);
  g.w_03 = LANE_LOAD(couplings->w_03 + first), g.w_12 = LANE_LOAD(couplings->w_12 + first);
  g.w_13 = LANE_LOAD(couplings->w_13 + first), g.w_23 = LANE_LOAD(couplings->w_23 + first);
  LaneNormalRow row[MANIFOLD_POINTS];
  LanePoints old, u, softness;
  for (u32 k = 0u; k < MANIFOLD_POINTS; ++k) {
    g.diagonal[k] = old.x[k] = u.x[k] = softness.x[k] = (lane)0;
    if (k >= row_count) continue;
    row[k] = lane_normal_row(rows + k, first);
    const LaneLaw law = lane_law(purpose, rows + k, softness_rows + k, first);
    g.diagonal[k] = law.w_nn;
    old.x[k] = LANE_LOAD(impulses[k].normal + first);
    softness.x[k] = law.softness;
    u.x[k] = lane_normal_velocity(&row[k], a, b) + law.bias;
  }
  LaneNormalMatrix matrix = g;
  LanePoints q = lane_normal_times(&g, old);
  LanePressing presses;
  for (u32 k = 0u; k < MANIFOLD_POINTS; ++k) {
    const lane proximity = (lane)NORMAL_PROXIMITY * g.diagonal[k];
    matrix.diagonal[k] = g.diagonal[k] + (softness.x[k] + proximity);
    q.x[k] = u.x[k] - q.x[k] - proximity * old.x[k];
    presses.at[k] = g.diagonal[k] * old.x[k] > u.x[k];
  }
  const LanePoints r = lane_solve_normal_problem(&matrix, q, presses);

  Lane3 impulse = lane_make3((lane)0, (lane)0, (lane)0), moment_a = impulse, moment_b = impulse;
  for (u32 k = 0u; k < row_count; ++k) {
    const lane next = pairs ? r.x[k] : old.x[k], d = next - old.x[k];
    LANE_STORE(next, impulses[k].normal + first);
    impulse = lane_add3(impulse, lane_scale3(d, row[k].normal));
    moment_a = lane_add3(moment_a, lane_scale3(d, row[k].moment_a));
    moment_b = lane_add3(moment_b, lane_scale3(d, row[k].moment_b));
  }
  LaneBody next_a = *a, next_b = *b;
  next_a.v = lane_add3(a->v, lane_scale3(a->inverse_mass, impulse));
  next_a.w = lane_add3(a->w, lane_angular_velocity_change(*a, general, moment_a));
  next_b.v = lane_sub3(b->v, lane_scale3(b->inverse_mass, impulse));
  next_b.w = lane_sub3(b->w, lane_angular_velocity_change(*b, general, moment_b));
  lane_select_body(pairs, next_a, a);
  lane_select_body(pairs, next_b, b);
}

#endif

#endif
