// What an impact makes of one contact, in each lane. cpu_reference/impact.hpp is the twin and states the laws.
#ifndef LOCKSTEP_IMPACT_H
#define LOCKSTEP_IMPACT_H

#include "cone.h"
#include "lanes.h"

#if FEATURE_IMPACT_LAWS

#define IMPACT_PIECES 64
#define SLIDE_DEFLECTION ((lane)0.125)
#define SLIDE_ROUNDING (REAL_IS_DOUBLE ? (real)1e-14 : (real)4e-6)
#define START_STEPS (REAL_IS_DOUBLE ? 8 : 6)

typedef struct LaneImpactMaterial {
  lane_mask by_work;   // Stronge's law
  lane_mask combines;  // Chatterjee and Ruina's
  lane friction, restitution, tangential_restitution;
} LaneImpactMaterial;

typedef struct LaneOutcome {
  LaneCone impulse, velocity;
  lane_mask slides;
} LaneOutcome;

// Per unit of normal impulse: the tangential impulse, and how the velocity changes.
typedef struct LanePiece {
  lane t1, t2;
  LaneCone rate;
} LanePiece;

static inline LaneCone lane_times(const LaneDelassus* w, LaneCone r) {
  return lane_make_cone(w->nn * r.normal + w->n1 * r.tangent_1 + w->n2 * r.tangent_2,
                        w->n1 * r.normal + w->t11 * r.tangent_1 + w->t12 * r.tangent_2,
                        w->n2 * r.normal + w->t12 * r.tangent_1 + w->t22 * r.tangent_2);
}

static inline LanePiece impact_piece(const LaneDelassus* w, lane t1, lane t2) {
  LanePiece piece;
  piece.t1 = t1;
  piece.t2 = t2;
  piece.rate = lane_times(w, lane_make_cone((lane)1, t1, t2));
  return piece;
}

static inline LanePiece select_piece(lane_mask mask, LanePiece a, LanePiece b) {
  LanePiece piece;
  piece.t1 = mask ? a.t1 : b.t1;
  piece.t2 = mask ? a.t2 : b.t2;
  piece.rate = lane_select_cone(mask, a.rate, b.rate);
  return piece;
}

// Stuck, or the start of a slide.
static inline LanePiece piece_from_rest(const LaneDelassus* w, lane friction) {
  const lane inverse = (lane)1 / (w->t11 * w->t22 - w->t12 * w->t12);
  const lane s1 = (w->t12 * w->n2 - w->t22 * w->n1) * inverse, s2 = (w->t12 * w->n1 - w->t11 * w->n2) * inverse;
  const lane_mask sticks = s1 * s1 + s2 * s2 <= friction * friction;
  const lane z = friction * w->t12;
  lane d1 = (lane)0, d2 = (lane)0, length = (lane)1, l = (lane)0;
  for (int step = 0; step < START_STEPS; ++step) {
    const lane x = friction * w->t11 + l, y = friction * w->t22 + l, scale = (lane)1 / (x * y - z * z);
    d1 = (y * w->n1 - z * w->n2) * scale;
    d2 = (x * w->n2 - z * w->n1) * scale;
    const lane squared = d1 * d1 + d2 * d2;
    length = sqrt(squared);
    const lane bend = (d1 * (y * d1 - z * d2) + d2 * (x * d2 - z * d1)) * scale;
    l = l + (length - (lane)1) * squared / bend;
  }
  const lane t1 = sticks ? s1 : -friction * (d1 / length), t2 = sticks ? s2 : -friction * (d2 / length);
  return impact_piece(w, t1, t2);
}

// After which normal impulse the phase ends that the impact is in.
typedef struct LanePhase {
  lane impulse;
  lane_mask compresses, pays;
} LanePhase;

static inline LanePhase impact_phase(lane_mask by_work, lane u_n, lane rate, lane owed, lane far) {
  const lane_mask increases = rate > (lane)0;
  LanePhase end;
  end.compresses = (u_n < (lane)0) | (!(u_n > (lane)0) & (rate < (lane)0));
  const lane_mask reverses = (end.compresses & increases) | (!end.compresses & !increases);
  const lane to_zero = reverses ? fabs(u_n / rate) : far;
  const lane squared = u_n * u_n + (lane)2 * rate * owed;
  const lane by_work_impulse = squared >= (lane)0 ? (lane)2 * owed / (u_n + sqrt(squared)) : far;
  const lane wanted = owed > (lane)0 ? (by_work ? by_work_impulse : owed) : (lane)0;
  end.pays = !end.compresses & (wanted <= to_zero);
  end.impulse = end.pays ? wanted : to_zero;
  return end;
}

// A piece of a slide, how far it reaches, and whether the slide stops there.
typedef struct LaneSlide {
  LanePiece piece;
  lane span;
  lane_mask stops;
} LaneSlide;

