// Polytope against polytope: which direction separates them best. cpu_reference/shapes/polytopes.hpp is the twin.
//
// Every s(n) = min over a of n.x - max over b of n.x is a lower bound of the signed separation, which is the largest of
// them. Of polytopes that overlap the best n is a face normal, or the cross product of two edges whose arcs on the
// Gauss map cross (Gregorius, "The Separating Axis Test between Convex Polyhedra", GDC 2013); of polytopes that are
// apart it may also be the line between the closest points of two edges.
#ifndef LOCKSTEP_POLYTOPES_H
#define LOCKSTEP_POLYTOPES_H

#include "common.h"
#include "shapes/edge_lanes.h"
#include "shapes/facet.h"
#include "shapes/seams.h"

// Of the faces of p the one that q is farthest in front of, and the vertex of q that is nearest to it.
typedef struct FaceQuery {
  real gap;
  Vec3 normal;  // out of p, world
  u32 vertex;
} FaceQuery;

// Stops at the first gap above the limit. Where none of the faces counts the gap is -1e30.
CALLED FaceQuery poly_face_query(const Polytope* p, const Polytope* q, real limit) {
  FaceQuery best;
  best.gap = (real)-1e30;
  best.normal = make3((real)0, (real)0, (real)1);
  best.vertex = 0;
  const Vec3 offset = sub3(q->center, p->center);
  for (u32 f = 0; f < p->faces && !(best.gap > limit); ++f) {
    const Vec4 plane = poly_own_plane(p, f);
    const Vec3 normal = out_of_frame(p->axes, make3(plane.x, plane.y, plane.z));
    const Vec3 down = into_frame(q->axes, scale3((real)-1, normal));
    if (!facet_looks_at(p, dot3(normal, offset) - plane.w)) continue;
    const u32 vertex = poly_support(q, down);
    const real gap = dot3(normal, offset) - dot3(down, poly_own_vertex(q, vertex)) - plane.w;
    if (gap > best.gap && facet_admits(q, down)) {
      best.gap = gap;
      best.normal = normal;
      best.vertex = vertex;
    }
  }
  return best;
}

static inline Vec3 poly_carry(const Polytope* p, const Polytope* q, Vec3 own) {
  return into_frame(q->axes, out_of_frame(p->axes, own));
}

// An edge of p in the frame of q.
static inline EdgeSpan poly_edge_in(const Polytope* p, u32 e, const Polytope* q) {
  const EdgeSpan own = poly_own_edge(p, e);
  EdgeSpan span;
  span.start = add3(into_frame(q->axes, sub3(p->center, q->center)), poly_carry(p, q, own.start));
  span.along = poly_carry(p, q, own.along);
  span.left = poly_carry(p, q, own.left);
  span.right = poly_carry(p, q, own.right);
  return span;
}

// The arcs of two edges cross on the Gauss map, one of them turned round: the two can be what keeps the shapes apart.
// The edge of a segment has a whole great circle for an arc.
static inline bool arcs_cross(const EdgeSpan* a, bool a_has_faces, const EdgeSpan* b) {
  const real b_right = dot3(b->right, a->along), b_left = dot3(b->left, a->along);
  if (!(b_right * b_left < (real)0)) return false;
  if (!a_has_faces) return true;
  const real a_right = dot3(a->right, b->along), a_left = dot3(a->left, b->along);
  return a_right * a_left < (real)0 && b_right * a_left < (real)0;
}

// Where line a is nearest to line b, as a share of edge a: 0 at its start, 1 at its end; `across` is a.along x
// b.along, or its opposite.
static inline real share_at_crossing(const EdgeSpan* a, const EdgeSpan* b, Vec3 across) {
  return dot3(cross3(sub3(b->start, a->start), b->along), across) / dot3(across, across);
}

// The separation along a unit normal from b to a: a lower bound of the true one.
static inline real polytopes_bound(const Polytope* a, const Polytope* b, Vec3 normal) {
  return dot3(normal, sub3(a->center, b->center)) - poly_extent(a, scale3((real)-1, normal)) - poly_extent(b, normal);
}

