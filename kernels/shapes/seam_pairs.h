// Pairs with a shape whose neighbours cover edges of it (seams.h). What the pair has by itself counts unless its
// neighbours cover all its points; then what it has along the best normal that they leave.
// cpu_reference/shapes/seam_pairs.hpp is the twin.
#ifndef LOCKSTEP_SEAM_PAIRS_H
#define LOCKSTEP_SEAM_PAIRS_H

#include "shapes/patch_pairs.h"
#include "shapes/seams.h"

#if FEATURE_SEAMS
static inline Polytope polytope_with_seams(u32 kind, const WorldShape* shape, const HullTables* tables) {
  Polytope p = polytope_of(kind, shape, tables);
  p.first_seam = shape->first_seam;
  p.seam_count = shape->seam_count;
  return p;
}

static inline Vec3 moved_into(const Polytope* p, Vec3 point) {
  for (u32 f = 0u; f < bound_count(p); ++f) {
    const Vec4 plane = bound_plane(p, f);
    const Vec3 out = make3(plane.x, plane.y, plane.z);
    const real height = dot3(out, point) - plane.w;
    if (height > (real)0) point = sub3(point, scale3(height, out));
  }
  return point;
}

// The point of p that a point of its surface stands for, own coordinates: parts of surfaces that face each other share
// points that are past an edge, or not quite at it, but by little. `up`: the normal. Past a sharp edge it would miss p.
static inline Vec3 moved_to_edge(const Polytope* p, Vec3 point, Vec3 up) {
  const real tolerance = seam_tolerance(p, 0u);
  const Vec3 moved = moved_into(p, add3(point, scale3((real)100 * tolerance, up)));
  return poly_contains(p, moved, (real)0.5 * tolerance, (real)0.5 * tolerance) ? moved : moved_into(p, point);
}

// What comes to a shape p, and one of the points at which it would touch.
typedef struct OtherShape {
  u32 kind;
  WorldShape shape;
  Vec3 point, up;  // on p, and the normal out of p; own coordinates of p
  Vec3 core;       // the anchor of the other shape that the contact keeps a radius from, own coordinates of p
  real radius;
} OtherShape;

// How deep the other shape is below a plane in the frame of p, m; negative above it.
static inline real depth_below(const Polytope* p, const OtherShape* v, const HullTables* tables, Vec3 normal,
                               real offset) {
  if (v->radius > (real)0 && v->kind != SHAPE_CYLINDER) return offset + v->radius - dot3(normal, v->core);
  const Vec3 world = out_of_frame(p->axes, normal);
  return offset + core_extent(v->kind, &v->shape, tables, scale3((real)-1, world)) -
         dot3(world, sub3(v->shape.center, p->center));
}

// Whether a stretch of a line that starts at a point, along a unit direction, meets a polytope; own coordinates.
static inline bool poly_meets_stretch(const Polytope* p, Vec3 start, Vec3 along, real length, real tolerance) {
  real from = (real)0, to = length;
  for (u32 f = 0u; f < bound_count(p); ++f) {
    const Vec4 plane = bound_plane(p, f);
    const Vec3 out = make3(plane.x, plane.y, plane.z);
    const real above = dot3(out, start) - plane.w - tolerance, slope = dot3(out, along);
    if (above > (real)0 && !(slope < (real)0)) return false;
    if (!(slope > (real)0) && !(slope < (real)0)) continue;
    const real crossing = -above / slope;
    if (slope < (real)0 && crossing > from) from = crossing;
    if (slope > (real)0 && crossing < to) to = crossing;
  }
  return from <= to;
}

// Whether a neighbour on the other side of a gap holds the other shape so that it cannot touch p at the point: that
// is over a face of it just beside, and not below this face, and the point is not above it, nor does the surface of p
// rise from it there.
static inline bool neighbour_supports(const Polytope* p, const Polytope* neighbour, const OtherShape* v,
                                      const HullTables* tables, real tolerance) {
  const real size = length3(v->shape.size);
  for (u32 f = 0u; f < neighbour->faces; ++f) {
    const Vec4 plane = poly_own_plane(neighbour, f);
    const Vec3 normal = out_of_frame(neighbour->axes, make3(plane.x, plane.y, plane.z));
    const real offset = plane.w + dot3(normal, neighbour->center), height = dot3(normal, v->point) - offset;
    const real steep = dot3(v->up, normal), square = (real)1 - steep * steep;
    if (height > tolerance || !(square > (real)1e-4)) continue;
    if (depth_below(p, v, tables, normal, offset) > (real)SEAM_DIP * size) continue;
    const Vec3 along = scale3((real)1 / sqrt(square), sub3(v->up, scale3(steep, normal)));
    real span = (real)SEAM_SPAN * size;
    Vec3 start = sub3(v->point, scale3(height, normal));
    const Vec3 axis = into_frame(p->axes, axes_of(v->shape.rotation).z);
    const bool on_end = v->kind == SHAPE_CYLINDER && fabs(dot3(axis, normal)) > (real)0.99;
    if (v->radius > (real)0 && !on_end) {  // what is round is lowest below its axis
      start = sub3(v->core, scale3(dot3(normal, v->core) - offset, normal));
      const real length = (real)2 * v->shape.size.y * fabs(dot3(axis, along));
      span = length < span ? length : span;
    }
    if (!poly_meets_stretch(neighbour, into_frame(neighbour->axes, sub3(start, neighbour->center)),
                            into_frame(neighbour->axes, along), span, tolerance))
      continue;
    const Vec3 rise = sub3(normal, scale3(steep, v->up));
    const Vec3 beside = add3(v->point, scale3(((real)3 * tolerance - height) / square, rise));
    if (!poly_contains(p, beside, (real)0.5 * tolerance, (real)0.5 * tolerance)) return true;
  }
  return false;
}

