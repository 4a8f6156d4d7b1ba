// Boxes, convex hulls and the core segments of capsules under one roof: vertices, edges and faces of a convex
// polyhedron. kernels/shapes/polytope.h is the twin.
#pragma once

#include "cpu_reference/shapes/axes.hpp"

namespace lockstep::reference {

/// The size of the smaller one of two shapes; a plane, of size 0, has none.
template <class real>
real smaller_size(const WorldShape<real>& a, const WorldShape<real>& b) {
  const real size_a = length3(a.size), size_b = length3(b.size);
  return size_a > 0 && (size_a < size_b || !(size_b > 0)) ? size_a : size_b;
}

/// What is left to the wish that contacts keep their features, relative to the smaller shape, and to rounding, relative
/// to both: coordinates are those of the larger one.
template <class real>
real shape_tolerance(const WorldShape<real>& a, const WorldShape<real>& b) {
  const real rounding = sizeof(real) == 4 ? real(2.4e-7) : real(4.5e-16);
  return real(2e-6) * smaller_size(a, b) + rounding * (length3(a.size) + length3(b.size));
}

/// "Own" coordinates are those of the shape's frame. A segment has two vertices, an edge and no face.
template <class real>
struct Polytope {
  u32 kind;  // SHAPE_CAPSULE stands for the core segment
  Vec3<real> center;
  Axes<real> axes;
  Vec3<real> size;
  u32 vertices, faces, edges;  // how many
  u32 first_vertex, first_face, first_edge;
  u32 index;                   // of a facet, into `facets`; else NONE
  bool facet;                  // its surface goes on around it (facet.hpp)
  u32 flags;                   // of a facet
  u32 first_seam, seam_count;  // those that count against its crossings (seams.hpp)
  HullTables<real> tables;
};

template <class real>
bool is_facet(u32 kind, const WorldShape<real>& shape) {
  return kind == SHAPE_HULL && !shape.alone && (shape.hull & HULL_IS_FACET) != 0;
}

/// The corner that follows one around their vertex.
template <class real>
u32 facet_next(const HullTables<real>& tables, u32 index, u32 corner) {
  const Facet<real>& facet = tables.facets[index];
  const bool stored = (facet.flags >> FACET_EDGE_SHIFT(corner) & 3) == FACET_EDGE_STORED;
  return stored ? tables.facet_edges[facet.next[corner]].next : facet.next[corner];
}

/// The plane of a facet, and behind it those of what is across its edges, through the origin.
template <class real>
Vec4<real> facet_plane(const HullTables<real>& tables, u32 index, u32 f) {
  const Facet<real>& facet = tables.facets[index];
  if (f == 0) return {facet.normal[0], facet.normal[1], facet.normal[2], facet.height};
  const u32 edge = f - 1, kind = facet.flags >> FACET_EDGE_SHIFT(edge) & 3;
  const real* across = facet.normal;
  if (kind == FACET_EDGE_ROOF) across = tables.facets[facet.next[edge] >> 2].normal;
  if (kind == FACET_EDGE_STORED) across = tables.facet_edges[facet.next[edge]].across;
  return {across[0], across[1], across[2], 0};
}

template <class real>
Polytope<real> polytope_of(u32 kind, const WorldShape<real>& shape, const HullTables<real>& tables) {
  Polytope<real> p;
  p.kind = kind;
  p.center = shape.center;
  p.axes = axes_of(shape.rotation);
  p.size = shape.size;
  p.vertices = kind == SHAPE_BOX ? 8 : 2;
  p.faces = kind == SHAPE_BOX ? 6 : 0;
  p.edges = kind == SHAPE_BOX ? 12 : 1;
  p.first_vertex = 0;
  p.first_face = 0;
  p.first_edge = 0;
  p.index = NONE;
  p.facet = is_facet(kind, shape);
  p.flags = 0;
  p.first_seam = 0;
  p.seam_count = 0;
  p.tables = tables;
  if (kind == SHAPE_HULL && (shape.hull & HULL_IS_FACET) != 0) {
    p.index = shape.hull & ~HULL_IS_FACET;
    p.vertices = 3;
    p.faces = 1;
    p.edges = 3;
    p.flags = tables.facets[p.index].flags;
  } else if (kind == SHAPE_HULL) {
    const Hull hull = tables.hulls[shape.hull];
    p.vertices = hull.vertex_count;
    p.faces = hull.face_count;
    p.edges = hull.edge_count;
    p.first_vertex = hull.first_vertex;
    p.first_face = hull.first_face;
    p.first_edge = hull.first_edge;
  }
  return p;
}

/// Bits 0, 1, 2 of a box's vertex say on which side along x, y, z it is.
template <class real>
Vec3<real> poly_own_vertex(const Polytope<real>& p, u32 i) {
  if (p.index != NONE) return facet_vertex(p.tables.facets[p.index], i);
  if (p.kind == SHAPE_HULL) {
    const Vec4<real> v = p.tables.vertices[p.first_vertex + i];
    return Vec3<real>{v.x, v.y, v.z};
  }
  if (p.kind == SHAPE_CAPSULE) return Vec3<real>{0, 0, i == 0 ? -p.size.y : p.size.y};
  return Vec3<real>{(i & 1) != 0 ? p.size.x : -p.size.x, (i & 2) != 0 ? p.size.y : -p.size.y,
                    (i & 4) != 0 ? p.size.z : -p.size.z};
}

template <class real>
Vec3<real> poly_vertex(const Polytope<real>& p, u32 i) {
  return add3(p.center, out_of_frame(p.axes, poly_own_vertex(p, i)));
}

/// Face 2 k of a box looks along the negative axis k, face 2 k + 1 along the positive one. The plane of a face is
/// xyz . x = w.
template <class real>
Vec4<real> poly_own_plane(const Polytope<real>& p, u32 f) {
  if (p.index != NONE) return facet_plane(p.tables, p.index, f);
  if (p.kind == SHAPE_HULL) return p.tables.planes[p.first_face + f];
  const real side = (f & 1) != 0 ? real(1) : real(-1);
  const u32 k = f >> 1;
  Vec4<real> plane;
  plane.x = k == 0 ? side : real(0);
  plane.y = k == 1 ? side : real(0);
  plane.z = k == 2 ? side : real(0);
  plane.w = k == 0 ? p.size.x : k == 1 ? p.size.y : p.size.z;
  return plane;
}

template <class real>
Vec3<real> poly_own_normal(const Polytope<real>& p, u32 f) {
  const Vec4<real> plane = poly_own_plane(p, f);
  return Vec3<real>{plane.x, plane.y, plane.z};
}

template <class real>
u32 poly_corner_count(const Polytope<real>& p, u32 f) {
  if (p.index != NONE) return 3;
  return p.kind == SHAPE_HULL ? p.tables.faces[p.first_face + f].corner_count : 4;
}

/// The vertex at corner i of face f, counter-clockwise seen from outside.
template <class real>
u32 poly_corner(const Polytope<real>& p, u32 f, u32 i) {
  if (p.index != NONE) return i;
  if (p.kind == SHAPE_HULL) return p.tables.corners[p.tables.faces[p.first_face + f].first_corner + i];
  const u32 k = f >> 1, side = f & 1, u = k == 2 ? 0 : k + 1, v = u == 2 ? 0 : u + 1;
  const u32 early = i == 1 || i == 2 ? 1 : 0, late = i == 2 || i == 3 ? 1 : 0;
  return side << k | (side != 0 ? early : late) << u | (side != 0 ? late : early) << v;
}

/// Edges 4 k .. 4 k + 3 of a box are along axis k. A segment's edge has no faces. What is across edge k of a facet is
/// its plane 1 + k.
template <class real>
HullEdge poly_edge(const Polytope<real>& p, u32 e) {
  if (p.index != NONE) return {e, e == 2 ? 0 : e + 1, 0, 1 + e};
  if (p.kind == SHAPE_HULL) return p.tables.edges[p.first_edge + e];
  HullEdge edge = {0, 1, NONE, NONE};
  if (p.kind == SHAPE_CAPSULE) return edge;
  const u32 k = e >> 2, u = k == 2 ? 0 : k + 1, v = u == 2 ? 0 : u + 1;
  const u32 side_u = e & 1, side_v = e >> 1 & 1;
  const u32 face_u = 2 * u + side_u, face_v = 2 * v + side_v;
  edge.vertex_a = side_u << u | side_v << v;
  edge.vertex_b = edge.vertex_a | 1u << k;
  edge.face_left = side_u == side_v ? face_u : face_v;
  edge.face_right = side_u == side_v ? face_v : face_u;
  return edge;
}

/// The first of the vertices that are farthest along an own direction.
template <class real>
u32 poly_support(const Polytope<real>& p, Vec3<real> own) {
  if (p.kind == SHAPE_CAPSULE) return own.z > 0 ? 1 : 0;
  if (p.kind == SHAPE_BOX) return (own.x > 0 ? 1u : 0u) | (own.y > 0 ? 2u : 0u) | (own.z > 0 ? 4u : 0u);
  u32 best = 0;
  real most = dot3(own, poly_own_vertex(p, 0));
  for (u32 i = 1; i < p.vertices; ++i) {
    const real x = dot3(own, poly_own_vertex(p, i));
    if (x > most) {
      most = x;
      best = i;
    }
  }
  return best;
}

/// How far the polytope reaches from its centre along a direction in the world.
template <class real>
real poly_extent(const Polytope<real>& p, Vec3<real> direction) {
  const Vec3<real> own = into_frame(p.axes, direction);
  return dot3(own, poly_own_vertex(p, poly_support(p, own)));
}

/// How two shapes meet along their best normal: the signed separation, and the points that are there.
template <class real>
struct Meeting {
  real gap;
  Vec3<real> normal;  // from b to a
  u32 frame;          // NormalFrame
  Vec3<real> at_a, at_b;
  real crossing_gap;           // gap of the crossing that these points are from
  Vec3<real> crossing_normal;  // and its normal
};

template <class real>
Meeting<real> no_meeting() {
  Meeting<real> none;
  none.gap = real(-1e30);
  none.normal = Vec3<real>{0, 0, 1};
  none.frame = NORMAL_FIXED;
  none.at_a = Vec3<real>{0, 0, 0};
  none.at_b = none.at_a;
  none.crossing_gap = none.gap;
  none.crossing_normal = none.normal;
  return none;
}

/// The same seen from the other side.
template <class real>
Meeting<real> meeting_swapped(Meeting<real> m) {
  const Vec3<real> at = m.at_a;
  m.at_a = m.at_b;
  m.at_b = at;
  m.normal = scale3(real(-1), m.normal);
  m.crossing_normal = scale3(real(-1), m.crossing_normal);
  m.frame = m.frame == NORMAL_OF_A ? u32(NORMAL_OF_B) : m.frame == NORMAL_OF_B ? u32(NORMAL_OF_A) : m.frame;
  return m;
}

/// Crossings with gaps up to this change nothing in the best meeting.
template <class real>
real meeting_least(const Meeting<real>& best, real tolerance) {
  if (best.frame == NORMAL_FIXED) return best.gap;
  const real near = best.gap - real(100) * tolerance;
  return near > best.crossing_gap ? near : best.crossing_gap;
}

/// What a crossing may lie outside of an edge, as a share of it, by rounding.
template <class real>
bool within_share(real share) {
  return share > real(-1e-3) && share < real(1.001);
}

template <class real>
real clamp_share(real x) {
  return x < 0 ? real(0) : x > 1 ? real(1) : x;
}

/// Takes a better meeting. Of faces, the normal is sure but not the place, as their neighbours are nearly as good a
/// normal: a crossing that is no worse by much says where.
template <class real>
Meeting<real> meeting_offer(Meeting<real> best, real gap, Vec3<real> normal, u32 frame, Vec3<real> at_a,
                            Vec3<real> at_b, real tolerance) {
  if (gap > best.gap + (best.frame == NORMAL_FIXED && frame == NORMAL_FIXED ? real(0) : tolerance)) {
    best.gap = gap;
    best.normal = normal;
    best.frame = frame;
    best.at_a = at_a;
    best.at_b = at_b;
    best.crossing_gap = frame == NORMAL_FIXED ? gap : real(-1e30);
    best.crossing_normal = normal;
  } else if (frame == NORMAL_FIXED && gap > meeting_least(best, tolerance)) {
    best.at_a = at_a;
    best.at_b = at_b;
    best.crossing_gap = gap;
    best.crossing_normal = normal;
  }
  return best;
}

}  // namespace lockstep::reference
