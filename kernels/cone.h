// The one-contact problem of Coulomb friction, solved exactly in each lane. cpu_reference/cone.hpp is the twin and
// states the problem.
#ifndef LOCKSTEP_CONE_H
#define LOCKSTEP_CONE_H

#include "lanes.h"

#define CONE_STEPS (REAL_IS_DOUBLE ? 8 : 6)
#define CONE_TOLERANCE (REAL_IS_DOUBLE ? (real)1e-14 : (real)1e-6)

// In the contact's frame: along the normal and the two tangents.
typedef struct LaneCone {
  lane normal, tangent_1, tangent_2;
} LaneCone;

typedef struct LaneDelassus {
  lane nn, t11, t22, n1, n2, t12;
} LaneDelassus;

static inline LaneCone lane_make_cone(lane normal, lane tangent_1, lane tangent_2) {
  LaneCone r;
  r.normal = normal;
  r.tangent_1 = tangent_1;
  r.tangent_2 = tangent_2;
  return r;
}

static inline LaneCone lane_select_cone(lane_mask mask, LaneCone a, LaneCone b) {
  return lane_make_cone(mask ? a.normal : b.normal, mask ? a.tangent_1 : b.tangent_1, mask ? a.tangent_2 : b.tangent_2);
}

static inline LaneCone lane_clamp_to_cone(LaneCone r, lane friction) {
  const lane length = sqrt(r.tangent_1 * r.tangent_1 + r.tangent_2 * r.tangent_2);
  const lane limit = friction * r.normal;
  const lane scale = length > limit ? limit / length : (lane)1;
  return lane_make_cone(r.normal, scale * r.tangent_1, scale * r.tangent_2);
}

// Of two tangents: an impulse or a velocity, and the inverse of their block.
typedef struct LaneDisc {
  lane x, y;
} LaneDisc;

typedef struct LaneDiscInverse {
  lane xx, xy, yy;
} LaneDiscInverse;

static inline LaneDisc lane_disc_velocity(lane x, lane y, LaneDiscInverse inverse) {
  const lane determinant = inverse.xx * inverse.yy - inverse.xy * inverse.xy;
  LaneDisc u;
  u.x = (inverse.yy * x - inverse.xy * y) / determinant;
  u.y = (inverse.xx * y - inverse.xy * x) / determinant;
  return u;
}

static inline LaneDisc lane_solve_friction_disc(LaneDisc old, LaneDisc u, LaneDiscInverse inverse, lane limit) {
  const lane stick_x = old.x - (inverse.xx * u.x + inverse.xy * u.y);
  const lane stick_y = old.y - (inverse.xy * u.x + inverse.yy * u.y);
  const lane_mask slips = sqrt(stick_x * stick_x + stick_y * stick_y) > limit;
  const lane rho = (lane)2 * (inverse.xx * inverse.yy - inverse.xy * inverse.xy) / (inverse.xx + inverse.yy);
  const lane slip_x = old.x - rho * u.x, slip_y = old.y - rho * u.y;
  const lane length = sqrt(slip_x * slip_x + slip_y * slip_y);
  const lane scale = length > limit ? limit / length : (lane)1;
  LaneDisc r;
  r.x = slips ? scale * slip_x : stick_x;
  r.y = slips ? scale * slip_y : stick_y;
  return r;
}

// Padding has w_nn = 0 and q = 0: it takes off.
static inline LaneCone lane_solve_central(LaneCone q, lane w_nn, lane w_tt, lane friction) {
  const LaneCone none = lane_make_cone((lane)0, (lane)0, (lane)0);
  const LaneCone alone = lane_make_cone(-q.normal / w_nn, -q.tangent_1 / w_tt, -q.tangent_2 / w_tt);
  return lane_select_cone(q.normal < (lane)0, lane_clamp_to_cone(alone, friction), none);
}

// Where the lambda of a slip is looked for.
typedef struct LaneBracket {
  lane low, high;
} LaneBracket;

