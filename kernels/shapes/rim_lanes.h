// Where the rims of a cylinder are nearest to the edges of a polytope, LANES of them at once: rim_line of each, bit for
// bit.
#ifndef LOCKSTEP_RIM_LANES_H
#define LOCKSTEP_RIM_LANES_H

#include "lane_quads.h"
#include "shapes/cylinder.h"

#if LANES > 1

// An edge has four candidates: two rims, on each side of the point nearest to the axis.
#define RIM_CANDIDATES 4u
#define RIM_EDGES (LANES / RIM_CANDIDATES)

// Lane k stands for candidate k % 4 of edge k / 4: point + t along, |t| up to t_max.
typedef struct RimEdges {
  real point[3][LANES], along[3][LANES], t_max[LANES];
} RimEdges;

typedef struct RimLanes {
  u32 found;  // bits
  real normal[3][LANES], on_rim[3][LANES], on_other[3][LANES];
} RimLanes;

static inline void rim_edges_put(RimEdges* edges, u32 e, Vec3 point, Vec3 along, real t_max) {
  for (u32 k = RIM_CANDIDATES * e; k < RIM_CANDIDATES * (e + 1u); ++k) {
    edges->point[0][k] = point.x, edges->point[1][k] = point.y, edges->point[2][k] = point.z;
    edges->along[0][k] = along.x, edges->along[1][k] = along.y, edges->along[2][k] = along.z;
    edges->t_max[k] = t_max;
  }
}

LANE_INLINE Lane3 lane_all3(Vec3 v) { return lane_make3(LANE_OF(v.x), LANE_OF(v.y), LANE_OF(v.z)); }
LANE_INLINE Lane3 lane_load3(const real (*v)[LANES]) {
  return lane_make3(LANE_LOAD(v[0]), LANE_LOAD(v[1]), LANE_LOAD(v[2]));
}
LANE_INLINE void lane_store3(Lane3 v, real (*out)[LANES]) {
  LANE_STORE(v.x, out[0]);
  LANE_STORE(v.y, out[1]);
  LANE_STORE(v.z, out[2]);
}
LANE_INLINE Lane3 lane_cylinder_across(const Cylinder* c, Lane3 v) {
  const Lane3 x = lane_all3(c->axes.x), y = lane_all3(c->axes.y);
  return lane_add3(lane_scale3(lane_dot3(x, v), x), lane_scale3(lane_dot3(y, v), y));
}

static inline void rim_lanes(const Cylinder* c, const RimEdges* edges, RimLanes* nearest) {
  const lane zero = LANE_OF(0), one = LANE_OF(1), radius = LANE_OF(c->radius);
  real ends[LANES], senses[LANES];
  for (u32 k = 0u; k < LANES; ++k) {
    ends[k] = (real)(k >> 1 & 1u);
    senses[k] = (k & 1u) == 0u ? (real)-1 : (real)1;
  }
  const lane sense = LANE_LOAD(senses);
  const lane_mask upper = LANE_LOAD(ends) > zero, before = sense < zero;
  const Lane3 middle = lane_select3(upper, lane_all3(cylinder_cap(c, 1)), lane_all3(cylinder_cap(c, 0)));
  const Lane3 point = lane_load3(edges->point), u = lane_load3(edges->along), w = lane_sub3(point, middle);
  const lane t_max = LANE_LOAD(edges->t_max);
  const Lane3 w_across = lane_cylinder_across(c, w), u_across = lane_cylinder_across(c, u);
  const lane a = lane_dot3(u_across, u_across), start = lane_dot3(w, u);
  const lane bound = radius * sqrt(a);
  lane t = sense * bound - start;
  const lane_mask leans = a > LANE_OF(1e-12);
  const lane closest = leans ? -lane_dot3(w_across, u_across) / a : t;
  lane_mask found = leans ? sense * (t - closest) > zero : !before;
  lane_mask active = leans & found;
  for (u32 k = 0u; k < RIM_STEPS && LANE_ANY(active); ++k) {
    const Lane3 across = lane_add3(w_across, lane_scale3(t, u_across));
    const lane square = lane_dot3(across, across), rho = sqrt(square);
    active = active & (rho > zero);
    const lane sigma = lane_dot3(across, u_across) / rho;
    const lane slope = one - radius * (a - sigma * sigma) / rho;
    const lane_mask past = active & !(slope > zero);
    found = found & !past;
    active = active & !past;
    const lane next = t - (start + t - radius * sigma) / slope;
    const lane_mask passed = !(sense * (next - closest) > zero);
    const lane_mask stays = next == t;
    t = active ? (passed ? closest : next) : t;
    active = active & !passed & !stays;
  }
  found = found & (t > LANE_OF(-0.001) * t_max) & (t < LANE_OF(1.001) * t_max);
  const Lane3 across = lane_add3(w_across, lane_scale3(t, u_across));
  const lane rho = lane_length3(across);
  const lane left = start + t - radius * lane_dot3(across, u_across) / rho;
  found = found & (rho > zero) & (left < LANE_OF(1e-3) * radius) & (left > LANE_OF(-1e-3) * radius);
  const Lane3 on_rim = lane_add3(middle, lane_scale3(radius / rho, across));
  const lane inside = t < zero ? zero : (t > t_max ? t_max : t);
  const Lane3 tangent = lane_cross3(lane_all3(c->axes.z), across), on_other = lane_add3(point, lane_scale3(inside, u));
  const Lane3 between = lane_sub3(on_rim, on_other);
  const lane least_sine = lane_length3(between) > LANE_OF(0.1) * radius ? LANE_OF(0.05) : LANE_OF(1e-3);
  Lane3 normal = lane_cross3(tangent, u);
  const lane_mask crosses = lane_length3(normal) > least_sine * lane_length3(tangent) * lane_length3(u);
  normal = lane_select3(crosses, normal, between);
  const lane length = lane_length3(normal);
  nearest->found = LANE_BITS(found & (length > zero));
  lane_store3(lane_scale3(one / length, normal), nearest->normal);
  lane_store3(on_rim, nearest->on_rim);
  lane_store3(on_other, nearest->on_other);
}

static inline Vec3 rim_component(const real (*v)[LANES], u32 k) { return make3(v[0][k], v[1][k], v[2][k]); }

#endif
#endif
