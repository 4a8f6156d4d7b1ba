// Boxes, convex hulls and the core segments of capsules under one roof: vertices, edges and faces of a convex
// polyhedron. cpu_reference/shapes/polytope.hpp is the twin.
#ifndef LOCKSTEP_POLYTOPE_H
#define LOCKSTEP_POLYTOPE_H

#include "shapes/axes.h"

// The size of the smaller one of two shapes; a plane, of size 0, has none.
static inline real smaller_size(const WorldShape* a, const WorldShape* b) {
  const real size_a = length3(a->size), size_b = length3(b->size);
  return size_a > (real)0 && (size_a < size_b || !(size_b > (real)0)) ? size_a : size_b;
}

// What is left to the wish that contacts keep their features, relative to the smaller shape, and to rounding, relative
// to both: coordinates are those of the larger one.
static inline real shape_tolerance(const WorldShape* a, const WorldShape* b) {
  const real rounding = sizeof(real) == 4 ? (real)2.4e-7 : (real)4.5e-16;
  return (real)2e-6 * smaller_size(a, b) + rounding * (length3(a->size) + length3(b->size));
}

// "Own" coordinates are those of the shape's frame. A segment has two vertices, an edge and no face.
typedef struct Polytope {
  u32 kind;  // SHAPE_CAPSULE stands for the core segment
  Vec3 center;
  Axes axes;
  Vec3 size;
  u32 vertices, faces, edges;  // how many
  u32 first_vertex, first_face, first_edge;
#if FEATURE_FACETS
  u32 index;   // of a facet, into `facets`; else NONE
  bool facet;  // its surface goes on around it (facet.h)
  u32 flags;   // of a facet
#endif
#if FEATURE_SEAMS
  u32 first_seam, seam_count;  // those that count against its crossings (seams.h)
#endif
  const HullTables* tables;
} Polytope;

static inline bool is_facet(u32 kind, const WorldShape* shape) {
#if FEATURE_FACETS
  return kind == SHAPE_HULL && !shape->alone && (shape->hull & HULL_IS_FACET) != 0u;
#else
  return false;
#endif
}

#if FEATURE_FACETS
// The corner that follows one around their vertex.
static inline u32 facet_next(const HullTables* tables, u32 index, u32 corner) {
  const u32 next = tables->facets[index].next[corner];
  const bool stored = (tables->facets[index].flags >> FACET_EDGE_SHIFT(corner) & 3u) == FACET_EDGE_STORED;
  return stored ? tables->facet_edges[next].next : next;
}

// The plane of a facet, and behind it those of what is across its edges, through the origin.
static inline Vec4 facet_plane(const HullTables* tables, u32 index, u32 f) {
  global const Facet* facet = tables->facets + index;
  Vec4 plane = {facet->normal[0], facet->normal[1], facet->normal[2], facet->height};
  if (f == 0u) return plane;
  const u32 edge = f - 1u, kind = facet->flags >> FACET_EDGE_SHIFT(edge) & 3u;
  global const real* across = facet->normal;
  if (kind == FACET_EDGE_ROOF) across = tables->facets[facet->next[edge] >> 2].normal;
  if (kind == FACET_EDGE_STORED) across = tables->facet_edges[facet->next[edge]].across;
  plane.x = across[0];
  plane.y = across[1];
  plane.z = across[2];
  plane.w = (real)0;
  return plane;
}
#endif

CALLED Polytope polytope_of(u32 kind, const WorldShape* shape, const HullTables* tables) {
  Polytope p;
  p.kind = kind;
  p.center = shape->center;
  p.axes = axes_of(shape->rotation);
  p.size = shape->size;
  p.vertices = kind == SHAPE_BOX ? 8 : 2;
  p.faces = kind == SHAPE_BOX ? 6 : 0;
  p.edges = kind == SHAPE_BOX ? 12 : 1;
  p.first_vertex = 0;
  p.first_face = 0;
  p.first_edge = 0;
#if FEATURE_FACETS
  p.index = NONE;
  p.facet = is_facet(kind, shape);
  p.flags = 0u;
#endif
#if FEATURE_SEAMS
  p.first_seam = 0u;
  p.seam_count = 0u;
#endif
  p.tables = tables;
#if FEATURE_FACETS
  if (kind == SHAPE_HULL && (shape->hull & HULL_IS_FACET) != 0u) {
    p.index = shape->hull & ~HULL_IS_FACET;
    p.vertices = 3u;
    p.faces = 1u;
    p.edges = 3u;
    p.flags = tables->facets[p.index].flags;
    return p;
  }
#endif
  if (FEATURE_HULLS && kind == SHAPE_HULL) {
    const Hull hull = tables->hulls[shape->hull];
    p.vertices = hull.vertex_count;
    p.faces = hull.face_count;
    p.edges = hull.edge_count;
    p.first_vertex = hull.first_vertex;
    p.first_face = hull.first_face;
    p.first_edge = hull.first_edge;
  }
  return p;
}

