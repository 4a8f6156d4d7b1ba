// The pairs of a cylinder or a convex hull that can touch at several points: first which direction separates the shapes
// best, then what the parts of their surfaces share that face each other along it. One way for all of them, so that the
// kernel holds it once. cpu_reference/shapes/patch_pairs.hpp is the twin.
#ifndef LOCKSTEP_PATCH_PAIRS_H
#define LOCKSTEP_PATCH_PAIRS_H

#include "shapes/cylinder_polytope.h"
#include "shapes/cylinders.h"
#include "shapes/polytopes.h"
#include "shapes/share.h"
#include "shapes/sphere_plane.h"

// Kinds that a scene lacks are not compiled.
#define FEATURE_POLYTOPES (FEATURE_CAPSULES || FEATURE_BOXES || FEATURE_HULLS)

// Of a capsule only the core segment meets: its surface is a radius away.
static inline real patch_core_radius(u32 kind, const WorldShape* shape) {
  return kind == SHAPE_CAPSULE ? shape->size.x : (real)0;
}

static inline Meeting meet_plane(u32 kind_a, const WorldShape* a, const WorldShape* plane, const HullTables* tables) {
  Meeting meeting = no_meeting();
  meeting.normal = plane_normal(plane->rotation);
  meeting.frame = NORMAL_OF_B;
  const Vec3 down = scale3((real)-1, meeting.normal);
  if (FEATURE_CYLINDERS && kind_a == SHAPE_CYLINDER) {
    const Cylinder cylinder = cylinder_of(a);
    meeting.at_a = cylinder_support(&cylinder, down);
  } else {
    const Polytope polytope = polytope_of(kind_a, a, tables);
    meeting.at_a = poly_vertex(&polytope, poly_support(&polytope, into_frame(polytope.axes, down)));
  }
  meeting.gap = dot3(meeting.normal, sub3(meeting.at_a, plane->center));
  meeting.at_b = sub3(meeting.at_a, scale3(meeting.gap, meeting.normal));
  return meeting;
}

// How the cores of two shapes meet.
static inline Meeting meet_cores(u32 kind_a, const WorldShape* a, u32 kind_b, const WorldShape* b,
                                 const HullTables* tables, real limit, real tolerance) {
  if (kind_b == SHAPE_PLANE) return meet_plane(kind_a, a, b, tables);
  const bool cylinder_a = FEATURE_CYLINDERS && kind_a == SHAPE_CYLINDER,
             cylinder_b = FEATURE_CYLINDERS && kind_b == SHAPE_CYLINDER;
  if (cylinder_a && cylinder_b) {
    const Cylinder one = cylinder_of(a), other = cylinder_of(b);
    return cylinders_meet(&one, &other, limit, tolerance);
  }
#if FEATURE_CYLINDERS && FEATURE_POLYTOPES
  if (cylinder_a || cylinder_b) {
    const Cylinder cylinder = cylinder_of(cylinder_a ? a : b);
    const Polytope polytope = polytope_of(cylinder_a ? kind_b : kind_a, cylinder_a ? b : a, tables);
    const Meeting meeting = cylinder_meets(&cylinder, &polytope, limit, tolerance);
    return cylinder_a ? meeting : meeting_swapped(meeting);
  }
#endif
  if (!FEATURE_HULLS) return no_meeting();
  const Polytope one = polytope_of(kind_a, a, tables), other = polytope_of(kind_b, b, tables);
  return polytopes_meet(&one, &other, limit, tolerance);
}

// The part of a surface that faces the other shape: along the normal (sense 1, shape b) or against it (-1, shape a).
CALLED Patch facing_patch(u32 kind, const WorldShape* shape, const HullTables* tables, real sense, Vec3 normal,
                          real slack) {
  if (kind == SHAPE_PLANE) return plane_patch(shape->center, normal);
  if (FEATURE_CYLINDERS && kind == SHAPE_CYLINDER)
    return cylinder_patch(shape, axes_of(shape->rotation), sense, normal, slack);
  const Polytope polytope = polytope_of(kind, shape, tables);
  if (!FEATURE_CAPSULES || kind != SHAPE_CAPSULE)
    return polygon_patch(&polytope, sense, normal, (real)2e-5 * length3(shape->size));
  const Vec3 surface = scale3(sense * shape->size.x, normal);
  return segment_patch(sense, add3(poly_vertex(&polytope, 0), surface), add3(poly_vertex(&polytope, 1), surface),
                       normal);
}

// The radius that contacts keep from their anchors.
static inline real rolling_radius(u32 kind, const WorldShape* shape, Vec3 normal) {
  if (kind != SHAPE_CYLINDER) return patch_core_radius(kind, shape);
  const Cylinder cylinder = cylinder_of(shape);
  return cylinder_rolls(&cylinder, normal);
}

