// Polytope against polytope: which direction separates them best. kernels/shapes/polytopes.h is the twin.
//
// Every s(n) = min over a of n.x - max over b of n.x is a lower bound of the signed separation, which is the largest of
// them. Of polytopes that overlap the best n is a face normal, or the cross product of two edges whose arcs on the
// Gauss map cross (Gregorius, "The Separating Axis Test between Convex Polyhedra", GDC 2013); of polytopes that are
// apart it may also be the line between the closest points of two edges.
#pragma once

#include "cpu_reference/shapes/facet.hpp"
#include "cpu_reference/shapes/seams.hpp"

namespace lockstep::reference {

/// Of the faces of p the one that q is farthest in front of, and the vertex of q that is nearest to it.
template <class real>
struct FaceQuery {
  real gap;
  Vec3<real> normal;  // out of p, world
  u32 vertex;
};

/// Stops at the first gap above the limit. Where none of the faces counts the gap is -1e30.
template <class real>
FaceQuery<real> poly_face_query(const Polytope<real>& p, const Polytope<real>& q, real limit) {
  FaceQuery<real> best;
  best.gap = real(-1e30);
  best.normal = Vec3<real>{0, 0, 1};
  best.vertex = 0;
  const Vec3<real> offset = sub3(q.center, p.center);
  for (u32 f = 0; f < p.faces && !(best.gap > limit); ++f) {
    const Vec4<real> plane = poly_own_plane(p, f);
    const Vec3<real> normal = out_of_frame(p.axes, Vec3<real>{plane.x, plane.y, plane.z});
    const Vec3<real> down = into_frame(q.axes, scale3(real(-1), normal));
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

template <class real>
Vec3<real> poly_carry(const Polytope<real>& p, const Polytope<real>& q, Vec3<real> own) {
  return into_frame(q.axes, out_of_frame(p.axes, own));
}

/// An edge of p in the frame of q.
template <class real>
EdgeSpan<real> poly_edge_in(const Polytope<real>& p, u32 e, const Polytope<real>& q) {
  const EdgeSpan<real> own = poly_own_edge(p, e);
  EdgeSpan<real> span;
  span.start = add3(into_frame(q.axes, sub3(p.center, q.center)), poly_carry(p, q, own.start));
  span.along = poly_carry(p, q, own.along);
  span.left = poly_carry(p, q, own.left);
  span.right = poly_carry(p, q, own.right);
  return span;
}

/// The arcs of two edges cross on the Gauss map, one of them turned round: the two can be what keeps the shapes apart.
/// The edge of a segment has a whole great circle for an arc.
template <class real>
bool arcs_cross(const EdgeSpan<real>& a, bool a_has_faces, const EdgeSpan<real>& b) {
  const real b_right = dot3(b.right, a.along), b_left = dot3(b.left, a.along);
  if (!(b_right * b_left < 0)) return false;
  if (!a_has_faces) return true;
  const real a_right = dot3(a.right, b.along), a_left = dot3(a.left, b.along);
  return a_right * a_left < 0 && b_right * a_left < 0;
}

/// Where line a is nearest to line b, as a share of edge a: 0 at its start, 1 at its end; `across` is a.along x
/// b.along, or its opposite.
template <class real>
real share_at_crossing(const EdgeSpan<real>& a, const EdgeSpan<real>& b, Vec3<real> across) {
  return dot3(cross3(sub3(b.start, a.start), b.along), across) / dot3(across, across);
}

/// The separation along a unit normal from b to a: a lower bound of the true one.
template <class real>
real polytopes_bound(const Polytope<real>& a, const Polytope<real>& b, Vec3<real> normal) {
  return dot3(normal, sub3(a.center, b.center)) - poly_extent(a, scale3(real(-1), normal)) - poly_extent(b, normal);
}

/// Two crossing edges against what the faces gave.
template <class real>
Meeting<real> poly_edge_query(const Polytope<real>& a, const Polytope<real>& b, Meeting<real> best, real tolerance) {
  for (u32 i = 0; i < a.edges; ++i) {
    const EdgeSpan<real> edge_a = poly_edge_in(a, i, b);
    for (u32 j = 0; j < b.edges; ++j) {
      const EdgeSpan<real> edge_b = poly_own_edge(b, j);
      if (!arcs_cross(edge_a, a.faces > 0, edge_b)) continue;
      const Vec3<real> across = cross3(edge_a.along, edge_b.along);
      const real square = dot3(across, across);
      if (!(square > real(1e-10) * dot3(edge_a.along, edge_a.along) * dot3(edge_b.along, edge_b.along))) continue;
      const real length = std::sqrt(square);
      const real side = dot3(across, add3(edge_b.left, edge_b.right)) < 0 ? real(-1) : real(1);
      const real gap = side * dot3(across, sub3(edge_a.start, edge_b.start)) / length;
      if (!(gap > meeting_least(best, tolerance))) continue;
      // The best of all crossings is one of edges, not of the lines that they are on; any tells that shapes are apart.
      const real s = share_at_crossing(edge_a, edge_b, across);
      const real t = share_at_crossing(edge_b, edge_a, scale3(real(-1), across));
      if (!(gap > 0) && (!within_share(s) || !within_share(t))) continue;
      // edges that are nearly parallel may cross by rounding only: then others reach farther along their normal
      const Vec3<real> normal = out_of_frame(b.axes, scale3(side / length, across));
      const real bound = polytopes_bound(a, b, normal);
      if (gap - bound > real(4) * tolerance) continue;
      const Vec3<real> on_a = add3(edge_a.start, scale3(clamp_share(s), edge_a.along));
      const Vec3<real> on_b = add3(edge_b.start, scale3(clamp_share(t), edge_b.along));
      const Vec3<real> at_a = add3(b.center, out_of_frame(b.axes, on_a)),
                       at_b = add3(b.center, out_of_frame(b.axes, on_b));
      if (a.seam_count > 0 &&
          seams_cover(a, into_frame(a.axes, sub3(at_a, a.center)), into_frame(a.axes, scale3(real(-1), normal))))
        continue;
      if (b.seam_count > 0 && seams_cover(b, on_b, into_frame(b.axes, normal))) continue;
      best = meeting_offer(best, bound, normal, NORMAL_FIXED, at_a, at_b, tolerance);
    }
  }
  return best;
}

/// The closest points of the edges of shapes that are apart, as the line between them (Ericson, Real-Time Collision
/// Detection, 5.1.9). Of points that are as close but for rounding, as those of the edges of a vertex are, the line
/// that separates best.
template <class real>
Meeting<real> poly_closest_edges(const Polytope<real>& a, const Polytope<real>& b, Meeting<real> best, real tolerance) {
  real least = real(1e30), gap = real(-1e30);
  Vec3<real> normal = Vec3<real>{0, 0, 1}, between = normal, on_a = Vec3<real>{0, 0, 0};
  for (u32 i = 0; i < a.edges; ++i) {
    const EdgeSpan<real> edge_a = poly_edge_in(a, i, b);
    for (u32 j = 0; j < b.edges; ++j) {
      const EdgeSpan<real> edge_b = poly_own_edge(b, j);
      const Vec3<real> r = sub3(edge_a.start, edge_b.start);
      const real aa = dot3(edge_a.along, edge_a.along), bb = dot3(edge_b.along, edge_b.along);
      const real ab = dot3(edge_a.along, edge_b.along), ar = dot3(edge_a.along, r), br = dot3(edge_b.along, r);
      const real square = aa * bb - ab * ab;
      real s = square > real(1e-10) * aa * bb ? clamp_share((ab * br - ar * bb) / square) : real(0);
      const real t = clamp_share((ab * s + br) / bb);
      s = clamp_share((ab * t - ar) / aa);
      const Vec3<real> point = add3(edge_a.start, scale3(s, edge_a.along));
      const Vec3<real> d = sub3(point, add3(edge_b.start, scale3(t, edge_b.along)));
      const real distance = dot3(d, d);
      if (!(distance <= real(1.00001) * least) || !(distance > 0)) continue;
      const Vec3<real> along = out_of_frame(b.axes, scale3(real(1) / std::sqrt(distance), d));
      if (!facets_admit(a, b, along)) continue;
      const real bound = polytopes_bound(a, b, along);
      if (!(bound > gap) && !(distance < real(0.99999) * least)) continue;
      least = distance;
      gap = bound;
      normal = along;
      between = d;
      on_a = point;
    }
  }
  // crossing edges give way to closest points, which lie on both shapes
  if (best.frame == NORMAL_FIXED) best.gap = best.gap - real(2) * tolerance;
  const Vec3<real> at_a = add3(b.center, out_of_frame(b.axes, on_a));
  const Vec3<real> at_b = add3(b.center, out_of_frame(b.axes, sub3(on_a, between)));
  return meeting_offer(best, gap, normal, NORMAL_FIXED, at_a, at_b, tolerance);
}

/// Along the normal of a face of a, at the vertex of b that is nearest to it.
template <class real>
Meeting<real> poly_meet_face_of_a(const Polytope<real>& a, const Polytope<real>& b, Meeting<real> best, real limit,
                                  real tolerance) {
  const FaceQuery<real> face = poly_face_query(a, b, limit);
  const Vec3<real> normal = scale3(real(-1), face.normal), vertex = poly_vertex(b, face.vertex);
  return meeting_offer(best, face.gap, normal, NORMAL_OF_A, add3(vertex, scale3(face.gap, normal)), vertex, tolerance);
}

template <class real>
Meeting<real> poly_meet_face_of_b(const Polytope<real>& a, const Polytope<real>& b, Meeting<real> best, real limit,
                                  real tolerance) {
  const FaceQuery<real> face = poly_face_query(b, a, limit);
  const Vec3<real> vertex = poly_vertex(a, face.vertex);
  return meeting_offer(best, face.gap, face.normal, NORMAL_OF_B, vertex, sub3(vertex, scale3(face.gap, face.normal)),
                       tolerance);
}

/// The best normal. Gaps above the limit are not looked into any further.
template <class real>
Meeting<real> polytopes_meet(const Polytope<real>& a, const Polytope<real>& b, real limit, real tolerance) {
  Meeting<real> best = poly_meet_face_of_a(a, b, no_meeting<real>(), limit, tolerance);
  if (best.gap > limit) return best;
  best = poly_meet_face_of_b(a, b, best, limit, tolerance);
  if (best.gap > limit) return best;
  best = poly_edge_query(a, b, best, tolerance);
  if (best.gap > limit || !(best.gap > 0)) return best;
  return poly_closest_edges(a, b, best, tolerance);
}

}  // namespace lockstep::reference
