// The pairs of a cylinder or a convex hull that can touch at several points: first which direction separates the shapes
// best, then what the parts of their surfaces share that face each other along it. One way for all of them, so that the
// kernel holds it once. kernels/shapes/patch_pairs.h is the twin.
#pragma once

#include "cpu_reference/shapes/cylinder_polytope.hpp"
#include "cpu_reference/shapes/cylinders.hpp"
#include "cpu_reference/shapes/polytopes.hpp"
#include "cpu_reference/shapes/share.hpp"
#include "cpu_reference/shapes/sphere_plane.hpp"

namespace lockstep::reference {

/// Of a capsule only the core segment meets: its surface is a radius away.
template <class real>
real patch_core_radius(u32 kind, const WorldShape<real>& shape) {
  return kind == SHAPE_CAPSULE ? shape.size.x : real(0);
}

template <class real>
Meeting<real> meet_plane(u32 kind_a, const WorldShape<real>& a, const WorldShape<real>& plane,
                         const HullTables<real>& tables) {
  Meeting<real> meeting = no_meeting<real>();
  meeting.normal = plane_normal(plane.rotation);
  meeting.frame = NORMAL_OF_B;
  const Vec3<real> down = scale3(real(-1), meeting.normal);
  if (kind_a == SHAPE_CYLINDER) {
    const Cylinder<real> cylinder = cylinder_of(a);
    meeting.at_a = cylinder_support(cylinder, down);
  } else {
    const Polytope<real> polytope = polytope_of(kind_a, a, tables);
    meeting.at_a = poly_vertex(polytope, poly_support(polytope, into_frame(polytope.axes, down)));
  }
  meeting.gap = dot3(meeting.normal, sub3(meeting.at_a, plane.center));
  meeting.at_b = sub3(meeting.at_a, scale3(meeting.gap, meeting.normal));
  return meeting;
}

/// How the cores of two shapes meet.
template <class real>
Meeting<real> meet_cores(u32 kind_a, const WorldShape<real>& a, u32 kind_b, const WorldShape<real>& b,
                         const HullTables<real>& tables, real limit, real tolerance) {
  if (kind_b == SHAPE_PLANE) return meet_plane(kind_a, a, b, tables);
  const bool cylinder_a = kind_a == SHAPE_CYLINDER, cylinder_b = kind_b == SHAPE_CYLINDER;
  if (cylinder_a && cylinder_b) {
    const Cylinder<real> one = cylinder_of(a), other = cylinder_of(b);
    return cylinders_meet(one, other, limit, tolerance);
  }
  if (cylinder_a || cylinder_b) {
    const Cylinder<real> cylinder = cylinder_of(cylinder_a ? a : b);
    const Polytope<real> polytope = polytope_of(cylinder_a ? kind_b : kind_a, cylinder_a ? b : a, tables);
    const Meeting<real> meeting = cylinder_meets(cylinder, polytope, limit, tolerance);
    return cylinder_a ? meeting : meeting_swapped(meeting);
  }
  const Polytope<real> one = polytope_of(kind_a, a, tables), other = polytope_of(kind_b, b, tables);
  return polytopes_meet(one, other, limit, tolerance);
}

/// The part of a surface that faces the other shape: along the normal (sense 1, shape b) or against it (-1, shape a).
template <class real>
Patch<real> facing_patch(u32 kind, const WorldShape<real>& shape, const HullTables<real>& tables, real sense,
                         Vec3<real> normal, real slack) {
  if (kind == SHAPE_PLANE) return plane_patch(shape.center, normal);
  if (kind == SHAPE_CYLINDER) return cylinder_patch(shape, axes_of(shape.rotation), sense, normal, slack);
  const Polytope<real> polytope = polytope_of(kind, shape, tables);
  if (kind != SHAPE_CAPSULE) return polygon_patch(polytope, sense, normal, real(2e-5) * length3(shape.size));
  const Vec3<real> surface = scale3(sense * shape.size.x, normal);
  return segment_patch(sense, add3(poly_vertex(polytope, 0), surface), add3(poly_vertex(polytope, 1), surface), normal);
}

/// The radius that contacts keep from their anchors.
template <class real>
real rolling_radius(u32 kind, const WorldShape<real>& shape, Vec3<real> normal) {
  if (kind != SHAPE_CYLINDER) return patch_core_radius(kind, shape);
  const Cylinder<real> cylinder = cylinder_of(shape);
  return cylinder_rolls(cylinder, normal);
}

/// What the parts of both surfaces share that face each other along the normal of this meeting.
template <class real>
Manifold<real> touch_along(u32 kind_a, const WorldShape<real>& a, u32 kind_b, const WorldShape<real>& b,
                           const HullTables<real>& tables, Meeting<real> meeting, real limit, real tolerance) {
  const real core_a = patch_core_radius(kind_a, a);
  meeting.gap = meeting.gap - core_a;
  meeting.at_a = sub3(meeting.at_a, scale3(core_a, meeting.normal));
  const real scale = smaller_size(a, b);
  const real slack = depth_slack(meeting.gap, tolerance, scale);
  Patch<real> patch_a = facing_patch(kind_a, a, tables, real(-1), meeting.normal, slack);
  Patch<real> patch_b = facing_patch(kind_b, b, tables, real(1), meeting.normal, slack);
  if (patch_a.kind == PATCH_SEGMENT && patch_b.kind == PATCH_POLYGON)
    patch_b = edge_of_patch(patch_b, meeting.normal, sub3(patch_a.end, patch_a.center));
  else if (patch_b.kind == PATCH_SEGMENT && patch_a.kind == PATCH_POLYGON)
    patch_a = edge_of_patch(patch_a, meeting.normal, sub3(patch_b.end, patch_b.center));
  const real radius_a = rolling_radius(kind_a, a, meeting.normal), radius_b = rolling_radius(kind_b, b, meeting.normal);
  const Vec3<real> at_a = add3(meeting.at_a, scale3(radius_a, meeting.normal));
  const Vec3<real> at_b = sub3(meeting.at_b, scale3(radius_b, meeting.normal));
  const Vec3<real> displacement = lagging_displacement(a, at_a, b, at_b);
  return share_patches(patch_a, patch_b, radius_a, radius_b, meeting, displacement, limit, tolerance, slack, scale);
}

/// The best face of the other one of two shapes with faces.
template <class real>
Meeting<real> meet_other_face(u32 kind_a, const WorldShape<real>& a, u32 kind_b, const WorldShape<real>& b,
                              const HullTables<real>& tables, u32 frame, real limit, real tolerance) {
  const Meeting<real> none = no_meeting<real>();
  const bool faces_a = kind_a == SHAPE_BOX || kind_a == SHAPE_HULL,
             faces_b = kind_b == SHAPE_BOX || kind_b == SHAPE_HULL;
  if (!faces_a || !faces_b) return none;
  const Polytope<real> one = polytope_of(kind_a, a, tables), other = polytope_of(kind_b, b, tables);
  return frame == NORMAL_OF_A ? poly_meet_face_of_b(one, other, none, limit, tolerance)
                              : poly_meet_face_of_a(one, other, none, limit, tolerance);
}

/// How far the core of a shape reaches from its centre along a direction, times the direction's length.
template <class real>
real core_extent(u32 kind, const WorldShape<real>& shape, const HullTables<real>& tables, Vec3<real> direction) {
  if (kind == SHAPE_CYLINDER) return cylinder_extent(cylinder_of(shape), direction);
  return poly_extent(polytope_of(kind, shape, tables), direction);
}

/// Whether the core of a shape is farther than the limit from a facet, as the facet's normal, from either side, or a
/// direction across one of its edges tells: most of those whose boxes meet are.
template <class real>
bool facet_is_far(u32 kind, const WorldShape<real>& shape, const WorldShape<real>& facet,
                  const HullTables<real>& tables, real limit) {
  const Polytope<real> triangle = polytope_of(SHAPE_HULL, facet, tables);
  const Vec3<real> normal = poly_own_normal(triangle, 0);
  for (u32 k = 0; k < 5; ++k) {
    const EdgeSpan<real> edge = poly_own_edge(triangle, k < 3 ? k : 0);
    const Vec3<real> own = k < 3 ? cross3(edge.along, normal) : scale3(k == 3 ? real(1) : real(-1), normal);
    const Vec3<real> out = out_of_frame(triangle.axes, own);
    const Vec3<real> from = add3(triangle.center, out_of_frame(triangle.axes, edge.start));
    const real gap = dot3(out, sub3(shape.center, from)) - core_extent(kind, shape, tables, scale3(real(-1), out));
    if (gap > limit * length3(out)) return true;
  }
  return false;
}

/// Whether a shape tells of a contact along a normal that points out of it.
template <class real>
bool shape_tells(u32 kind, const WorldShape<real>& shape, const HullTables<real>& tables, Vec3<real> normal) {
  if (!is_facet(kind, shape)) return true;
  const Polytope<real> facet = polytope_of(kind, shape, tables);
  return facet_tells(facet, into_frame(facet.axes, normal));
}

/// Along the normal of a facet.
template <class real>
Meeting<real> meet_inside(const WorldShape<real>& facet, const HullTables<real>& tables, bool is_a) {
  const Polytope<real> triangle = polytope_of(SHAPE_HULL, facet, tables);
  Meeting<real> meeting = no_meeting<real>();
  meeting.normal = out_of_frame(triangle.axes, scale3(is_a ? real(-1) : real(1), poly_own_normal(triangle, 0)));
  meeting.frame = is_a ? NORMAL_OF_A : NORMAL_OF_B;
  return meeting;
}

/// Of what a shape and a facet share along the facet's normal the points that it holds. Points that are behind the
/// facet count where the centre of the shape is not.
template <class real>
Manifold<real> keep_points_inside(const WorldShape<real>& a, const WorldShape<real>& b, const HullTables<real>& tables,
                                  bool is_a, const Manifold<real>& shared, real limit) {
  const Polytope<real> facet = polytope_of(SHAPE_HULL, is_a ? a : b, tables);
  const Vec3<real> other = into_frame(facet.axes, sub3(is_a ? b.center : a.center, facet.center));
  const bool in_front = facet_looks_at(facet, dot3(poly_own_normal(facet, 0), other) - poly_own_plane(facet, 0).w);
  Manifold<real> m = manifold_along(shared.normal, shared.frame, shared.radius_a, shared.radius_b);
  for (u32 k = 0; k < shared.count; ++k) {
    const ManifoldPoint<real>& point = shared.points[k];
    const real gap = gap_at(shared, k);
    if (point.feature == 0 || gap > limit || (gap < 0 && !in_front)) continue;
    const Vec3<real> at_a = sub3(point.anchor_a, scale3(shared.radius_a, shared.normal));
    const Vec3<real> at_b = add3(point.anchor_b, scale3(shared.radius_b, shared.normal));
    const Vec3<real> displacement =  // of a past b
        sub3(add3(a.displacement, cross3(a.angular_displacement, sub3(at_a, a.center))),
             add3(b.displacement, cross3(b.angular_displacement, sub3(at_b, b.center))));
    const Vec3<real> at = into_frame(facet.axes, sub3(is_a ? at_a : at_b, facet.center));
    if (facet_contains(facet, at, into_frame(facet.axes, scale3(is_a ? real(-1) : real(1), displacement)), a.margin))
      m = with_point(m, point.anchor_a, point.anchor_b, point.feature);
  }
  return m;
}

/// Where the surfaces face each other along the best normal that there is. A facet whose best normal is not its own to
/// tell, or that has none, still tells what comes down on its inside.
template <class real>
Manifold<real> patches_touch(u32 kind_a, const WorldShape<real>& a, u32 kind_b, const WorldShape<real>& b,
                             const HullTables<real>& tables, real limit) {
  const real tolerance = shape_tolerance(a, b);
  const real core_a = patch_core_radius(kind_a, a);
  const bool facet_a = is_facet(kind_a, a), facet_b = is_facet(kind_b, b), facet = facet_a || facet_b;
  if (facet_a && facet_is_far(kind_b, b, a, tables, limit)) return no_manifold<real>();
  if (facet_b && facet_is_far(kind_a, a, b, tables, limit + core_a)) return no_manifold<real>();
  Meeting<real> meeting = meet_cores(kind_a, a, kind_b, b, tables, limit + core_a, tolerance);
  if (meeting.gap > limit + core_a) return no_manifold<real>();
  bool inside = facet && !(meeting.gap > real(-1e29));  // no direction counts
  if (inside) meeting = meet_inside(facet_a ? a : b, tables, facet_a);
  for (u32 attempt = 0;; ++attempt) {
    Manifold<real> m = touch_along(kind_a, a, kind_b, b, tables, meeting, limit, tolerance);
    if (inside) return keep_points_inside(a, b, tables, facet_a, m, limit);
    const bool alone = m.count == 1 && m.points[0].feature == 0;
    bool found = !(facet && alone) || is_in_line(meeting, smaller_size(a, b));
    if (found && alone && meeting.frame != NORMAL_FIXED) {
      if (attempt == 1) {
        found = !facet;  // what is beside a facet its neighbours meet
      } else if (meeting.crossing_gap > meeting.gap - tolerance) {
        // nothing is over the face: along its normal the points of the crossing are less deep than along their own
        const Vec3<real> n = meeting.crossing_normal;
        const real radius_a = rolling_radius(kind_a, a, meeting.normal);
        const real radius_b = rolling_radius(kind_b, b, meeting.normal);
        m = with_point(manifold_along(n, frame_on_round(NORMAL_FIXED, radius_a, radius_b), radius_a, radius_b),
                       add3(meeting.at_a, scale3(radius_a - core_a, n)), sub3(meeting.at_b, scale3(radius_b, n)), 0);
      } else {
        // a face of the other shape may be as good a normal but for rounding, and have something over it
        const Meeting<real> other = meet_other_face(kind_a, a, kind_b, b, tables, meeting.frame, limit, tolerance);
        if (other.gap > meeting.gap - real(4) * tolerance) {
          meeting = other;
          continue;
        }
        found = !facet;
      }
    }
    if (found && shape_tells(kind_a, a, tables, scale3(real(-1), m.normal)) && shape_tells(kind_b, b, tables, m.normal))
      return m;
    inside = true;
    meeting = meet_inside(facet_a ? a : b, tables, facet_a);
  }
}

}  // namespace lockstep::reference