// Bits 0, 1, 2 of a box's vertex say on which side along x, y, z it is.
static inline Vec3 poly_own_vertex(const Polytope* p, u32 i) {
#if FEATURE_FACETS
  if (p->index != NONE) return facet_vertex(p->tables->facets + p->index, i);
#endif
  if (FEATURE_HULLS && p->kind == SHAPE_HULL) {
    const Vec4 v = p->tables->vertices[p->first_vertex + i];
    return make3(v.x, v.y, v.z);
  }
  if (p->kind == SHAPE_CAPSULE) return make3((real)0, (real)0, i == 0 ? -p->size.y : p->size.y);
  return make3((i & 1) != 0 ? p->size.x : -p->size.x, (i & 2) != 0 ? p->size.y : -p->size.y,
               (i & 4) != 0 ? p->size.z : -p->size.z);
}

static inline Vec3 poly_vertex(const Polytope* p, u32 i) {
  return add3(p->center, out_of_frame(p->axes, poly_own_vertex(p, i)));
}

// Face 2 k of a box looks along the negative axis k, face 2 k + 1 along the positive one. The plane of a face is
// xyz . x = w.
static inline Vec4 poly_own_plane(const Polytope* p, u32 f) {
#if FEATURE_FACETS
  if (p->index != NONE) return facet_plane(p->tables, p->index, f);
#endif
  if (FEATURE_HULLS && p->kind == SHAPE_HULL) return p->tables->planes[p->first_face + f];
  const real side = (f & 1) != 0 ? (real)1 : (real)-1;
  const u32 k = f >> 1;
  Vec4 plane;
  plane.x = k == 0 ? side : (real)0;
  plane.y = k == 1 ? side : (real)0;
  plane.z = k == 2 ? side : (real)0;
  plane.w = k == 0 ? p->size.x : k == 1 ? p->size.y : p->size.z;
  return plane;
}

static inline Vec3 poly_own_normal(const Polytope* p, u32 f) {
  const Vec4 plane = poly_own_plane(p, f);
  return make3(plane.x, plane.y, plane.z);
}

static inline u32 poly_corner_count(const Polytope* p, u32 f) {
#if FEATURE_FACETS
  if (p->index != NONE) return 3u;
#endif
  return FEATURE_HULLS && p->kind == SHAPE_HULL ? p->tables->faces[p->first_face + f].corner_count : 4;
}

// The vertex at corner i of face f, counter-clockwise seen from outside.
static inline u32 poly_corner(const Polytope* p, u32 f, u32 i) {
#if FEATURE_FACETS
  if (p->index != NONE) return i;
#endif
  if (FEATURE_HULLS && p->kind == SHAPE_HULL)
    return p->tables->corners[p->tables->faces[p->first_face + f].first_corner + i];
  const u32 k = f >> 1, side = f & 1, u = k == 2 ? 0 : k + 1, v = u == 2 ? 0 : u + 1;
  const u32 early = i == 1 || i == 2 ? 1 : 0, late = i == 2 || i == 3 ? 1 : 0;
  return side << k | (side != 0 ? early : late) << u | (side != 0 ? late : early) << v;
}

// Edges 4 k .. 4 k + 3 of a box are along axis k. A segment's edge has no faces. What is across edge k of a facet is
// its plane 1 + k.
static inline HullEdge poly_edge(const Polytope* p, u32 e) {
#if FEATURE_FACETS
  if (p->index != NONE) {
    const HullEdge of_facet = {e, e == 2u ? 0u : e + 1u, 0u, 1u + e};
    return of_facet;
  }
#endif
  if (FEATURE_HULLS && p->kind == SHAPE_HULL) return p->tables->edges[p->first_edge + e];
  HullEdge edge = {0, 1, NONE, NONE};
  if (p->kind == SHAPE_CAPSULE) return edge;
  const u32 k = e >> 2, u = k == 2 ? 0 : k + 1, v = u == 2 ? 0 : u + 1;
  const u32 side_u = e & 1, side_v = e >> 1 & 1;
  const u32 face_u = 2 * u + side_u, face_v = 2 * v + side_v;
  edge.vertex_a = side_u << u | side_v << v;
  edge.vertex_b = edge.vertex_a | 1u << k;
  edge.face_left = side_u == side_v ? face_u : face_v;
  edge.face_right = side_u == side_v ? face_v : face_u;
  return edge;
}

