// A cylinder against a polytope: which direction separates them best. cpu_reference/shapes/cylinder_polytope.hpp is the
// twin.
//
// As for polytopes (polytopes.hpp) every direction is a lower bound of the signed separation. The best one is the
// normal of a face or a cap, the cross product of the axis and an edge, the way from the axis to a vertex, or the
// shortest line between a rim and an edge or a vertex. Those that cannot beat the best so far, were their two features
// the farthest ones, are not looked into.
#ifndef LOCKSTEP_CYLINDER_POLYTOPE_H
#define LOCKSTEP_CYLINDER_POLYTOPE_H

#include "shapes/cylinder.h"
#include "shapes/polytopes.h"
#include "shapes/rim_lanes.h"

// Offers the meeting along a unit normal from p to c. Its points are those that were looked at if these are where the
// two reach farthest; else others are, and the normal is offered with those, if it is the best one.
CALLED Meeting cylinder_try(const Cylinder* c, const Polytope* p, Meeting best, Vec3 normal, Vec3 at_c, Vec3 at_p,
                            real tolerance) {
  if (!facet_admits(p, into_frame(p->axes, normal))) return best;
  const real gap =
      dot3(normal, sub3(c->center, p->center)) - cylinder_extent(c, scale3((real)-1, normal)) - poly_extent(p, normal);
  const real off = dot3(normal, sub3(at_c, at_p)) - gap;
  if (off <= (real)4 * tolerance) return meeting_offer(best, gap, normal, NORMAL_FIXED, at_c, at_p, tolerance);
  if (!(gap > best.gap + tolerance)) return best;
  const Vec3 vertex = poly_vertex(p, poly_support(p, into_frame(p->axes, normal)));
  return meeting_offer(best, gap, normal, NORMAL_FIXED, cylinder_support(c, scale3((real)-1, normal)), vertex,
                       tolerance);
}

CALLED Meeting cylinder_try_flats(const Cylinder* c, const Polytope* p, real limit, real tolerance) {
  Meeting best = no_meeting();
  const Vec3 offset = sub3(c->center, p->center);
  for (u32 f = 0; f < p->faces && !(best.gap > limit); ++f) {
    const Vec4 plane = poly_own_plane(p, f);
    const Vec3 normal = out_of_frame(p->axes, make3(plane.x, plane.y, plane.z));
    if (!facet_looks_at(p, dot3(normal, offset) - plane.w)) continue;
    const real gap = dot3(normal, offset) - plane.w - cylinder_extent(c, scale3((real)-1, normal));
    const Vec3 on_c = cylinder_support(c, scale3((real)-1, normal));
    best = meeting_offer(best, gap, normal, NORMAL_OF_B, on_c, sub3(on_c, scale3(gap, normal)), (real)0);
  }
  for (u32 end = 0; end < 2 && !(best.gap > limit); ++end) {
    const Vec3 normal = scale3(end == 0 ? (real)1 : (real)-1, c->axes.z);
    const Vec3 own = into_frame(p->axes, normal);
    if (!facet_admits(p, own)) continue;
    const Vec3 vertex = poly_vertex(p, poly_support(p, own));
    const real gap = dot3(normal, sub3(c->center, vertex)) - c->half_length;
    best = meeting_offer(best, gap, normal, NORMAL_OF_A, add3(vertex, scale3(gap, normal)), vertex, tolerance);
  }
  return best;
}

// The side of the cylinder against edges.
CALLED Meeting cylinder_try_edges(const Cylinder* c, const Polytope* p, Meeting best, real tolerance) {
  EdgeSpan axis;
  axis.start = into_frame(p->axes, sub3(cylinder_cap(c, 0), p->center));
  axis.along = into_frame(p->axes, scale3((real)2 * c->half_length, c->axes.z));
  axis.left = make3((real)0, (real)0, (real)0);
  axis.right = axis.left;
  for (u32 e = 0; e < p->edges; ++e) {
    const EdgeSpan edge = poly_own_edge(p, e);
    if (p->faces > 0 && !arcs_cross(&axis, false, &edge)) continue;
    const Vec3 across = cross3(axis.along, edge.along);
    const real square = dot3(across, across);
    if (!(square > (real)1e-10 * dot3(axis.along, axis.along) * dot3(edge.along, edge.along))) continue;
    const Vec3 offset = sub3(axis.start, edge.start);
    const real facing = p->faces > 0 ? dot3(across, add3(edge.left, edge.right)) : dot3(across, offset);
    const real factor = (facing < (real)0 ? (real)-1 : (real)1) / sqrt(square);
    const real gap = factor * dot3(across, offset) - c->radius;
    if (!(gap > meeting_least(&best, tolerance))) continue;
    // the best of all crossings is one of the axis and an edge, not of the lines that they are on
    const real s = share_at_crossing(&axis, &edge, across);
    const real t = share_at_crossing(&edge, &axis, scale3((real)-1, across));
    if (!within_share(s) || !within_share(t)) continue;
    const Vec3 normal = out_of_frame(p->axes, scale3(factor, across));
    const Vec3 on_axis = add3(cylinder_cap(c, 0), scale3(clamp_share(s) * (real)2 * c->half_length, c->axes.z));
    const Vec3 on_edge = add3(edge.start, scale3(clamp_share(t), edge.along));
    best = cylinder_try(c, p, best, normal, sub3(on_axis, scale3(c->radius, normal)),
                        add3(p->center, out_of_frame(p->axes, on_edge)), tolerance);
  }
  return best;
}