static inline lane lane_next_in(LaneBracket* bracket, lane lambda, lane excess, lane slope) {
  bracket->low = excess > (lane)0 ? lambda : bracket->low;
  bracket->high = excess > (lane)0 ? bracket->high : lambda;
  lane next = lambda + excess / slope;
  next = next < bracket->low ? bracket->low : next;
  next = next > bracket->high ? bracket->high : next;
  return slope > (lane)0 ? next : (lane)0.5 * (bracket->low + bracket->high);
}

#if FEATURE_GENERAL_CONTACTS
// In the `general` lanes.
static inline LaneCone lane_solve_general(lane_mask general, LaneCone q, LaneDelassus w, lane friction) {
  const LaneCone none = lane_make_cone((lane)0, (lane)0, (lane)0);
  const lane inverse_nn = (lane)1 / w.nn, g1 = w.n1 * inverse_nn, g2 = w.n2 * inverse_nn;
  const lane a11 = w.t11 - g1 * w.n1, a22 = w.t22 - g2 * w.n2, a12 = w.t12 - g1 * w.n2;
  const lane b1 = q.tangent_1 - g1 * q.normal, b2 = q.tangent_2 - g2 * q.normal;
  const lane alone = -q.normal * inverse_nn;

  lane lambda = (lane)0;
  LaneBracket bracket = {(lane)0, (lane)0};
  lane p1, p2, length;
  LaneCone without_slip;
  lane_mask slips;
  for (int step = 0;; ++step) {
    const lane x = a11 + lambda, y = a22 + lambda, determinant = x * y - a12 * a12;
    p1 = a12 * b2 - y * b1;
    p2 = a12 * b1 - x * b2;
    const lane squared = p1 * p1 + p2 * p2;
    const lane normal = alone * determinant - (g1 * p1 + g2 * p2), limit = friction * normal;
    if (step == 0) {
      const lane_mask pushes = q.normal < (lane)0;
      const lane inverse = (lane)1 / determinant;
      without_slip = lane_select_cone(pushes, lane_make_cone(normal * inverse, p1 * inverse, p2 * inverse), none);
      slips = pushes & !((limit >= (lane)0) & (squared <= limit * limit));
      if (!LANE_ANY(slips & general)) return without_slip;
      bracket.high = (fabs(b1) + fabs(b2)) * (w.nn + friction * (fabs(w.n1) + fabs(w.n2))) / (friction * -q.normal);
    }
    length = sqrt(squared);
    const lane excess = length - limit;
    const lane_mask searches = fabs(excess) > (lane)CONE_TOLERANCE * length;
    if (step == CONE_STEPS || !LANE_ANY(searches & slips & general)) break;

    // derivatives in lambda: of r_n times the determinant, and of mu r_n / |r_t| times |r_t| times it
    const lane rate = alone * (x + y) + (g1 * b1 + g2 * b2);
    const lane slope = friction * (rate + normal * ((p1 * b1 + p2 * b2) / squared));
    const lane next = lane_next_in(&bracket, lambda, excess, slope);
    lambda = searches ? next : lambda;  // a lane that has arrived stays while others search
  }

  // On the ray that was found the impulse is put exactly onto the cone, and u_n to zero.
  const lane_mask found = length > (lane)0;
  lane e1 = found ? p1 / length : (lane)0, e2 = found ? p2 / length : (lane)0;
  lane along = w.nn + friction * (w.n1 * e1 + w.n2 * e2);
  const lane_mask pushes = along > (lane)0;
  e1 = pushes ? e1 : (lane)0;
  e2 = pushes ? e2 : (lane)0;
  along = pushes ? along : w.nn;
  const lane normal = -q.normal / along;
  const LaneCone slip = lane_make_cone(normal, friction * normal * e1, friction * normal * e2);
  return lane_select_cone(slips, slip, without_slip);
}
#endif

#endif
