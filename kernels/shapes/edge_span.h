// An edge of a polytope. cpu_reference/shapes/edge_span.hpp is the twin.
#ifndef LOCKSTEP_EDGE_SPAN_H
#define LOCKSTEP_EDGE_SPAN_H

#include "shapes/polytope.h"

// An edge in some frame, with the normals of the faces beside it.
typedef struct EdgeSpan {
  Vec3 start, along, left, right;
} EdgeSpan;

static inline EdgeSpan poly_own_edge(const Polytope* p, u32 e) {
  const HullEdge edge = poly_edge(p, e);
  EdgeSpan span;
  span.start = poly_own_vertex(p, edge.vertex_a);
  span.along = sub3(poly_own_vertex(p, edge.vertex_b), span.start);
  span.left = make3((real)0, (real)0, (real)0);
  span.right = span.left;
  if (p->faces > 0) {
    span.left = poly_own_normal(p, edge.face_left);
    span.right = poly_own_normal(p, edge.face_right);
  }
  return span;
}

#endif
