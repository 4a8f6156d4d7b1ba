// Capsule against box, in the frame of the box. cpu_reference/shapes/capsule_box.hpp is the twin and says more.
//
// The squared distance of p + t u, a point of the core segment, to the box is convex and piecewise quadratic in t, with
// kinks where the segment passes through the planes of the faces. Half its slope is piecewise linear, so that the kinks
// that bracket its root give the closest point exactly.
#ifndef LOCKSTEP_CAPSULE_BOX_H
#define LOCKSTEP_CAPSULE_BOX_H

#include "shapes/box_round.h"
#include "shapes/capsules.h"

// A piece of the core segment, in units of length from its middle.
typedef struct SegmentSpan {
  real from, to;
} SegmentSpan;

// The core segment in the frame of the box.
typedef struct SegmentInBox {
  Vec3 p, u;     // middle, unit direction
  real length;   // half of it
  Vec3 extents;  // of the box
} SegmentInBox;

static inline Vec3 segment_at(SegmentInBox c, real t) { return add3(c.p, scale3(t, c.u)); }

// Half the slope of the squared distance.
static inline real segment_slope(SegmentInBox c, real t) {
  const Vec3 x = segment_at(c, t);
  return dot3(sub3(x, clamp_into_box(x, c.extents)), c.u);
}

// Brackets the root of the slope by one more t.
static inline SegmentSpan segment_bracket(SegmentInBox c, SegmentSpan s, real t) {
  if (t > s.from && t < s.to) {
    if (segment_slope(c, t) <= (real)0) {
      s.from = t;
    } else {
      s.to = t;
    }
  }
  return s;
}

// The two kinks of an axis.
static inline SegmentSpan segment_kinks(SegmentInBox c, SegmentSpan s, real p, real u, real extents) {
  if (fabs(u) > (real)(1e-9)) {
    s = segment_bracket(c, s, (-extents - p) / u);
    s = segment_bracket(c, s, (extents - p) / u);
  }
  return s;
}

// Where the segment comes closest to the box: the last such place where it is parallel to a face, or inside.
static inline real segment_closest(SegmentInBox c) {
  SegmentSpan s;
  s.from = -c.length;
  s.to = c.length;
  if (segment_slope(c, s.from) > (real)0) return s.from;
  if (segment_slope(c, s.to) <= (real)0) return s.to;
  s = segment_kinks(c, s, c.p.x, c.u.x, c.extents.x);
  s = segment_kinks(c, s, c.p.y, c.u.y, c.extents.y);
  s = segment_kinks(c, s, c.p.z, c.u.z, c.extents.z);
  const real slope_from = segment_slope(c, s.from), slope_to = segment_slope(c, s.to);
  const real slope_change = slope_to - slope_from;
  return slope_change > (real)0 ? s.from - slope_from / slope_change * (s.to - s.from) : s.from;
}

// The part of a span where |p + t u| <= extents along an axis.
static inline SegmentSpan segment_between(SegmentSpan s, real p, real u, real extents) {
  if (fabs(u) > (real)(1e-9)) {
    const real t1 = (-extents - p) / u, t2 = (extents - p) / u;
    const real low = t1 < t2 ? t1 : t2, high = t1 < t2 ? t2 : t1;
    s.from = low > s.from ? low : s.from;
    s.to = high < s.to ? high : s.to;
  }
  return s;
}

// The separation of the core segment from the box along an edge of the box crossed with the segment; -1e30 where the
// two are parallel.
static inline real segment_edge_separation(SegmentInBox c, u32 k) {
  const Vec3 n = cross3(along_axis((real)1, k), c.u);
  const real square = dot3(n, n);
  if (!(square > (real)(1e-10))) return -(real)1e30;
  const real out = fabs(dot3(n, c.p)) - (fabs(n.x) * c.extents.x + fabs(n.y) * c.extents.y + fabs(n.z) * c.extents.z);
  return out / sqrt(square);
}

// Over face k both ends of what is over it touch.
static inline Manifold capsule_on_face(const WorldShape* a, const WorldShape* b, Axes axes, SegmentInBox c, u32 k,
                                       real side) {
  const u32 k1 = k == 2 ? 0 : k + 1, k2 = k == 0 ? 2 : k - 1;
  SegmentSpan s;
  s.from = -c.length;
  s.to = c.length;
  s = segment_between(s, along(c.p, k1), along(c.u, k1), along(c.extents, k1));
  s = segment_between(s, along(c.p, k2), along(c.u, k2), along(c.extents, k2));
  if (!(s.from <= s.to)) {  // only by rounding
    s.from = segment_closest(c);
    s.to = s.from;
  }
  Manifold m = manifold_along(out_of_frame(axes, along_axis(side, k)), NORMAL_OF_B, a->size.x, (real)0);
  const Vec3 first = segment_at(c, s.from), last = segment_at(c, s.to);
  const real top = side * along(c.extents, k);
  const u32 two = s.to - s.from > (real)0.001 * c.length ? 1 : 0;
  if (two || side * along(first, k) <= side * along(last, k))
    m = with_point(m, add3(b->center, out_of_frame(axes, first)),
                   add3(b->center, out_of_frame(axes, with_along(first, k, top))), 0);
  if (two || side * along(first, k) > side * along(last, k))
    m = with_point(m, add3(b->center, out_of_frame(axes, last)),
                   add3(b->center, out_of_frame(axes, with_along(last, k, top))), 1);
  return m;
}