static inline LaneSlide slide_piece(LaneCone u, lane speed, const LaneDelassus* w, lane friction, lane_mask by_work,
                                    lane owed, lane far) {
  LaneSlide slide;
  const lane e1 = u.tangent_1 / speed, e2 = u.tangent_2 / speed;
  const lane inverse = (lane)1 / (w->t11 * w->t22 - w->t12 * w->t12);
  const lane a1 = (w->t22 * u.tangent_1 - w->t12 * u.tangent_2) * inverse;
  const lane a2 = (w->t11 * u.tangent_2 - w->t12 * u.tangent_1) * inverse;
  const lane s1 = (w->t22 * w->n1 - w->t12 * w->n2) * inverse, s2 = (w->t11 * w->n2 - w->t12 * w->n1) * inverse;
  const lane length = a1 * a1 + a2 * a2, along = a1 * s1 + a2 * s2;
  const lane squared = along * along - length * (s1 * s1 + s2 * s2 - friction * friction);
  const lane over = squared >= (lane)0 ? sqrt(squared) - along : (lane)0, stop = over > (lane)0 ? length / over : far;
  const lane d1 = (a1 / stop + s1) / friction, d2 = (a2 / stop + s2) / friction;
  const lane deflection = fabs(d1 * e2 - d2 * e1);
  const LanePiece straight = impact_piece(w, -friction * d1, -friction * d2);
  slide.stops = (stop < far) & (stop <= impact_phase(by_work, u.normal, straight.rate.normal, owed, far).impulse) &
                (deflection <= SLIDE_DEFLECTION) & (d1 * e1 + d2 * e2 > (lane)0);

  const LanePiece first = impact_piece(w, -friction * e1, -friction * e2);
  const lane gains = first.rate.tangent_1 * e1 + first.rate.tangent_2 * e2;
  const lane deflects = first.rate.tangent_2 * e1 - first.rate.tangent_1 * e2;
  const lane stiff = friction * (w->t11 * e2 * e2 - (lane)2 * w->t12 * e1 * e2 + w->t22 * e1 * e1);
  const lane ratio = SLIDE_DEFLECTION * stiff / fabs(deflects);
  const lane until = speed / (stiff / ratio + (gains < (lane)0 ? -gains : (lane)0));
  const lane phase = impact_phase(by_work, u.normal, first.rate.normal, owed, far).impulse;
  const lane span = until < far ? until : far;
  const lane half_phase = (lane)0.5 * (phase < span ? phase : span);
  const lane ahead = speed + half_phase * gains, aside = half_phase * deflects / ((lane)1 + half_phase * stiff / speed);
  const lane x = ahead * e1 - aside * e2, y = ahead * e2 + aside * e1;
  const lane middle = sqrt(x * x + y * y), m1 = x / middle, m2 = y / middle;
  const LanePiece piece = impact_piece(w, -friction * m1, -friction * m2);
  const lane loses = -(piece.rate.tangent_1 * m1 + piece.rate.tangent_2 * m2);
  const lane halt = loses > (lane)0 ? (u.tangent_1 * m1 + u.tangent_2 * m2) / loses : far;
  slide.piece = select_piece(slide.stops, straight, piece);
  slide.span = slide.stops ? stop : (halt < span ? halt : span);
  return slide;
}

static inline lane lane_tangential(LaneCone u) { return sqrt(u.tangent_1 * u.tangent_1 + u.tangent_2 * u.tangent_2); }

// Poisson's and Stronge's laws, in the lanes that are hit.
static inline LaneOutcome follow_impact(lane_mask hit, LaneCone u, const LaneDelassus* w, const LaneImpactMaterial* m) {
  const lane share = m->by_work ? m->restitution * m->restitution : m->restitution;
  const lane start = sqrt(u.normal * u.normal + u.tangent_1 * u.tangent_1 + u.tangent_2 * u.tangent_2);
  const lane least = (lane)SLIDE_ROUNDING * start, far = (lane)1e6 * start / w->nn;
  const LanePiece from_rest = piece_from_rest(w, m->friction), smooth = impact_piece(w, (lane)0, (lane)0);
  LaneCone r = lane_make_cone((lane)0, (lane)0, (lane)0);
  lane owed = (lane)0;
  lane_mask goes_on = hit;
  for (int k = 0; k < IMPACT_PIECES + 2; ++k) {
    const lane speed = lane_tangential(u);
    const lane_mask has_friction = k < IMPACT_PIECES ? m->friction > (lane)0 : (lane)0 > (lane)0;
    const lane_mask slides = has_friction & (speed > least);
    LanePiece piece = select_piece(has_friction, from_rest, smooth);
    lane span = far;
    lane_mask stops = (lane)0 > (lane)0;
    if (LANE_ANY(slides & goes_on)) {
      const LaneSlide slide = slide_piece(u, speed, w, m->friction, m->by_work, owed, far);
      piece = select_piece(slides, slide.piece, piece);
      span = slides ? slide.span : span;
      stops = slides & slide.stops;
    }
    const LanePhase end = impact_phase(m->by_work, u.normal, piece.rate.normal, owed, far);
    const lane_mask ends = end.impulse <= span;
    const lane p = ends ? end.impulse : span;
    const lane measure = m->by_work ? p * (u.normal + (lane)0.5 * p * piece.rate.normal) : p;
    const lane next_owed = end.compresses ? owed + share * fabs(measure) : owed - measure;
    const LaneCone next_r = lane_make_cone(r.normal + p, r.tangent_1 + p * piece.t1, r.tangent_2 + p * piece.t2);
    LaneCone next_u;
    const lane_mask ends_at_rest = ends & !end.pays;
    next_u.normal = ends_at_rest ? (lane)0 : u.normal + p * piece.rate.normal;
    stops = stops & !ends;
    next_u.tangent_1 = stops ? (lane)0 : u.tangent_1 + p * piece.rate.tangent_1;
    next_u.tangent_2 = stops ? (lane)0 : u.tangent_2 + p * piece.rate.tangent_2;
    owed = goes_on ? next_owed : owed;
    r = lane_select_cone(goes_on, next_r, r);
    u = lane_select_cone(goes_on, next_u, u);
    goes_on = goes_on & !(ends & end.pays);
    if (!LANE_ANY(goes_on)) break;
  }
  LaneOutcome outcome;
  outcome.impulse = r;
  outcome.velocity = u;
  outcome.slides = lane_tangential(u) > least;
  return outcome;
}

