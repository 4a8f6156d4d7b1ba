// The one-contact problem of friction that resists slip and torsion together, solved exactly in each lane.
// cpu_reference/torsion_cone.hpp is the twin and states the problem.
#ifndef LOCKSTEP_TORSION_CONE_H
#define LOCKSTEP_TORSION_CONE_H

#include "cone.h"

#if FEATURE_ANGULAR_FRICTION

#define TORSION_CONE_STEPS (REAL_IS_DOUBLE ? 14 : 10)

typedef struct LaneTorsion {
  lane normal, tangent_1, tangent_2, torsion;
} LaneTorsion;

typedef struct LaneTorsionDelassus {
  lane nn, t11, t22, n1, n2, t12, ss, ns, s1, s2;
} LaneTorsionDelassus;

static inline LaneTorsion lane_make_torsion(lane normal, lane tangent_1, lane tangent_2, lane torsion) {
  LaneTorsion r;
  r.normal = normal;
  r.tangent_1 = tangent_1;
  r.tangent_2 = tangent_2;
  r.torsion = torsion;
  return r;
}

static inline LaneTorsion lane_select_torsion(lane_mask mask, LaneTorsion a, LaneTorsion b) {
  return lane_make_torsion(mask ? a.normal : b.normal, mask ? a.tangent_1 : b.tangent_1,
                           mask ? a.tangent_2 : b.tangent_2, mask ? a.torsion : b.torsion);
}

static inline LaneTorsion lane_clamp_to_torsion_cone(LaneTorsion r, lane friction) {
  const lane length = sqrt(r.tangent_1 * r.tangent_1 + r.tangent_2 * r.tangent_2 + r.torsion * r.torsion);
  const lane limit = friction * r.normal;
  const lane scale = length > limit ? limit / length : (lane)1;
  return lane_make_torsion(r.normal, scale * r.tangent_1, scale * r.tangent_2, scale * r.torsion);
}

// S of an ellipse of friction.
typedef struct LaneEllipse {
  lane s_11, s_12, s_22;
  lane degenerate;
} LaneEllipse;

#if FEATURE_ELLIPTIC_FRICTION
static inline LaneTorsion lane_stretch(LaneEllipse s, LaneTorsion r) {
  return lane_make_torsion(r.normal, s.s_11 * r.tangent_1 + s.s_12 * r.tangent_2,
                           s.s_12 * r.tangent_1 + s.s_22 * r.tangent_2, r.torsion);
}

static inline LaneTorsion lane_shrink(LaneEllipse s, LaneTorsion r) {
  const lane s_11 = s.s_11 + s.degenerate * ((lane)1 - s.s_11), s_12 = s.s_12 - s.degenerate * s.s_12,
             s_22 = s.s_22 + s.degenerate * ((lane)1 - s.s_22);
  const lane determinant = s_11 * s_22 - s_12 * s_12;
  return lane_make_torsion(r.normal, (s_22 * r.tangent_1 - s_12 * r.tangent_2) / determinant,
                           (s_11 * r.tangent_2 - s_12 * r.tangent_1) / determinant, r.torsion);
}

static inline LaneTorsionDelassus lane_stretch_block(LaneEllipse s, LaneTorsionDelassus w) {
  const lane w_11 = w.t11 * s.s_11 + w.t12 * s.s_12, w_12 = w.t11 * s.s_12 + w.t12 * s.s_22;
  const lane w_21 = w.t12 * s.s_11 + w.t22 * s.s_12, w_22 = w.t12 * s.s_12 + w.t22 * s.s_22;
  LaneTorsionDelassus r = w;
  const lane own = s.degenerate * w.nn;
  r.t11 = s.s_11 * w_11 + s.s_12 * w_21 + own * ((lane)1 - s.s_11);
  r.t12 = s.s_11 * w_12 + s.s_12 * w_22 - own * s.s_12;
  r.t22 = s.s_12 * w_12 + s.s_22 * w_22 + own * ((lane)1 - s.s_22);
  r.n1 = s.s_11 * w.n1 + s.s_12 * w.n2;
  r.n2 = s.s_12 * w.n1 + s.s_22 * w.n2;
  r.s1 = s.s_11 * w.s1 + s.s_12 * w.s2;
  r.s2 = s.s_12 * w.s1 + s.s_22 * w.s2;
  return r;
}
#endif