// Whether some neighbour beyond a gap holds the other shape.
static inline bool gaps_cover(const Polytope* p, const OtherShape* v, const HullTables* tables) {
  for (u32 k = 0u; k < p->seam_count; ++k) {
    if (!seam_has_gap(p, k)) continue;
    const Polytope neighbour = seam_neighbour(p, k);
    if (neighbour_supports(p, &neighbour, v, tables, seam_tolerance(p, k))) return true;
  }
  return false;
}

// Whether the neighbours of one side cover all points of a manifold. `other`: what comes.
CALLED bool seams_cover_side(u32 kind, const WorldShape* shape, u32 other_kind, const WorldShape* other,
                             const HullTables* tables, const Manifold* m, bool is_a) {
  if (shape->seam_count == 0u) return false;
  const Polytope p = polytope_with_seams(kind, shape, tables);
  const Vec3 up = into_frame(p.axes, is_a ? scale3((real)-1, m->normal) : m->normal);
  for (u32 k = 0u; k < m->count; ++k) {
    // of a point on a face the anchor may be any point of the face's plane: the other side says where
    const bool on_face = m->frame == (is_a ? NORMAL_OF_A : NORMAL_OF_B);
    const real gap = on_face ? gap_at(m, k) : (real)0;
    const Vec3 point = is_a != on_face ? sub3(m->points[k].anchor_a, scale3(m->radius_a + gap, m->normal))
                                       : add3(m->points[k].anchor_b, scale3(m->radius_b + gap, m->normal));
    OtherShape touching;
    touching.kind = other_kind;
    touching.shape = *other;
    touching.point = moved_to_edge(&p, into_frame(p.axes, sub3(point, p.center)), up);
    touching.up = up;
    if (seams_cover(&p, touching.point, up)) continue;
    touching.core = into_frame(p.axes, sub3(is_a ? m->points[k].anchor_b : m->points[k].anchor_a, p.center));
    touching.radius = is_a ? m->radius_b : m->radius_a;
    if (!gaps_cover(&p, &touching, tables)) return false;
  }
  return true;
}

CALLED bool seams_cover_all(u32 kind_a, const WorldShape* a, u32 kind_b, const WorldShape* b, const HullTables* tables,
                            const Manifold* m) {
  return m->count > 0u && (seams_cover_side(kind_a, a, kind_b, b, tables, m, true) ||
                           seams_cover_side(kind_b, b, kind_a, a, tables, m, false));
}

// A sphere that reaches through what covers the nearest face of b: through another one, if its centre is in b->
CALLED Manifold sphere_over_seams(const WorldShape* a, u32 kind_b, const WorldShape* b, const HullTables* tables) {
  const Polytope p = polytope_with_seams(kind_b, b, tables);
  const Vec3 center = into_frame(p.axes, sub3(a->center, p.center));
  Manifold best = no_manifold();
  if (is_facet(kind_b, b) || !poly_contains(&p, center, (real)0, (real)0)) return best;
  real highest = (real)-1e30;
  for (u32 f = 0u; f < p.faces; ++f) {
    const Vec4 plane = poly_own_plane(&p, f);
    const Vec3 own = make3(plane.x, plane.y, plane.z);
    const real height = dot3(own, center) - plane.w;
    if (!(height > highest) || height < -plane.w) continue;  // not through its middle
    const Vec3 normal = out_of_frame(p.axes, own), foot = sub3(a->center, scale3(height, normal));
    if (seams_cover(&p, sub3(center, scale3(height, own)), own)) continue;
    highest = height;
    best = manifold_at(normal, NORMAL_OF_B, a->center, a->size.x, foot, (real)0, 0u);
  }
  return best;
}

#if FEATURE_FACETS
// Along the normal of a facet, what it holds.
static inline Manifold facet_over_seams(u32 kind_a, const WorldShape* a, u32 kind_b, const WorldShape* b,
                                        const HullTables* tables, bool is_a, real limit) {
  const Meeting inside = meet_inside(is_a ? a : b, tables, is_a);
  const Manifold shared = touch_along(kind_a, a, kind_b, b, tables, inside, limit, shape_tolerance(a, b));
  const Manifold m = keep_points_inside(a, b, tables, is_a, &shared, limit);
  return seams_cover_all(kind_a, a, kind_b, b, tables, &m) ? no_manifold() : m;
}
#endif