// Two crossing edges against what is best so far.
CALLED Meeting poly_cross_edges(const Polytope* a, const Polytope* b, const EdgeSpan* edge_a, u32 j, Meeting best,
                                real tolerance) {
  const EdgeSpan edge_b = poly_own_edge(b, j);
  const Vec3 across = cross3(edge_a->along, edge_b.along);
  const real square = dot3(across, across);
  if (!(square > (real)1e-10 * dot3(edge_a->along, edge_a->along) * dot3(edge_b.along, edge_b.along))) return best;
  const real length = sqrt(square);
  const real side = dot3(across, add3(edge_b.left, edge_b.right)) < (real)0 ? (real)-1 : (real)1;
  const real gap = side * dot3(across, sub3(edge_a->start, edge_b.start)) / length;
  if (!(gap > meeting_least(&best, tolerance))) return best;
  // The best of all crossings is one of edges, not of the lines that they are on; any tells that shapes are apart.
  const real s = share_at_crossing(edge_a, &edge_b, across);
  const real t = share_at_crossing(&edge_b, edge_a, scale3((real)-1, across));
  if (!(gap > (real)0) && (!within_share(s) || !within_share(t))) return best;
  // edges that are nearly parallel may cross by rounding only: then others reach farther along their normal
  const Vec3 normal = out_of_frame(b->axes, scale3(side / length, across));
  const real bound = polytopes_bound(a, b, normal);
  if (gap - bound > (real)4 * tolerance) return best;
  const Vec3 on_a = add3(edge_a->start, scale3(clamp_share(s), edge_a->along));
  const Vec3 on_b = add3(edge_b.start, scale3(clamp_share(t), edge_b.along));
  const Vec3 at_a = add3(b->center, out_of_frame(b->axes, on_a)), at_b = add3(b->center, out_of_frame(b->axes, on_b));
#if FEATURE_SEAMS
  if (a->seam_count > 0u &&
      seams_cover(a, into_frame(a->axes, sub3(at_a, a->center)), into_frame(a->axes, scale3((real)-1, normal))))
    return best;
  if (b->seam_count > 0u && seams_cover(b, on_b, into_frame(b->axes, normal))) return best;
#endif
  return meeting_offer(best, bound, normal, NORMAL_FIXED, at_a, at_b, tolerance);
}

#if LANES > 1
static inline Meeting poly_edge_query_in_lanes(const Polytope* a, const Polytope* b, Meeting best, real tolerance) {
  EdgeLanes edges_b;
  edge_lanes_of(&edges_b, b);
  for (u32 i = 0; i < a->edges; ++i) {
    const EdgeSpan edge_a = poly_edge_in(a, i, b);
    for (u32 first = 0u; first < edges_b.count; first += LANES) {
      u32 bits = arcs_crossing(&edge_a, a->faces > 0, &edges_b, first);
      for (; bits != 0u; bits &= bits - 1u)  // the lowest first
        best = poly_cross_edges(a, b, &edge_a, first + lowest_bit(bits), best, tolerance);
    }
  }
  return best;
}
#endif

// All crossing edges against what the faces gave.
CALLED Meeting poly_edge_query(const Polytope* a, const Polytope* b, Meeting best, real tolerance) {
#if LANES > 1
  if (a->edges > 1) return poly_edge_query_in_lanes(a, b, best, tolerance);  // the lanes are filled once for all of a
#endif
  for (u32 i = 0; i < a->edges; ++i) {
    const EdgeSpan edge_a = poly_edge_in(a, i, b);
    for (u32 j = 0; j < b->edges; ++j) {
      const EdgeSpan edge_b = poly_own_edge(b, j);
      if (arcs_cross(&edge_a, a->faces > 0, &edge_b)) best = poly_cross_edges(a, b, &edge_a, j, best, tolerance);
    }
  }
  return best;
}

