// Sphere against a facet of a surface. cpu_reference/shapes/sphere_facet.hpp is the twin.
#ifndef LOCKSTEP_SPHERE_FACET_H
#define LOCKSTEP_SPHERE_FACET_H

#include "shapes/polytopes.h"

#if FEATURE_FACETS
// The closest point of a facet: over its inside, or on an edge or a corner that yields.
static inline Manifold sphere_facet(const WorldShape* a, const WorldShape* b, const Polytope* facet, real limit) {
  const Vec3 center = into_frame(facet->axes, sub3(a->center, b->center)), out = poly_own_normal(facet, 0u);
  const real height = dot3(out, sub3(center, poly_own_vertex(facet, 0u)));
  bool over_face = height >= (real)0;
  Vec3 nearest = center;
  real least = (real)1e30;
  bool at_corner = false;
  for (u32 e = 0u; e < 3u; ++e) {
    const EdgeSpan edge = poly_own_edge(facet, e);
    const Vec3 from = sub3(center, edge.start);
    const real square = dot3(edge.along, edge.along);
    // points over an edge are over both of its facets, whatever rounding says
    if (dot3(cross3(out, edge.along), from) < (real)-1e-5 * square) over_face = false;
    const real t = dot3(edge.along, from) / square, share = clamp_share(t);
    const Vec3 point = add3(edge.start, scale3(share, edge.along)), d = sub3(center, point);
    const real distance = dot3(d, d);
    if (!(distance < least)) continue;
    least = distance;
    nearest = point;
    at_corner = share != t;
  }
  if (over_face) {
    if (height > limit + a->size.x) return no_manifold();
    const Vec3 normal = out_of_frame(facet->axes, out);
    return manifold_at(normal, NORMAL_OF_B, a->center, a->size.x, sub3(a->center, scale3(height, normal)), (real)0, 0);
  }
  const real gap = sqrt(least);
  if (gap > limit + a->size.x || !(gap > (real)0)) return no_manifold();
  const Vec3 own = scale3((real)1 / gap, sub3(center, nearest));
  if (!facet_admits(facet, own) || !facet_tells(facet, own)) return no_manifold();
  return manifold_at(out_of_frame(facet->axes, own), at_corner ? NORMAL_BETWEEN : NORMAL_FIXED, a->center, a->size.x,
                     add3(b->center, out_of_frame(facet->axes, nearest)), (real)0, 0);
}
#endif

#endif