// Chatterjee and Ruina's law.
static inline LaneOutcome combine_impact(LaneCone u, const LaneDelassus* w, const LaneImpactMaterial* m) {
  const lane inverse_nn = (lane)1 / w->nn, g1 = w->n1 * inverse_nn, g2 = w->n2 * inverse_nn;
  const lane a11 = w->t11 - g1 * w->n1, a22 = w->t22 - g2 * w->n2, a12 = w->t12 - g1 * w->n2;
  const lane b1 = u.tangent_1 - g1 * u.normal, b2 = u.tangent_2 - g2 * u.normal;
  const lane inverse = (lane)1 / (a11 * a22 - a12 * a12);
  const lane d1 = (a12 * b2 - a22 * b1) * inverse, d2 = (a12 * b1 - a11 * b2) * inverse;
  const lane d_n = -(g1 * d1 + g2 * d2);
  const lane bounce = ((lane)1 + m->restitution) * (-u.normal * inverse_nn);
  const lane whole = (lane)1 + m->tangential_restitution;
  const lane length = sqrt(d1 * d1 + d2 * d2), limit = m->friction * (bounce + whole * d_n);
  const lane over = length - m->friction * d_n;
  const lane cut = over > (lane)0 ? m->friction * bounce / over : (lane)0;
  LaneOutcome outcome;
  outcome.slides = whole * length > limit;
  const lane k = outcome.slides ? (cut < whole ? cut : whole) : whole;
  outcome.impulse = lane_make_cone(bounce + k * d_n, k * d1, k * d2);
  const LaneCone change = lane_times(w, outcome.impulse);
  outcome.velocity =
      lane_make_cone(u.normal + change.normal, u.tangent_1 + change.tangent_1, u.tangent_2 + change.tangent_2);
  return outcome;
}

static inline LaneOutcome lane_impact(lane_mask hit, LaneCone u, const LaneDelassus* w, const LaneImpactMaterial* m) {
  LaneOutcome outcome = combine_impact(u, w, m);
  const lane_mask follows = hit & !m->combines;
  if (!LANE_ANY(follows)) return outcome;
  const LaneOutcome followed = follow_impact(follows, u, w, m);
  outcome.impulse = lane_select_cone(m->combines, outcome.impulse, followed.impulse);
  outcome.velocity = lane_select_cone(m->combines, outcome.velocity, followed.velocity);
  outcome.slides = (m->combines & outcome.slides) | (follows & followed.slides);
  return outcome;
}

// What a contact that is hit asks of the sub-step.
typedef struct LaneTarget {
  LaneCone bias;
  lane friction;
} LaneTarget;

static inline LaneTarget lane_target(const LaneOutcome* o, const LaneDelassus* w, lane friction) {
  const LaneCone r = o->impulse, u = o->velocity;
  const lane_mask slides = o->slides & (friction * friction * (w->n1 * w->n1 + w->n2 * w->n2) < w->nn * w->nn);
  const lane tangential = lane_tangential(r);
  const lane_mask has_friction = tangential > (lane)0;
  const lane d1 = has_friction ? r.tangent_1 / tangential : (lane)0,
             d2 = has_friction ? r.tangent_2 / tangential : (lane)0;
  const lane against = -(u.tangent_1 * d1 + u.tangent_2 * d2);
  const lane_mask keeps = slides & (against > (lane)0), spares = slides & (tangential < friction * r.normal);
  const lane kept = keeps ? against : (lane)0;
  LaneTarget target;
  target.bias = lane_make_cone(-u.normal, -(u.tangent_1 + kept * d1), -(u.tangent_2 + kept * d2));
  target.friction = spares ? tangential / r.normal : friction;
  return target;
}

#endif

#endif
