// Facets: the triangles of a surface, each a polytope of one face that knows what is around it, so that bodies slide
// over where facets meet as over one surface. cpu_reference/shapes/facet.hpp is the twin and says more.
#ifndef LOCKSTEP_FACET_H
#define LOCKSTEP_FACET_H

#include "shapes/edge_span.h"

// What a direction may be off being across an edge, or above a neighbour, as a sine.
#define FACET_SLACK ((real)1e-3)

#if FEATURE_FACETS
// Whether all that is around a corner falls away from a unit direction; where it does not stick out nothing does. At
// the rim of a surface only what comes from in front of it counts.
static inline bool corner_admits(const Polytope* p, Vec3 own, u32 vertex) {
  const bool at_rim = (p->flags & FACET_IS_AT_RIM(vertex)) != 0u;
  if (at_rim && dot3(own, poly_own_normal(p, 0u)) < -FACET_SLACK) return false;
  if ((p->flags & FACET_CORNER_COUNTS(vertex)) == 0u) return false;
  const u32 first = facet_next(p->tables, p->index, vertex);
  u32 at = first;
  do {  // all facets around the vertex
    global const Facet* facet = p->tables->facets + (at >> 2);
    const u32 k = at & 3u;
    const Vec3 corner = facet_vertex(facet, k);
    const Vec3 next = sub3(facet_vertex(facet, k == 2u ? 0u : k + 1u), corner);
    const Vec3 before = sub3(facet_vertex(facet, k == 0u ? 2u : k - 1u), corner);
    if (dot3(own, next) > FACET_SLACK * length3(next)) return false;
    if (dot3(own, before) > FACET_SLACK * length3(before)) return false;
    at = facet_next(p->tables, at >> 2, k);
  } while (at != first);
  return true;
}

// Whether the facets at an edge meet like a roof.
static inline bool is_roof(const EdgeSpan* edge) {
  return edge->left.x != edge->right.x || edge->left.y != edge->right.y || edge->left.z != edge->right.z;
}

// Whether a unit direction is across an edge and between the normals on both sides, where these meet like a roof.
CALLED bool edge_admits(const Polytope* p, u32 e, Vec3 own) {
  const EdgeSpan edge = poly_own_edge(p, e);
  const real along = dot3(own, edge.along), slack = FACET_SLACK * length3(edge.along);
  if (!is_roof(&edge) || along > slack || -along > slack) return false;
  return dot3(own, cross3(edge.along, edge.left)) > -slack && dot3(own, cross3(edge.right, edge.along)) > -slack;
}
#endif

// Whether a unit direction out of p, own coordinates, may be the normal of a contact other than with its inside.
CALLED bool facet_admits(const Polytope* p, Vec3 own) {
#if FEATURE_FACETS
  if (!p->facet) return true;
  const u32 vertex = poly_support(p, own), before = vertex == 0u ? 2u : vertex - 1u;
  return corner_admits(p, own, vertex) || edge_admits(p, vertex, own) || edge_admits(p, before, own);
#else
  return true;
#endif
}

// The same of both sides of a contact; the normal points from b to a, world.
static inline bool facets_admit(const Polytope* a, const Polytope* b, Vec3 normal) {
#if FEATURE_FACETS
  return facet_admits(a, into_frame(a->axes, scale3((real)-1, normal))) && facet_admits(b, into_frame(b->axes, normal));
#else
  return true;
#endif
}

#if FEATURE_FACETS
// Whether it is p that tells of a contact along a unit direction out of it, own coordinates, which yields or is nearly
// its normal.
static inline bool facet_tells(const Polytope* p, Vec3 own) {
  const Vec3 off = sub3(own, poly_own_normal(p, 0u));
  if (length3(off) < (real)2 * FACET_SLACK) return true;
  const u32 vertex = poly_support(p, own), before = vertex == 0u ? 2u : vertex - 1u;
  if (edge_admits(p, vertex, own)) return (p->flags & FACET_OWNS_EDGE(vertex)) != 0u;
  if (edge_admits(p, before, own)) return (p->flags & FACET_OWNS_EDGE(before)) != 0u;
  return (p->flags & FACET_OWNS_CORNER(vertex)) != 0u;
}

// Whether a facet holds what comes down on a point of it, own coordinates, and goes along `displacement` within the
// step, but for less than `margin`.
static inline bool facet_contains(const Polytope* p, Vec3 point, Vec3 displacement, real margin) {
  const Vec3 out = poly_own_normal(p, 0u);
  const real down = dot3(out, displacement);
  const bool falls = dot3(displacement, displacement) <= (real)2 * (down * down);
  bool contains = true;
  for (u32 e = 0u; e < 3u; ++e) {
    const EdgeSpan edge = poly_own_edge(p, e);
    const Vec3 side = cross3(out, edge.along);
    const real before = dot3(side, sub3(point, edge.start)), after = before + dot3(side, displacement);
    const real least = is_roof(&edge) ? margin * length3(edge.along) : (real)0;
    contains = contains && before >= least && (after >= least || (falls && !is_roof(&edge)));
  }
  return contains;
}
#endif

// Whether a face of p counts against a shape whose centre is at a height above it.
static inline bool facet_looks_at(const Polytope* p, real height) {
#if FEATURE_FACETS
  return !p->facet || height >= (real)0;
#else
  return true;
#endif
}

#endif