// A face of one of the two shapes as the normal of a meeting.
typedef struct FaceChoice {
  real gap;
  u32 index;  // in the faces of a, then those of b
  u32 frame;
  Vec3 normal;
} FaceChoice;

static inline FaceChoice face_choice(real gap, u32 index, u32 frame, Vec3 normal) {
  const FaceChoice choice = {gap, index, frame, normal};
  return choice;
}

// The best of the faces that come after one that was tried, in the order of their gaps; none: its gap is -1e30. A face
// that the other shape reaches behind the middle of is none, nor one behind which it is deeper than the middle of the
// smaller of the two.
CALLED FaceChoice next_face(u32 kind_a, const WorldShape* a, u32 kind_b, const WorldShape* b, const HullTables* tables,
                            FaceChoice tried) {
  FaceChoice best = face_choice((real)-1e30, 0u, NORMAL_FIXED, make3((real)0, (real)0, (real)1));
  const real deepest = (real)-0.5 * smaller_size(a, b);
  u32 index = 0u;
  for (u32 side = 0u; side < 2u; ++side) {
    const bool of_a = side == 0u;
    const u32 kind = of_a ? kind_a : kind_b, other_kind = of_a ? kind_b : kind_a;
    if (kind != SHAPE_BOX && kind != SHAPE_HULL) continue;
    const WorldShape *shape = of_a ? a : b, *other = of_a ? b : a;
    const Polytope p = polytope_of(kind, shape, tables);
    for (u32 f = 0u; f < p.faces; ++f, ++index) {
      const Vec4 plane = poly_own_plane(&p, f);
      const Vec3 out = out_of_frame(p.axes, make3(plane.x, plane.y, plane.z));
      const real gap = dot3(out, sub3(other->center, p.center)) -
                       core_extent(other_kind, other, tables, scale3((real)-1, out)) - plane.w;
      const bool after = gap < tried.gap || (gap == tried.gap && index > tried.index);
      if (!after || !(gap > best.gap) || gap < -plane.w || gap < deepest) continue;
      best = face_choice(gap, index, of_a ? NORMAL_OF_A : NORMAL_OF_B, scale3(of_a ? (real)-1 : (real)1, out));
    }
  }
  return best;
}

// Where the two cross at edges that no neighbour covers; only of shapes that overlap, and by less than to the middle
// of either.
CALLED Meeting meet_open_edges(u32 kind_a, const WorldShape* a, u32 kind_b, const WorldShape* b,
                               const HullTables* tables, real tolerance) {
  const Meeting none = no_meeting();
  if (kind_a == SHAPE_CYLINDER || kind_b == SHAPE_CYLINDER) return none;
  const Polytope one = polytope_with_seams(kind_a, a, tables), other = polytope_with_seams(kind_b, b, tables);
  const Meeting meeting = poly_edge_query(&one, &other, none, tolerance);
  const real extent_a = poly_extent(&one, scale3((real)-1, meeting.normal));
  const real extent_b = poly_extent(&other, meeting.normal);
  return meeting.gap > (real)0 || meeting.gap < -extent_a || meeting.gap < -extent_b ? none : meeting;
}

// What is left where the best normal of a pair is covered. Kinds in order, as in collide_shapes.
CALLED Manifold touch_over_seams(u32 kind_a, const WorldShape* a, u32 kind_b, const WorldShape* b,
                                 const HullTables* tables, real limit) {
  if (kind_a == SHAPE_SPHERE) return sphere_over_seams(a, kind_b, b, tables);
#if FEATURE_FACETS
  if (is_facet(kind_a, a) || is_facet(kind_b, b))
    return facet_over_seams(kind_a, a, kind_b, b, tables, is_facet(kind_a, a), limit);
#endif
  const real tolerance = shape_tolerance(a, b), core_a = patch_core_radius(kind_a, a);
  Meeting edges = meet_open_edges(kind_a, a, kind_b, b, tables, tolerance);
  FaceChoice face = face_choice((real)1e30, 0u, NORMAL_FIXED, make3((real)0, (real)0, (real)1));
  for (;;) {
    face = next_face(kind_a, a, kind_b, b, tables, face);
    if (edges.gap > face.gap + tolerance) {
      const Manifold m = touch_along(kind_a, a, kind_b, b, tables, edges, limit, tolerance);
      if (!seams_cover_all(kind_a, a, kind_b, b, tables, &m)) return m;
      edges = no_meeting();
    }
    if (!(face.gap > (real)-1e29)) return no_manifold();
    if (face.gap > limit + core_a) continue;
    Meeting meeting = no_meeting();
    meeting.normal = face.normal;
    meeting.frame = face.frame;
    const Manifold m = touch_along(kind_a, a, kind_b, b, tables, meeting, limit, tolerance);
    const bool nothing_over_it = m.count == 1u && m.points[0].feature == 0u;
    if (!nothing_over_it && !seams_cover_all(kind_a, a, kind_b, b, tables, &m)) return m;
  }
}
#endif

#endif
