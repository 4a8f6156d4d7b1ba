// Which edges of two polytopes cross on the Gauss map, for LANES edges at once: arcs_cross of each, bit for bit.
#ifndef LOCKSTEP_EDGE_LANES_H
#define LOCKSTEP_EDGE_LANES_H

#include "lane_quads.h"
#include "shapes/edge_span.h"

#if LANES > 1

// A hull has at most 128 vertices (host/scene/hull.hpp), so at most 3 * 128 - 6 edges.
#define LANE_EDGES 384u

// The edges of a polytope in its own frame. Those behind the last one cross nothing.
typedef struct EdgeLanes {
  u32 count;
  real along[3][LANE_EDGES], left[3][LANE_EDGES], right[3][LANE_EDGES];
} EdgeLanes;

static inline void edge_lanes_put(EdgeLanes* edges, u32 e, Vec3 along, Vec3 left, Vec3 right) {
  edges->along[0][e] = along.x, edges->along[1][e] = along.y, edges->along[2][e] = along.z;
  edges->left[0][e] = left.x, edges->left[1][e] = left.y, edges->left[2][e] = left.z;
  edges->right[0][e] = right.x, edges->right[1][e] = right.y, edges->right[2][e] = right.z;
}

static inline void edge_lanes_of(EdgeLanes* edges, const Polytope* p) {
  const Vec3 none = make3((real)0, (real)0, (real)0);
  edges->count = p->edges;
  for (u32 e = 0u; e < p->edges; ++e) {
    const EdgeSpan span = poly_own_edge(p, e);
    edge_lanes_put(edges, e, span.along, span.left, span.right);
  }
  for (u32 e = p->edges; e % LANES != 0u; ++e) edge_lanes_put(edges, e, none, none, none);
}

LANE_INLINE lane edge_lanes_dot(const real (*v)[LANE_EDGES], u32 first, Vec3 w) {
  return LANE_LOAD(v[0] + first) * LANE_OF(w.x) + LANE_LOAD(v[1] + first) * LANE_OF(w.y) +
         LANE_LOAD(v[2] + first) * LANE_OF(w.z);
}

// Bit k: edge first + k of b.
static inline u32 arcs_crossing(const EdgeSpan* a, bool a_has_faces, const EdgeLanes* b, u32 first) {
  const lane zero = LANE_OF(0);
  const lane b_right = edge_lanes_dot(b->right, first, a->along), b_left = edge_lanes_dot(b->left, first, a->along);
  lane_mask cross = b_right * b_left < zero;
  if (a_has_faces) {
    const lane a_right = edge_lanes_dot(b->along, first, a->right), a_left = edge_lanes_dot(b->along, first, a->left);
    cross = cross & (a_right * a_left < zero) & (b_right * a_left < zero);
  }
  return LANE_BITS(cross);
}

#endif
#endif
