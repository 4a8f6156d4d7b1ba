// Facets: the triangles of a surface, each a polytope of one face that knows what is around it, so that bodies slide
// over where facets meet as over one surface. kernels/shapes/facet.h is the twin.
//
// A direction is the normal of a contact with a surface only where the surface does not rise on the other side of it:
// the normal of a facet over its inside, what is between the normals of two facets at an edge where they meet like a
// roof, and at a corner that sticks out what all that is around it falls away from. All facets there know it; one of
// them, whose own the edge or the corner is, tells of the contact. Where a surface ends, directions past its rim count.
// Surfaces have one side: a facet's normal does not count against shapes whose centre is behind it. What only is on its
// way to the inside of a facet, the facet tells beside that.
#pragma once

#include "cpu_reference/shapes/edge_span.hpp"

namespace lockstep::reference {

/// What a direction may be off being across an edge, or above a neighbour, as a sine.
template <class real>
inline constexpr real facet_slack = real(1e-3);

/// Whether all that is around a corner falls away from a unit direction; where it does not stick out nothing does. At
/// the rim of a surface only what comes from in front of it counts.
template <class real>
bool corner_admits(const Polytope<real>& p, Vec3<real> own, u32 vertex) {
  const bool at_rim = (p.flags & FACET_IS_AT_RIM(vertex)) != 0;
  if (at_rim && dot3(own, poly_own_normal(p, 0)) < -facet_slack<real>) return false;
  if ((p.flags & FACET_CORNER_COUNTS(vertex)) == 0) return false;
  const u32 first = facet_next(p.tables, p.index, vertex);
  u32 at = first;
  do {  // all facets around the vertex
    const Facet<real>& facet = p.tables.facets[at >> 2];
    const u32 k = at & 3;
    const Vec3<real> corner = facet_vertex(facet, k);
    const Vec3<real> next = sub3(facet_vertex(facet, k == 2 ? 0 : k + 1), corner);
    const Vec3<real> before = sub3(facet_vertex(facet, k == 0 ? 2 : k - 1), corner);
    if (dot3(own, next) > facet_slack<real> * length3(next)) return false;
    if (dot3(own, before) > facet_slack<real> * length3(before)) return false;
    at = facet_next(p.tables, at >> 2, k);
  } while (at != first);
  return true;
}

/// Whether the facets at an edge meet like a roof.
template <class real>
bool is_roof(const EdgeSpan<real>& edge) {
  return edge.left.x != edge.right.x || edge.left.y != edge.right.y || edge.left.z != edge.right.z;
}

/// Whether a unit direction is across an edge and between the normals on both sides, where these meet like a roof.
template <class real>
bool edge_admits(const Polytope<real>& p, u32 e, Vec3<real> own) {
  const EdgeSpan<real> edge = poly_own_edge(p, e);
  const real along = dot3(own, edge.along), slack = facet_slack<real> * length3(edge.along);
  if (!is_roof(edge) || along > slack || -along > slack) return false;
  return dot3(own, cross3(edge.along, edge.left)) > -slack && dot3(own, cross3(edge.right, edge.along)) > -slack;
}

/// Whether a unit direction out of p, own coordinates, may be the normal of a contact other than with its inside.
template <class real>
bool facet_admits(const Polytope<real>& p, Vec3<real> own) {
  if (!p.facet) return true;
  const u32 vertex = poly_support(p, own), before = vertex == 0 ? 2 : vertex - 1;
  return corner_admits(p, own, vertex) || edge_admits(p, vertex, own) || edge_admits(p, before, own);
}

/// The same of both sides of a contact; the normal points from b to a, world.
template <class real>
bool facets_admit(const Polytope<real>& a, const Polytope<real>& b, Vec3<real> normal) {
  return facet_admits(a, into_frame(a.axes, scale3(real(-1), normal))) && facet_admits(b, into_frame(b.axes, normal));
}

/// Whether it is p that tells of a contact along a unit direction out of it, own coordinates, which yields or is nearly
/// its normal.
template <class real>
bool facet_tells(const Polytope<real>& p, Vec3<real> own) {
  const Vec3<real> off = sub3(own, poly_own_normal(p, 0));
  if (length3(off) < real(2) * facet_slack<real>) return true;
  const u32 vertex = poly_support(p, own), before = vertex == 0 ? 2 : vertex - 1;
  if (edge_admits(p, vertex, own)) return (p.flags & FACET_OWNS_EDGE(vertex)) != 0;
  if (edge_admits(p, before, own)) return (p.flags & FACET_OWNS_EDGE(before)) != 0;
  return (p.flags & FACET_OWNS_CORNER(vertex)) != 0;
}

/// Whether a facet holds what comes down on a point of it, own coordinates, and goes along `displacement` within the
/// step, but for less than `margin`: it is over the inside, and does not leave. What leaves over an edge like a roof is
/// held by another facet, if by any; over another edge there may be such a one next, and only what falls more than it
/// goes along counts.
template <class real>
bool facet_contains(const Polytope<real>& p, Vec3<real> point, Vec3<real> displacement, real margin) {
  const Vec3<real> out = poly_own_normal(p, 0);
  const real down = dot3(out, displacement);
  const bool falls = dot3(displacement, displacement) <= real(2) * (down * down);
  bool contains = true;
  for (u32 e = 0; e < 3; ++e) {
    const EdgeSpan<real> edge = poly_own_edge(p, e);
    const Vec3<real> side = cross3(out, edge.along);
    const real before = dot3(side, sub3(point, edge.start)), after = before + dot3(side, displacement);
    const real least = is_roof(edge) ? margin * length3(edge.along) : real(0);
    contains = contains && before >= least && (after >= least || (falls && !is_roof(edge)));
  }
  return contains;
}

/// Whether a face of p counts against a shape whose centre is at a height above it.
template <class real>
bool facet_looks_at(const Polytope<real>& p, real height) {
  return !p.facet || height >= 0;
}

}  // namespace lockstep::reference
