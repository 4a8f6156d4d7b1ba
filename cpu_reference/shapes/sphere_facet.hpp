// Sphere against a facet of a surface. kernels/shapes/sphere_facet.h is the twin.
#pragma once

#include "cpu_reference/shapes/polytopes.hpp"

namespace lockstep::reference {

/// The closest point of a facet: over its inside, or on an edge or a corner that yields.
template <class real>
Manifold<real> sphere_facet(const WorldShape<real>& a, const WorldShape<real>& b, const Polytope<real>& facet,
                            real limit) {
  const Vec3<real> center = into_frame(facet.axes, sub3(a.center, b.center)), out = poly_own_normal(facet, 0);
  const real height = dot3(out, sub3(center, poly_own_vertex(facet, 0)));
  bool over_face = height >= 0;
  Vec3<real> nearest = center;
  real least = real(1e30);
  bool at_corner = false;
  for (u32 e = 0; e < 3; ++e) {
    const EdgeSpan<real> edge = poly_own_edge(facet, e);
    const Vec3<real> from = sub3(center, edge.start);
    const real square = dot3(edge.along, edge.along);
    // points over an edge are over both of its facets, whatever rounding says
    if (dot3(cross3(out, edge.along), from) < real(-1e-5) * square) over_face = false;
    const real t = dot3(edge.along, from) / square, share = clamp_share(t);
    const Vec3<real> point = add3(edge.start, scale3(share, edge.along)), d = sub3(center, point);
    const real distance = dot3(d, d);
    if (!(distance < least)) continue;
    least = distance;
    nearest = point;
    at_corner = share != t;
  }
  if (over_face) {
    if (height > limit + a.size.x) return no_manifold<real>();
    const Vec3<real> normal = out_of_frame(facet.axes, out);
    return manifold_at(normal, NORMAL_OF_B, a.center, a.size.x, sub3(a.center, scale3(height, normal)), real(0), 0);
  }
  const real gap = std::sqrt(least);
  if (gap > limit + a.size.x || !(gap > 0)) return no_manifold<real>();
  const Vec3<real> own = scale3(real(1) / gap, sub3(center, nearest));
  if (!facet_admits(facet, own) || !facet_tells(facet, own)) return no_manifold<real>();
  return manifold_at(out_of_frame(facet.axes, own), at_corner ? NORMAL_BETWEEN : NORMAL_FIXED, a.center, a.size.x,
                     add3(b.center, out_of_frame(facet.axes, nearest)), real(0), 0);
}

}  // namespace lockstep::reference