// The core crosses an edge of the box along axis k, or its end is over that edge, at t and at a point of the edge, n
// from there to the core.
static inline Manifold capsule_across_edge(const WorldShape* a, const WorldShape* b, Axes axes, SegmentInBox c, Vec3 n,
                                           real t, Vec3 on_edge, u32 k, u32 feature) {
  const Vec3 edge = along_axis((real)1, k), across = cross3(c.u, edge);
  real on_core = t, on_box = along(on_edge, k);
  if (fabs(t) < c.length && !side_by_side(dot3(across, across))) {
    const Vec3 at = add3(b->center, out_of_frame(axes, on_edge));
    const Vec3 core = add3(b->center, out_of_frame(axes, segment_at(c, t)));
    const Vec3 displacement = into_frame(axes, lagging_displacement(a, core, b, at));
    const CrossingShift shift = crossing_shift(c.u, edge, n, displacement);
    on_core = clamp_to(t + shift.along_first, c.length);
    on_box = clamp_to(on_box + shift.along_second, along(c.extents, k));
  }
  return manifold_at(out_of_frame(axes, n), NORMAL_FIXED, add3(b->center, out_of_frame(axes, segment_at(c, on_core))),
                     a->size.x, add3(b->center, out_of_frame(axes, with_along(on_edge, k, on_box))), (real)0, feature);
}

// The core crosses an edge of the box along axis k inside the box.
static inline Manifold capsule_on_edge(const WorldShape* a, const WorldShape* b, Axes axes, SegmentInBox c, u32 k) {
  Vec3 n = cross3(along_axis((real)1, k), c.u);
  n = scale3(sign_of(dot3(n, c.p)) / length3(n), n);  // from the box to the segment
  const Vec3 corner =
      with_along(make3(sign_of(n.x) * c.extents.x, sign_of(n.y) * c.extents.y, sign_of(n.z) * c.extents.z), k, (real)0);
  // closest points of the lines p + t u and corner + s e_k
  const Vec3 w = sub3(c.p, corner);
  const real cosine = along(c.u, k), wu = dot3(w, c.u), wk = along(w, k);
  const real square_sine = (real)1 - cosine * cosine;
  const real t = clamp_to((cosine * wk - wu) / square_sine, c.length);
  const real s = clamp_to((wk - cosine * wu) / square_sine, along(c.extents, k));
  const u32 feature = 2 + 4 * k + (along(corner, k == 2 ? 0 : k + 1) > (real)0 ? 1 : 0) +
                      (along(corner, k == 0 ? 2 : k - 1) > (real)0 ? 2 : 0);
  return capsule_across_edge(a, b, axes, c, n, t, with_along(corner, k, s), k, feature);
}

// The face that the shortest way from x, outside, to the box is perpendicular to, but for rounding. 3 if there is none.
static inline u32 box_face_below(Vec3 x, Vec3 extents) {
  const Vec3 out = sub3(x, clamp_into_box(x, extents));
  const u32 k = box_face_at(x, extents);
  const Vec3 beside = with_along(out, k, (real)0);
  const real height = along(out, k);
  return dot3(beside, beside) <= (real)2.5e-9 * (height * height) ? k : 3;
}

static inline real larger_of(real x, real y) { return x < y ? y : x; }

// The axis of the box that the core runs along most.
static inline u32 segment_axis(SegmentInBox c) {
  const u32 k = fabs(c.u.y) > fabs(c.u.x) ? 1 : 0;
  return fabs(c.u.z) > fabs(along(c.u, k)) ? 2 : k;
}

// The part of the core that runs beside an edge of the box, x at t its closest point; empty where it crosses the edge,
// or passes it by.
static inline SegmentSpan capsule_beside_edge(const WorldShape* a, SegmentInBox c, Vec3 x, real t) {
  const u32 k = segment_axis(c), k1 = k == 2 ? 0 : k + 1, k2 = k == 0 ? 2 : k - 1;
  const real u1 = along(c.u, k1), u2 = along(c.u, k2);
  SegmentSpan s;
  s.from = -c.length;
  s.to = c.length;
  s = segment_between(s, along(c.p, k), along(c.u, k), along(c.extents, k));
  const bool over_edge = fabs(along(x, k1)) > along(c.extents, k1) && fabs(along(x, k2)) > along(c.extents, k2);
  const bool lies = side_by_side(u1 * u1 + u2 * u2) && s.to - s.from > (real)0.01 * a->size.x;
  // as far as x, if that is past the corner
  s.from = t < s.from ? t : s.from;
  s.to = t > s.to ? t : s.to;
  if (!over_edge || !lies) s.to = s.from;
  return s;
}