// What the parts of both surfaces share that face each other along the normal of this meeting.
CALLED Manifold touch_along(u32 kind_a, const WorldShape* a, u32 kind_b, const WorldShape* b, const HullTables* tables,
                            Meeting meeting, real limit, real tolerance) {
  const real core_a = patch_core_radius(kind_a, a);
  meeting.gap = meeting.gap - core_a;
  meeting.at_a = sub3(meeting.at_a, scale3(core_a, meeting.normal));
  const real scale = smaller_size(a, b);
  const real slack = depth_slack(meeting.gap, tolerance, scale);
  Patch patch_a = facing_patch(kind_a, a, tables, (real)-1, meeting.normal, slack);
  Patch patch_b = facing_patch(kind_b, b, tables, (real)1, meeting.normal, slack);
  if (patch_a.kind == PATCH_SEGMENT && patch_b.kind == PATCH_POLYGON)
    patch_b = edge_of_patch(&patch_b, meeting.normal, sub3(patch_a.end, patch_a.center));
  else if (patch_b.kind == PATCH_SEGMENT && patch_a.kind == PATCH_POLYGON)
    patch_a = edge_of_patch(&patch_a, meeting.normal, sub3(patch_b.end, patch_b.center));
  const real radius_a = rolling_radius(kind_a, a, meeting.normal), radius_b = rolling_radius(kind_b, b, meeting.normal);
  const Vec3 at_a = add3(meeting.at_a, scale3(radius_a, meeting.normal));
  const Vec3 at_b = sub3(meeting.at_b, scale3(radius_b, meeting.normal));
  const Vec3 displacement = lagging_displacement(a, at_a, b, at_b);
  return share_patches(&patch_a, &patch_b, radius_a, radius_b, &meeting, displacement, limit, tolerance, slack, scale);
}

// The best face of the other one of two shapes with faces.
CALLED Meeting meet_other_face(u32 kind_a, const WorldShape* a, u32 kind_b, const WorldShape* b,
                               const HullTables* tables, u32 frame, real limit, real tolerance) {
  const Meeting none = no_meeting();
  const bool faces_a = kind_a == SHAPE_BOX || kind_a == SHAPE_HULL,
             faces_b = kind_b == SHAPE_BOX || kind_b == SHAPE_HULL;
  if (!FEATURE_HULLS || !faces_a || !faces_b) return none;
  const Polytope one = polytope_of(kind_a, a, tables), other = polytope_of(kind_b, b, tables);
  return frame == NORMAL_OF_A ? poly_meet_face_of_b(&one, &other, none, limit, tolerance)
                              : poly_meet_face_of_a(&one, &other, none, limit, tolerance);
}

#if FEATURE_FACETS || FEATURE_SEAMS
// How far the core of a shape reaches from its centre along a direction, times the direction's length.
CALLED real core_extent(u32 kind, const WorldShape* shape, const HullTables* tables, Vec3 direction) {
#if FEATURE_CYLINDERS
  if (kind == SHAPE_CYLINDER) {
    const Cylinder cylinder = cylinder_of(shape);
    return cylinder_extent(&cylinder, direction);
  }
#endif
  const Polytope polytope = polytope_of(kind, shape, tables);
  return poly_extent(&polytope, direction);
}
#endif

#if FEATURE_FACETS
// Whether the core of a shape is farther than the limit from a facet, as the facet's normal, from either side, or a
// direction across one of its edges tells: most of those whose boxes meet are.
CALLED bool facet_is_far(u32 kind, const WorldShape* shape, const WorldShape* facet, const HullTables* tables,
                         real limit) {
  const Polytope triangle = polytope_of(SHAPE_HULL, facet, tables);
  const Vec3 normal = poly_own_normal(&triangle, 0u);
  for (u32 k = 0u; k < 5u; ++k) {
    const EdgeSpan edge = poly_own_edge(&triangle, k < 3u ? k : 0u);
    const Vec3 own = k < 3u ? cross3(edge.along, normal) : scale3(k == 3u ? (real)1 : (real)-1, normal);
    const Vec3 out = out_of_frame(triangle.axes, own);
    const Vec3 from = add3(triangle.center, out_of_frame(triangle.axes, edge.start));
    const real gap = dot3(out, sub3(shape->center, from)) - core_extent(kind, shape, tables, scale3((real)-1, out));
    if (gap > limit * length3(out)) return true;
  }
  return false;
}
#endif

// Whether a shape tells of a contact along a normal that points out of it.
CALLED bool shape_tells(u32 kind, const WorldShape* shape, const HullTables* tables, Vec3 normal) {
#if FEATURE_FACETS
  if (is_facet(kind, shape)) {
    const Polytope facet = polytope_of(kind, shape, tables);
    return facet_tells(&facet, into_frame(facet.axes, normal));
  }
#endif
  return true;
}

#if FEATURE_FACETS
// Along the normal of a facet.
static inline Meeting meet_inside(const WorldShape* facet, const HullTables* tables, bool is_a) {
  const Polytope triangle = polytope_of(SHAPE_HULL, facet, tables);
  Meeting meeting = no_meeting();
  meeting.normal = out_of_frame(triangle.axes, scale3(is_a ? (real)-1 : (real)1, poly_own_normal(&triangle, 0u)));
  meeting.frame = is_a ? NORMAL_OF_A : NORMAL_OF_B;
  return meeting;
}

