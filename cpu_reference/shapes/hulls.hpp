// Convex hulls against planes, spheres, capsules, boxes and each other. kernels/shapes/hulls.h is the twin.
#pragma once

#include "cpu_reference/shapes/polytopes.hpp"
#include "cpu_reference/shapes/share.hpp"
#include "cpu_reference/shapes/sphere_plane.hpp"

namespace lockstep::reference {

/// What is left to rounding, and to the wish that contacts keep their features, relative to the size of both shapes.
template <class real>
real shape_tolerance(const Placed<real>& a, const Placed<real>& b) {
  return real(1e-6) * (length3(a.size) + length3(b.size));
}

template <class real>
real smaller_size(const Placed<real>& a, const Placed<real>& b) {
  const real size_a = length3(a.size), size_b = length3(b.size);
  return size_a < size_b ? size_a : size_b;
}

/// The face that lies on the plane.
template <class real>
Manifold<real> hull_plane(const Placed<real>& a, const Placed<real>& b, const HullTables<real>& tables, real limit) {
  const Polytope<real> hull = polytope_of(SHAPE_HULL, a, tables);
  Meeting<real> meeting = no_meeting<real>();
  meeting.normal = plane_normal(b.rotation);
  meeting.frame = NORMAL_OF_B;
  const Vec3<real> down = into_frame(hull.axes, scale3(real(-1), meeting.normal));
  meeting.at_a = poly_vertex(hull, poly_support(hull, down));
  meeting.gap = dot3(meeting.normal, sub3(meeting.at_a, b.center));
  meeting.at_b = sub3(meeting.at_a, scale3(meeting.gap, meeting.normal));
  if (meeting.gap > limit) return no_manifold<real>();
  const real tolerance = shape_tolerance(a, b);
  const Patch<real> patch_a = polygon_patch(hull, real(-1), meeting.normal, real(10) * tolerance);
  const Patch<real> patch_b = plane_patch(b.center, meeting.normal);
  return share_patches(patch_a, patch_b, real(0), real(0), meeting, limit, tolerance, length3(a.size));
}

/// The closest point of the hull; from inside, through the nearest face.
template <class real>
Manifold<real> sphere_hull(const Placed<real>& a, const Placed<real>& b, const HullTables<real>& tables, real limit) {
  const Polytope<real> hull = polytope_of(SHAPE_HULL, b, tables);
  const Vec3<real> center = into_frame(hull.axes, sub3(a.center, b.center));
  real gap = real(-1e30);
  u32 face = 0;
  for (u32 f = 0; f < hull.faces; ++f) {
    const Vec4<real> plane = poly_own_plane(hull, f);
    const real height = dot3(Vec3<real>{plane.x, plane.y, plane.z}, center) - plane.w;
    if (height > gap) {
      gap = height;
      face = f;
    }
  }
  if (gap > limit + a.size.x) return no_manifold<real>();
  const Vec3<real> out = poly_own_normal(hull, face);
  // a point in front of the face that it is farthest from is nearest to that face, or to an edge
  bool over_face = true;
  if (gap > 0) {
    Vec3<real> from = poly_own_vertex(hull, poly_corner(hull, face, poly_corner_count(hull, face) - 1));
    for (u32 i = 0; i < poly_corner_count(hull, face); ++i) {
      const Vec3<real> to = poly_own_vertex(hull, poly_corner(hull, face, i));
      if (dot3(cross3(out, sub3(to, from)), sub3(center, from)) < 0) over_face = false;
      from = to;
    }
  }
  if (over_face) {
    const Vec3<real> normal = out_of_frame(hull.axes, out);
    return manifold_at(normal, NORMAL_OF_B, a.center, a.size.x, sub3(a.center, scale3(gap, normal)), real(0), 0);
  }
  real least = real(1e30);
  Vec3<real> nearest = center;
  bool at_vertex = false;
  for (u32 e = 0; e < hull.edges; ++e) {
    const EdgeSpan<real> edge = poly_own_edge(hull, e);
    const real t = dot3(edge.along, sub3(center, edge.start)) / dot3(edge.along, edge.along);
    const real share = clamp_share(t);
    const Vec3<real> point = add3(edge.start, scale3(share, edge.along));
    const Vec3<real> d = sub3(center, point);
    const real square = dot3(d, d);
    if (square < least) {
      least = square;
      nearest = point;
      at_vertex = share != t;
    }
  }
  const real distance = std::sqrt(least);
  // a centre on the surface itself has no direction of its own
  const bool apart = distance > shape_tolerance(a, b);
  const Vec3<real> own = apart ? scale3(real(1) / distance, sub3(center, nearest)) : out;
  // along an edge the sphere rolls: only a vertex is a point that the normal turns about
  return manifold_at(out_of_frame(hull.axes, own), at_vertex && apart ? NORMAL_BETWEEN : NORMAL_FIXED, a.center,
                     a.size.x, add3(b.center, out_of_frame(hull.axes, nearest)), real(0), 0);
}

/// The core segment against the hull, a radius away.
template <class real>
Manifold<real> capsule_hull(const Placed<real>& a, const Placed<real>& b, const HullTables<real>& tables, real limit) {
  const Polytope<real> core = polytope_of(SHAPE_CAPSULE, a, tables), hull = polytope_of(SHAPE_HULL, b, tables);
  const real radius = a.size.x, tolerance = shape_tolerance(a, b);
  Meeting<real> meeting = polytopes_meet(core, hull, limit + radius, tolerance);
  if (meeting.gap > limit + radius) return no_manifold<real>();
  const Vec3<real> surface = scale3(-radius, meeting.normal);
  meeting.gap = meeting.gap - radius;
  meeting.at_a = add3(meeting.at_a, surface);
  const Patch<real> line =
      segment_patch(real(-1), add3(poly_vertex(core, 0), surface), add3(poly_vertex(core, 1), surface), meeting.normal);
  const Patch<real> patch_b = polygon_patch(hull, real(1), meeting.normal, real(10) * tolerance);
  return share_patches(line, patch_b, radius, real(0), meeting, limit, tolerance, smaller_size(a, b));
}

template <class real>
Manifold<real> polytopes_touch(u32 kind_a, const Placed<real>& a, const Placed<real>& b, const HullTables<real>& tables,
                               real limit) {
  const Polytope<real> one = polytope_of(kind_a, a, tables), other = polytope_of(SHAPE_HULL, b, tables);
  const real tolerance = shape_tolerance(a, b);
  const Meeting<real> meeting = polytopes_meet(one, other, limit, tolerance);
  if (meeting.gap > limit) return no_manifold<real>();
  const Patch<real> patch_a = polygon_patch(one, real(-1), meeting.normal, real(10) * tolerance);
  const Patch<real> patch_b = polygon_patch(other, real(1), meeting.normal, real(10) * tolerance);
  return share_patches(patch_a, patch_b, real(0), real(0), meeting, limit, tolerance, smaller_size(a, b));
}

template <class real>
Manifold<real> box_hull(const Placed<real>& a, const Placed<real>& b, const HullTables<real>& tables, real limit) {
  return polytopes_touch(SHAPE_BOX, a, b, tables, limit);
}

template <class real>
Manifold<real> hull_hull(const Placed<real>& a, const Placed<real>& b, const HullTables<real>& tables, real limit) {
  return polytopes_touch(SHAPE_HULL, a, b, tables, limit);
}

}  // namespace lockstep::reference