// The side of the cylinder, and its rims, against vertices.
CALLED Meeting cylinder_try_vertices(const Cylinder* c, const Polytope* p, Meeting best, real tolerance) {
  for (u32 i = 0; i < p->vertices; ++i) {
    const Vec3 vertex = poly_vertex(p, i);
    const Vec3 w = sub3(c->center, vertex);
    const Vec3 across = cylinder_across(c, w);
    const real distance = length3(across);
    const Vec3 radial = distance > (real)0 ? scale3((real)1 / distance, across) : c->axes.x;
    const real along = -dot3(c->axes.z, w);
    const bool beside = along < (real)1.001 * c->half_length && -along < (real)1.001 * c->half_length;
    for (u32 side = 0; side < 2 && beside; ++side) {
      const real sign = side == 0 ? (real)1 : (real)-1;
      if (!(sign * distance - c->radius > meeting_least(&best, tolerance))) continue;
      const Vec3 normal = scale3(sign, radial);
      const Vec3 on_axis = add3(c->center, scale3(clamp_to(along, c->half_length), c->axes.z));
      best = cylinder_try(c, p, best, normal, sub3(on_axis, scale3(c->radius, normal)), vertex, tolerance);
    }
    for (u32 end = 0; end < 2; ++end) {
      const real over = end == 0 ? -along - c->half_length : along - c->half_length;
      if (!(over > (real)0) || !(distance > c->radius))
        continue;  // the closest point of the cylinder is not on the rim
      const Vec3 on_rim = rim_towards(c, end, vertex);
      const Vec3 d = sub3(on_rim, vertex);
      const real length = length3(d);
      if (length > meeting_least(&best, tolerance))
        best = cylinder_try(c, p, best, scale3((real)1 / length, d), on_rim, vertex, tolerance);
    }
  }
  return best;
}

// A rim against an edge, where they are nearest.
static inline Meeting cylinder_try_rim(const Cylinder* c, const Polytope* p, Meeting best, Vec3 normal, Vec3 on_rim,
                                       Vec3 on_other, real tolerance) {
  const real gap = dot3(normal, sub3(on_rim, on_other));
  for (u32 side = 0; side < 2; ++side) {
    const real sign = side == 0 ? (real)1 : (real)-1;
    if (sign * gap > meeting_least(&best, tolerance))
      best = cylinder_try(c, p, best, scale3(sign, normal), on_rim, on_other, tolerance);
  }
  return best;
}

// The rims against edges.
CALLED Meeting cylinder_try_rims(const Cylinder* c, const Polytope* p, Meeting best, real tolerance) {
#if LANES > 1
  RimEdges edges;
  RimLanes rims;
#endif
  for (u32 e = 0; e < p->edges; ++e) {
    const HullEdge edge = poly_edge(p, e);
    const Vec3 start = poly_vertex(p, edge.vertex_a);
    const Vec3 along = sub3(poly_vertex(p, edge.vertex_b), start);
    const real length = length3(along);
    const Vec3 unit = scale3((real)1 / length, along);
#if LANES > 1
    const u32 last = e % RIM_EDGES;
    rim_edges_put(&edges, last, start, unit, length);
    if (last != RIM_EDGES - 1u && e != p->edges - 1u) continue;
    for (u32 k = last + 1u; k < RIM_EDGES; ++k) rim_edges_put(&edges, k, start, unit, length);
    rim_lanes(c, &edges, &rims);
    for (u32 k = 0u; k < RIM_CANDIDATES * (last + 1u); ++k) {
      if ((rims.found >> k & 1u) == 0u) continue;
      best = cylinder_try_rim(c, p, best, rim_component(rims.normal, k), rim_component(rims.on_rim, k),
                              rim_component(rims.on_other, k), tolerance);
    }
#else
    for (u32 k = 0; k < 4; ++k) {
      const RimNearest rim = rim_line(c, k >> 1, start, unit, length, k & 1);
      if (rim.found) best = cylinder_try_rim(c, p, best, rim.normal, rim.on_rim, rim.on_other, tolerance);
    }
#endif
  }
  return best;
}

// The best normal, from p to c; c is called a here. Gaps above the limit are not looked into any further.
CALLED Meeting cylinder_meets(const Cylinder* c, const Polytope* p, real limit, real tolerance) {
  Meeting best = cylinder_try_flats(c, p, limit, tolerance);
  if (best.gap > limit) return best;
  best = cylinder_try_edges(c, p, best, tolerance);
  if (best.gap > limit) return best;
  best = cylinder_try_vertices(c, p, best, tolerance);
  if (best.gap > limit) return best;
  return cylinder_try_rims(c, p, best, tolerance);
}

#endif
