// Sphere against convex hull. cpu_reference/shapes/sphere_hull.hpp is the twin.
#ifndef LOCKSTEP_SPHERE_HULL_H
#define LOCKSTEP_SPHERE_HULL_H

#include "shapes/sphere_facet.h"

// The closest point of the hull; from inside, through the nearest face.
static inline Manifold sphere_hull(const WorldShape* a, const WorldShape* b, const HullTables* tables, real limit) {
  const Polytope hull = polytope_of(SHAPE_HULL, b, tables);
#if FEATURE_FACETS
  if (hull.facet) return sphere_facet(a, b, &hull, limit);
#endif
  const Vec3 center = into_frame(hull.axes, sub3(a->center, b->center));
  real gap = (real)-1e30;
  u32 face = 0;
  for (u32 f = 0; f < hull.faces; ++f) {
    const Vec4 plane = poly_own_plane(&hull, f);
    const real height = dot3(make3(plane.x, plane.y, plane.z), center) - plane.w;
    if (height > gap) {
      gap = height;
      face = f;
    }
  }
  if (gap > limit + a->size.x) return no_manifold();
  const Vec3 out = poly_own_normal(&hull, face);
  // a point in front of the face that it is farthest from is nearest to that face, or to an edge
  bool over_face = true;
  if (gap > (real)0) {
    Vec3 from = poly_own_vertex(&hull, poly_corner(&hull, face, poly_corner_count(&hull, face) - 1));
    for (u32 i = 0; i < poly_corner_count(&hull, face); ++i) {
      const Vec3 to = poly_own_vertex(&hull, poly_corner(&hull, face, i));
      if (dot3(cross3(out, sub3(to, from)), sub3(center, from)) < (real)0) over_face = false;
      from = to;
    }
  }
  if (over_face) {
    const Vec3 normal = out_of_frame(hull.axes, out);
    return manifold_at(normal, NORMAL_OF_B, a->center, a->size.x, sub3(a->center, scale3(gap, normal)), (real)0, 0);
  }
  const real face_gap = gap;
  // Of edges that are as near but for rounding, as those of a vertex are, the one whose way separates best; of faces in
  // nearly one plane, and on an edge itself, rounding may have missed the face that is nearest.
  real least = (real)1e30;
  Vec3 nearest = center, own = out;
  bool at_vertex = false, found = false;
  for (u32 e = 0; e < hull.edges; ++e) {
    const EdgeSpan edge = poly_own_edge(&hull, e);
    const real t = dot3(edge.along, sub3(center, edge.start)) / dot3(edge.along, edge.along);
    const real share = clamp_share(t);
    const Vec3 point = add3(edge.start, scale3(share, edge.along));
    const Vec3 d = sub3(center, point);
    const real square = dot3(d, d);
    if (!(square <= (real)1.00001 * least)) continue;
    const Vec3 direction = square > (real)0 ? scale3((real)1 / sqrt(square), d) : out;
    const real bound = dot3(direction, sub3(center, poly_own_vertex(&hull, poly_support(&hull, direction))));
    if (!(bound > gap) && !(square < (real)0.99999 * least)) continue;
    found = bound > face_gap;
    least = square;
    gap = bound;
    nearest = point;
    own = direction;
    at_vertex = share != t;
  }
  // along an edge the sphere rolls: only a vertex is a point that the normal turns about
  const u32 frame = !found ? NORMAL_OF_B : at_vertex ? NORMAL_BETWEEN : NORMAL_FIXED;
  return manifold_at(out_of_frame(hull.axes, found ? own : out), frame, a->center, a->size.x,
                     add3(b->center, out_of_frame(hull.axes, nearest)), (real)0, 0);
}

#endif
