// An edge of a polytope. kernels/shapes/edge_span.h is the twin.
#pragma once

#include "cpu_reference/shapes/polytope.hpp"

namespace lockstep::reference {

/// An edge in some frame, with the normals of the faces beside it.
template <class real>
struct EdgeSpan {
  Vec3<real> start, along, left, right;
};

template <class real>
EdgeSpan<real> poly_own_edge(const Polytope<real>& p, u32 e) {
  const HullEdge edge = poly_edge(p, e);
  EdgeSpan<real> span;
  span.start = poly_own_vertex(p, edge.vertex_a);
  span.along = sub3(poly_own_vertex(p, edge.vertex_b), span.start);
  span.left = Vec3<real>{0, 0, 0};
  span.right = span.left;
  if (p.faces > 0) {
    span.left = poly_own_normal(p, edge.face_left);
    span.right = poly_own_normal(p, edge.face_right);
  }
  return span;
}

}  // namespace lockstep::reference