// The first of the vertices that are farthest along an own direction.
CALLED u32 poly_support(const Polytope* p, Vec3 own) {
  if (p->kind == SHAPE_CAPSULE) return own.z > (real)0 ? 1 : 0;
  if (p->kind == SHAPE_BOX)
    return (own.x > (real)0 ? 1u : 0u) | (own.y > (real)0 ? 2u : 0u) | (own.z > (real)0 ? 4u : 0u);
  u32 best = 0;
  real most = dot3(own, poly_own_vertex(p, 0));
  for (u32 i = 1; i < p->vertices; ++i) {
    const real x = dot3(own, poly_own_vertex(p, i));
    if (x > most) {
      most = x;
      best = i;
    }
  }
  return best;
}

// How far the polytope reaches from its centre along a direction in the world.
CALLED real poly_extent(const Polytope* p, Vec3 direction) {
  const Vec3 own = into_frame(p->axes, direction);
  return dot3(own, poly_own_vertex(p, poly_support(p, own)));
}

// How two shapes meet along their best normal: the signed separation, and the points that are there.
typedef struct Meeting {
  real gap;
  Vec3 normal;  // from b to a
  u32 frame;    // NormalFrame
  Vec3 at_a, at_b;
  real crossing_gap;     // gap of the crossing that these points are from
  Vec3 crossing_normal;  // and its normal
} Meeting;

static inline Meeting no_meeting(void) {
  Meeting none;
  none.gap = (real)-1e30;
  none.normal = make3((real)0, (real)0, (real)1);
  none.frame = NORMAL_FIXED;
  none.at_a = make3((real)0, (real)0, (real)0);
  none.at_b = none.at_a;
  none.crossing_gap = none.gap;
  none.crossing_normal = none.normal;
  return none;
}

// The same seen from the other side.
static inline Meeting meeting_swapped(Meeting m) {
  const Vec3 at = m.at_a;
  m.at_a = m.at_b;
  m.at_b = at;
  m.normal = scale3((real)-1, m.normal);
  m.crossing_normal = scale3((real)-1, m.crossing_normal);
  m.frame = m.frame == NORMAL_OF_A ? (u32)NORMAL_OF_B : m.frame == NORMAL_OF_B ? (u32)NORMAL_OF_A : m.frame;
  return m;
}

// Crossings with gaps up to this change nothing in the best meeting.
static inline real meeting_least(const Meeting* best, real tolerance) {
  if (best->frame == NORMAL_FIXED) return best->gap;
  const real near = best->gap - (real)100 * tolerance;
  return near > best->crossing_gap ? near : best->crossing_gap;
}

// What a crossing may lie outside of an edge, as a share of it, by rounding.
static inline bool within_share(real share) { return share > (real)-1e-3 && share < (real)1.001; }

static inline real clamp_share(real x) { return x < (real)0 ? (real)0 : x > (real)1 ? (real)1 : x; }

// Takes a better meeting. Of faces, the normal is sure but not the place, as their neighbours are nearly as good a
// normal: a crossing that is no worse by much says where.
CALLED Meeting meeting_offer(Meeting best, real gap, Vec3 normal, u32 frame, Vec3 at_a, Vec3 at_b, real tolerance) {
  if (gap > best.gap + (best.frame == NORMAL_FIXED && frame == NORMAL_FIXED ? (real)0 : tolerance)) {
    best.gap = gap;
    best.normal = normal;
    best.frame = frame;
    best.at_a = at_a;
    best.at_b = at_b;
    best.crossing_gap = frame == NORMAL_FIXED ? gap : (real)-1e30;
    best.crossing_normal = normal;
  } else if (frame == NORMAL_FIXED && gap > meeting_least(&best, tolerance)) {
    best.at_a = at_a;
    best.at_b = at_b;
    best.crossing_gap = gap;
    best.crossing_normal = normal;
  }
  return best;
}

#endif