// Both ends of that part touch.
static inline Manifold capsule_along_edge(const WorldShape* a, const WorldShape* b, Axes axes, SegmentInBox c,
                                          Vec3 edge, SegmentSpan s, Vec3 normal) {
  const u32 k = segment_axis(c);
  Manifold m = manifold_along(normal, NORMAL_FIXED, a->size.x, (real)0);
  for (u32 end = 0; end < 2; ++end) {
    const Vec3 core = segment_at(c, end == 0 ? s.from : s.to);
    const Vec3 on_edge = with_along(edge, k, clamp_to(along(core, k), along(c.extents, k)));
    m = with_point(m, add3(b->center, out_of_frame(axes, core)), add3(b->center, out_of_frame(axes, on_edge)),
                   14 + end);
  }
  return m;
}

// A core that is nearest to the box at t and lies nearly along face k touches at the other end of what is over the
// face, too.
static inline Manifold capsule_lies_on_face(const WorldShape* a, const WorldShape* b, Axes axes, SegmentInBox c,
                                            Manifold m, real t, u32 k) {
  const u32 k1 = k == 2 ? 0 : k + 1, k2 = k == 0 ? 2 : k - 1;
  const Vec3 n = into_frame(axes, m.normal);
  const real n1 = along(n, k1), n2 = along(n, k2);
  if (!side_by_side(n1 * n1 + n2 * n2)) return m;
  SegmentSpan s;
  s.from = -c.length;
  s.to = c.length;
  s = segment_between(s, along(c.p, k1), along(c.u, k1), along(c.extents, k1));
  s = segment_between(s, along(c.p, k2), along(c.u, k2), along(c.extents, k2));
  const real end = t - s.from > s.to - t ? s.from : s.to, travel = end < t ? t - end : end - t;
  if (!(s.from < s.to) || !(travel > (real)0.01 * a->size.x)) return m;
  // in line along the normal, but no farther than the face
  const Vec3 core = segment_at(c, end);
  const real height = along(core, k) - sign_of(along(n, k)) * along(c.extents, k);
  const Vec3 foot = clamp_into_box(sub3(core, scale3(height / along(n, k), n)), c.extents);
  m.frame = NORMAL_FIXED;
  return with_point(m, add3(b->center, out_of_frame(axes, core)), add3(b->center, out_of_frame(axes, foot)), 16);
}

// a is the capsule. While its core is outside the box the closest points decide; once it is inside, the axis of least
// penetration.
CALLED Manifold capsule_box(const WorldShape* a, const WorldShape* b) {
  const Axes axes = axes_of(b->rotation);
  SegmentInBox c;
  c.p = into_frame(axes, sub3(a->center, b->center));
  c.u = into_frame(axes, axes_of(a->rotation).z);
  c.length = a->size.y;
  c.extents = b->size;
  const real t = segment_closest(c);
  const Vec3 x = segment_at(c, t);
  const u32 outside = coordinates_outside(x, c.extents);
  const u32 face = outside > 0 ? box_face_below(x, c.extents) : 3;
  if (face < 3) {
    // as far as x, if that is over the edge
    const Vec3 wide_extents =
        make3(larger_of(c.extents.x, fabs(x.x)), larger_of(c.extents.y, fabs(x.y)), larger_of(c.extents.z, fabs(x.z)));
    c.extents = with_along(wide_extents, face, along(c.extents, face));
    return capsule_on_face(a, b, axes, c, face, sign_of(along(x, face)));
  }
  if (outside > 0) {
    const Vec3 core_a = add3(b->center, out_of_frame(axes, x)), in_box = clamp_into_box(x, c.extents);
    const Vec3 core_b = add3(b->center, out_of_frame(axes, in_box));
    const Vec3 normal = direction_between(core_a, core_b, (real)0, axes.z);
    const SegmentSpan s = capsule_beside_edge(a, c, x, t);
    if (s.from < s.to) return capsule_along_edge(a, b, axes, c, in_box, s, normal);
    Manifold m = manifold_at(normal, NORMAL_BETWEEN, core_a, a->size.x, core_b, (real)0, 0);
    // which edge the core is over; only a corner is a point that the normal turns about
    const u32 k = fabs(x.x) <= c.extents.x ? 0 : fabs(x.y) <= c.extents.y ? 1 : 2;
    if (outside == 2) m = capsule_across_edge(a, b, axes, c, into_frame(axes, normal), t, in_box, k, 0);
    return capsule_lies_on_face(a, b, axes, c, m, t, box_face_at(x, c.extents));
  }
  // how far the segment sticks out of the box along each axis, negative inside
  real best = -(real)1e30;
  u32 axis = 0;
  for (u32 k = 0; k < 3; ++k) {
    const real s = fabs(along(c.p, k)) - along(c.extents, k) - fabs(along(c.u, k)) * c.length;
    if (s > best) {
      best = s;
      axis = k;
    }
  }
  for (u32 k = 0; k < 3; ++k) {
    const real s = segment_edge_separation(c, k);
    if (s > best) {
      best = s;
      axis = 3 + k;
    }
  }
  if (axis < 3) return capsule_on_face(a, b, axes, c, axis, sign_of(along(c.p, axis)));
  return capsule_on_edge(a, b, axes, c, axis - 3);
}

#endif