// Of what a shape and a facet share along the facet's normal the points that it holds. Points that are behind the facet
// count where the centre of the shape is not.
static inline Manifold keep_points_inside(const WorldShape* a, const WorldShape* b, const HullTables* tables, bool is_a,
                                          const Manifold* shared, real limit) {
  const Polytope facet = polytope_of(SHAPE_HULL, is_a ? a : b, tables);
  const Vec3 other = into_frame(facet.axes, sub3(is_a ? b->center : a->center, facet.center));
  const bool in_front = facet_looks_at(&facet, dot3(poly_own_normal(&facet, 0u), other) - poly_own_plane(&facet, 0u).w);
  Manifold m = manifold_along(shared->normal, shared->frame, shared->radius_a, shared->radius_b);
  for (u32 k = 0u; k < shared->count; ++k) {
    const ManifoldPoint point = shared->points[k];
    const real gap = gap_at(shared, k);
    if (point.feature == 0u || gap > limit || (gap < (real)0 && !in_front)) continue;
    const Vec3 at_a = sub3(point.anchor_a, scale3(shared->radius_a, shared->normal));
    const Vec3 at_b = add3(point.anchor_b, scale3(shared->radius_b, shared->normal));
    const Vec3 displacement =  // of a past b
        sub3(add3(a->displacement, cross3(a->angular_displacement, sub3(at_a, a->center))),
             add3(b->displacement, cross3(b->angular_displacement, sub3(at_b, b->center))));
    const Vec3 at = into_frame(facet.axes, sub3(is_a ? at_a : at_b, facet.center));
    if (facet_contains(&facet, at, into_frame(facet.axes, scale3(is_a ? (real)-1 : (real)1, displacement)), a->margin))
      m = with_point(m, point.anchor_a, point.anchor_b, point.feature);
  }
  return m;
}
#endif

// Where the surfaces face each other along the best normal that there is. A facet whose best normal is not its own to
// tell, or that has none, still tells what comes down on its inside.
CALLED Manifold patches_touch(u32 kind_a, const WorldShape* a, u32 kind_b, const WorldShape* b,
                              const HullTables* tables, real limit) {
  const real tolerance = shape_tolerance(a, b);
  const real core_a = patch_core_radius(kind_a, a);
  const bool facet_a = is_facet(kind_a, a), facet_b = is_facet(kind_b, b), facet = facet_a || facet_b;
#if FEATURE_FACETS
  if (facet_a && facet_is_far(kind_b, b, a, tables, limit)) return no_manifold();
  if (facet_b && facet_is_far(kind_a, a, b, tables, limit + core_a)) return no_manifold();
#endif
  Meeting meeting = meet_cores(kind_a, a, kind_b, b, tables, limit + core_a, tolerance);
  if (meeting.gap > limit + core_a) return no_manifold();
#if FEATURE_FACETS
  bool inside = facet && !(meeting.gap > (real)-1e29);  // no direction counts
  if (inside) meeting = meet_inside(facet_a ? a : b, tables, facet_a);
#endif
  for (u32 attempt = 0u;; ++attempt) {
    Manifold m = touch_along(kind_a, a, kind_b, b, tables, meeting, limit, tolerance);
#if FEATURE_FACETS
    if (inside) return keep_points_inside(a, b, tables, facet_a, &m, limit);
#endif
    const bool alone = m.count == 1u && m.points[0].feature == 0u;
    bool found = !(facet && alone) || is_in_line(&meeting, smaller_size(a, b));
    if (found && alone && meeting.frame != NORMAL_FIXED) {
      if (attempt == 1u) {
        found = !facet;  // what is beside a facet its neighbours meet
      } else if (meeting.crossing_gap > meeting.gap - tolerance) {
        // nothing is over the face: along its normal the points of the crossing are less deep than along their own
        const Vec3 n = meeting.crossing_normal;
        const real radius_a = rolling_radius(kind_a, a, meeting.normal);
        const real radius_b = rolling_radius(kind_b, b, meeting.normal);
        m = with_point(manifold_along(n, frame_on_round(NORMAL_FIXED, radius_a, radius_b), radius_a, radius_b),
                       add3(meeting.at_a, scale3(radius_a - core_a, n)), sub3(meeting.at_b, scale3(radius_b, n)), 0u);
      } else {
        // a face of the other shape may be as good a normal but for rounding, and have something over it
        const Meeting other = meet_other_face(kind_a, a, kind_b, b, tables, meeting.frame, limit, tolerance);
        if (other.gap > meeting.gap - (real)4 * tolerance) {
          meeting = other;
          continue;
        }
        found = !facet;
      }
    }
    if (found && shape_tells(kind_a, a, tables, scale3((real)-1, m.normal)) && shape_tells(kind_b, b, tables, m.normal))
      return m;
#if FEATURE_FACETS
    inside = true;
    meeting = meet_inside(facet_a ? a : b, tables, facet_a);
#endif
  }
}

#endif