// The closest points of the edges of shapes that are apart, as the line between them (Ericson, Real-Time Collision
// Detection, 5.1.9). Of points that are as close but for rounding, as those of the edges of a vertex are, the line that
// separates best.
CALLED Meeting poly_closest_edges(const Polytope* a, const Polytope* b, Meeting best, real tolerance) {
  real least = (real)1e30, gap = (real)-1e30;
  Vec3 normal = make3((real)0, (real)0, (real)1), between = normal, on_a = make3((real)0, (real)0, (real)0);
  for (u32 i = 0; i < a->edges; ++i) {
    const EdgeSpan edge_a = poly_edge_in(a, i, b);
    for (u32 j = 0; j < b->edges; ++j) {
      const EdgeSpan edge_b = poly_own_edge(b, j);
      const Vec3 r = sub3(edge_a.start, edge_b.start);
      const real aa = dot3(edge_a.along, edge_a.along), bb = dot3(edge_b.along, edge_b.along);
      const real ab = dot3(edge_a.along, edge_b.along), ar = dot3(edge_a.along, r), br = dot3(edge_b.along, r);
      const real square = aa * bb - ab * ab;
      real s = square > (real)1e-10 * aa * bb ? clamp_share((ab * br - ar * bb) / square) : (real)0;
      const real t = clamp_share((ab * s + br) / bb);
      s = clamp_share((ab * t - ar) / aa);
      const Vec3 point = add3(edge_a.start, scale3(s, edge_a.along));
      const Vec3 d = sub3(point, add3(edge_b.start, scale3(t, edge_b.along)));
      const real distance = dot3(d, d);
      if (!(distance <= (real)1.00001 * least) || !(distance > (real)0)) continue;
      const Vec3 along = out_of_frame(b->axes, scale3((real)1 / sqrt(distance), d));
      if (!facets_admit(a, b, along)) continue;
      const real bound = polytopes_bound(a, b, along);
      if (!(bound > gap) && !(distance < (real)0.99999 * least)) continue;
      least = distance;
      gap = bound;
      normal = along;
      between = d;
      on_a = point;
    }
  }
  // crossing edges give way to closest points, which lie on both shapes
  if (best.frame == NORMAL_FIXED) best.gap = best.gap - (real)2 * tolerance;
  const Vec3 at_a = add3(b->center, out_of_frame(b->axes, on_a));
  const Vec3 at_b = add3(b->center, out_of_frame(b->axes, sub3(on_a, between)));
  return meeting_offer(best, gap, normal, NORMAL_FIXED, at_a, at_b, tolerance);
}

// Along the normal of a face of a, at the vertex of b that is nearest to it.
static inline Meeting poly_meet_face_of_a(const Polytope* a, const Polytope* b, Meeting best, real limit,
                                          real tolerance) {
  const FaceQuery face = poly_face_query(a, b, limit);
  const Vec3 normal = scale3((real)-1, face.normal), vertex = poly_vertex(b, face.vertex);
  return meeting_offer(best, face.gap, normal, NORMAL_OF_A, add3(vertex, scale3(face.gap, normal)), vertex, tolerance);
}

static inline Meeting poly_meet_face_of_b(const Polytope* a, const Polytope* b, Meeting best, real limit,
                                          real tolerance) {
  const FaceQuery face = poly_face_query(b, a, limit);
  const Vec3 vertex = poly_vertex(a, face.vertex);
  return meeting_offer(best, face.gap, face.normal, NORMAL_OF_B, vertex, sub3(vertex, scale3(face.gap, face.normal)),
                       tolerance);
}

// The best normal. Gaps above the limit are not looked into any further.
CALLED Meeting polytopes_meet(const Polytope* a, const Polytope* b, real limit, real tolerance) {
  Meeting best = poly_meet_face_of_a(a, b, no_meeting(), limit, tolerance);
  if (best.gap > limit) return best;
  best = poly_meet_face_of_b(a, b, best, limit, tolerance);
  if (best.gap > limit) return best;
  best = poly_edge_query(a, b, best, tolerance);
  if (best.gap > limit || !(best.gap > (real)0)) return best;
  return poly_closest_edges(a, b, best, tolerance);
}

#endif