// Padding has q = 0: it takes off.
static inline LaneTorsion lane_solve_torsion_cone(LaneTorsion q, LaneTorsionDelassus w, lane friction) {
  const LaneTorsion none = lane_make_torsion((lane)0, (lane)0, (lane)0, (lane)0);
  const lane inverse_nn = (lane)1 / w.nn, alone = -q.normal;
  const lane g1 = w.n1 * inverse_nn, g2 = w.n2 * inverse_nn, g3 = w.ns * inverse_nn;
  const lane a11 = (w.t11 - g1 * w.n1) * inverse_nn, a22 = (w.t22 - g2 * w.n2) * inverse_nn;
  const lane a33 = (w.ss - g3 * w.ns) * inverse_nn, a12 = (w.t12 - g1 * w.n2) * inverse_nn;
  const lane a13 = (w.s1 - g1 * w.ns) * inverse_nn, a23 = (w.s2 - g2 * w.ns) * inverse_nn;
  const lane b1 = q.tangent_1 - g1 * q.normal, b2 = q.tangent_2 - g2 * q.normal, b3 = q.torsion - g3 * q.normal;

  lane lambda = (lane)0;
  LaneBracket bracket = {(lane)0, (lane)0};
  lane p1, p2, p3, length;
  LaneTorsion without_slip;
  lane_mask slips;
  for (int step = 0;; ++step) {
    const lane x = a11 + lambda, y = a22 + lambda, z = a33 + lambda;
    const lane c11 = y * z - a23 * a23, c22 = x * z - a13 * a13, c33 = x * y - a12 * a12;
    const lane c12 = a13 * a23 - a12 * z, c13 = a12 * a23 - a13 * y, c23 = a12 * a13 - a23 * x;
    const lane determinant = x * c11 + a12 * c12 + a13 * c13;
    p1 = -(c11 * b1 + c12 * b2 + c13 * b3);
    p2 = -(c12 * b1 + c22 * b2 + c23 * b3);
    p3 = -(c13 * b1 + c23 * b2 + c33 * b3);
    const lane squared = p1 * p1 + p2 * p2 + p3 * p3;
    const lane normal = alone * determinant - (g1 * p1 + g2 * p2 + g3 * p3), limit = friction * normal;
    if (step == 0) {
      const lane_mask pushes = q.normal < (lane)0;
      const lane inverse = inverse_nn / determinant;
      without_slip = lane_select_torsion(
          pushes, lane_make_torsion(normal * inverse, p1 * inverse, p2 * inverse, p3 * inverse), none);
      slips = pushes & !((limit >= (lane)0) & (squared <= limit * limit));
      if (!LANE_ANY(slips)) return without_slip;
      bracket.high = (fabs(b1) + fabs(b2) + fabs(b3)) * ((lane)1 + friction * (fabs(g1) + fabs(g2) + fabs(g3))) /
                     (friction * alone);
    }
    length = sqrt(squared);
    const lane excess = length - limit;
    const lane_mask searches = fabs(excess) > (lane)CONE_TOLERANCE * length;
    if (step == TORSION_CONE_STEPS || !LANE_ANY(searches & slips)) break;

    // derivatives in lambda, as in lane_solve_general
    const lane d1 = a12 * b2 + a13 * b3 - (y + z) * b1, d2 = a12 * b1 + a23 * b3 - (x + z) * b2;
    const lane d3 = a13 * b1 + a23 * b2 - (x + y) * b3;
    const lane rate = alone * (c11 + c22 + c33) - (g1 * d1 + g2 * d2 + g3 * d3);
    const lane slope = friction * (rate - normal * ((p1 * d1 + p2 * d2 + p3 * d3) / squared));
    const lane next = lane_next_in(&bracket, lambda, excess, slope);
    lambda = searches ? next : lambda;  // a lane that has arrived stays while others search
  }

  // On the ray that was found the impulse is put exactly onto the cone, and u_n to zero.
  const lane_mask found = length > (lane)0;
  lane e1 = found ? p1 / length : (lane)0, e2 = found ? p2 / length : (lane)0, e3 = found ? p3 / length : (lane)0;
  lane along = w.nn + friction * (w.n1 * e1 + w.n2 * e2 + w.ns * e3);
  const lane_mask pushes = along > (lane)0;
  e1 = pushes ? e1 : (lane)0;
  e2 = pushes ? e2 : (lane)0;
  e3 = pushes ? e3 : (lane)0;
  along = pushes ? along : w.nn;
  const lane normal = -q.normal / along, limit = friction * normal;
  return lane_select_torsion(slips, lane_make_torsion(normal, limit * e1, limit * e2, limit * e3), without_slip);
}

#endif

#endif
