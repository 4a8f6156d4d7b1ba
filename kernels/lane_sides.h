// The sides of LANES pairs at once, and the way of their points into the lists: what collide.cl does for one pair, bit
// for bit.
#ifndef LOCKSTEP_LANE_SIDES_H
#define LOCKSTEP_LANE_SIDES_H

#include "found_contacts.h"
#include "grid.h"
#include "lane_quads.h"
#include "tolerance_shares.h"

// A point that is not there has no feature; features are small whole numbers held as reals.
#define LANE_NO_FEATURE 1000

// One side of LANES pairs.
typedef struct LaneSide {
  Lane3 center, size;    // of the shape, the centre seen from that of a
  LaneQuat rotation;     // of the shape
  LaneQuat orientation;  // of the body
  Lane3 offset, arm;     // from the centre of mass to the centre of the shape: body frame, world axes
  Lane3 position, v, w;
  lane bounding_radius, inner_radius, inverse_mass;
} LaneSide;

typedef struct LaneSides {
  LaneSide a, b;
  Lane3 offset_ab;  // of the centres of mass, from b to a
} LaneSides;

// Up to four points of one normal.
typedef struct LaneManifold {
  Lane3 normal, anchor_a[4], anchor_b[4];
  lane frame, feature[4], radius_a, radius_b;
} LaneManifold;

// Where the sides of pairs are read.
typedef struct SideTables {
  global const Shape* shapes;
  global const Vec4 *positions, *orientations;
  global const Motion* motions;
  global const u32* seam_starts;
} SideTables;

// Whose sides they are.
typedef struct LanePairs {
  u32 pair[LANES], shape_a[LANES], shape_b[LANES], body_a[LANES], body_b[LANES];
} LanePairs;

LANE_INLINE void lane_side(LaneSide* side, const SideTables* t, const u32* shape, const u32* body) {
  const u32 shape_stride = sizeof(Shape) / sizeof(real), motion_stride = sizeof(Motion) / sizeof(real);
  const LaneQuad offset = lane_gather_quad(t->shapes->offset, shape_stride, shape);
  side->offset = lane_xyz(offset);
  side->bounding_radius = offset.w;
  side->orientation = lane_quat(lane_gather_quad(&t->orientations->x, 4u, body));
  side->arm = lane_rotate3(side->orientation, side->offset);
  side->rotation =
      lane_multiply4(side->orientation, lane_quat(lane_gather_quad(t->shapes->rotation, shape_stride, shape)));
  const LaneQuad size = lane_gather_quad(t->shapes->size, shape_stride, shape);
  side->size = lane_xyz(size);
  side->inner_radius = size.w;
  side->position = lane_xyz(lane_gather_quad(&t->positions->x, 4u, body));
  const LaneQuad v = lane_gather_quad(t->motions->v, motion_stride, body);
  side->v = lane_xyz(v);
  side->inverse_mass = v.w;
  side->w = lane_xyz(lane_gather_quad(t->motions->w, motion_stride, body));
}

LANE_INLINE void lane_sides(LaneSides* s, const SideTables* tables, const LanePairs* pairs) {
  lane_side(&s->a, tables, pairs->shape_a, pairs->body_a);
  lane_side(&s->b, tables, pairs->shape_b, pairs->body_b);
  s->offset_ab = lane_sub3(s->a.position, s->b.position);
  s->a.center = lane_make3(LANE_OF(0), LANE_OF(0), LANE_OF(0));
  s->b.center = lane_sub3(s->b.arm, lane_add3(s->a.arm, s->offset_ab));
}

LANE_INLINE Lane3 lane_point_velocity(const LaneSide* side, Lane3 arm) {
  return lane_add3(side->v, lane_cross3(side->w, arm));
}

// As own_margin and collide_margin.
LANE_INLINE lane lane_own_margin(const StepParams* params, const LaneSide* side) {
  const lane share = LANE_OF(params->margin_share) * side->bounding_radius;
  return share < side->inner_radius ? share : side->inner_radius;
}
LANE_INLINE lane lane_displacement(const StepParams* params, const LaneSide* side) {
  const lane displacement = LANE_OF(step_length(params)) * (lane_length3(lane_point_velocity(side, side->arm)) +
                                                            lane_length3(side->w) * side->bounding_radius);
  return side->inverse_mass > LANE_OF(0) ? displacement : LANE_OF(0);
}
LANE_INLINE lane lane_margin(const StepParams* params, const LaneSides* s) {
  const lane a = lane_own_margin(params, &s->a), b = lane_own_margin(params, &s->b);
  const lane smaller = a < b ? a : b, larger = a < b ? b : a, own = smaller > LANE_OF(0) ? smaller : larger;
  const lane used =
      LANE_OF((real)MARGIN_AT_REST) * own +
      LANE_OF((real)MARGIN_OF_MOTION) * (lane_displacement(params, &s->a) + lane_displacement(params, &s->b));
  return LANE_OF(params->margin) + (used < own ? used : own);
}

// As collide_limit.
LANE_INLINE lane lane_limit(const StepParams* params, const LaneSides* s) {
  const Lane3 arm_b = lane_add3(s->a.arm, s->offset_ab);
  const Lane3 v = lane_sub3(lane_point_velocity(&s->b, arm_b), lane_point_velocity(&s->a, s->a.arm));
  const Lane3 w = lane_sub3(s->b.w, s->a.w);
  return lane_margin(params, s) +
         LANE_OF(step_length(params)) * (lane_length3(v) + lane_length3(w) * s->a.bounding_radius);
}

// As collide_keep: leaves out points that are out of range; anchors of b are seen from its own centre.
LANE_INLINE void lane_keep(const StepParams* params, const LaneSides* s, LaneManifold* m, u32 points) {
  const lane h = LANE_OF(step_length(params)), zero = LANE_OF(0), margin = lane_margin(params, s);
  const Lane3 inwards = lane_scale3(m->radius_a, m->normal);
  for (u32 k = 0u; k < points; ++k) {
    const Lane3 arm = lane_add3(s->a.arm, lane_sub3(m->anchor_a[k], inwards));
    const Lane3 u =
        lane_sub3(lane_point_velocity(&s->b, lane_add3(arm, s->offset_ab)), lane_point_velocity(&s->a, arm));
    const lane approach = lane_dot3(m->normal, u), speed = approach > zero ? approach : zero;
    const lane gap = lane_dot3(m->normal, lane_sub3(m->anchor_a[k], m->anchor_b[k])) - m->radius_a - m->radius_b;
    m->feature[k] = gap <= margin + h * speed ? m->feature[k] : LANE_OF(LANE_NO_FEATURE);
    m->anchor_b[k] = lane_sub3(m->anchor_b[k], s->b.center);
  }
}

#define LANE_SWAP(mask, x, y)         \
  {                                   \
    const lane first_ = mask ? y : x; \
    y = mask ? x : y;                 \
    x = first_;                       \
  }
#define LANE_SWAP3(mask, a, b) LANE_SWAP(mask, a.x, b.x) LANE_SWAP(mask, a.y, b.y) LANE_SWAP(mask, a.z, b.z)

// Puts the points k and k + 1 into the order of their features.
LANE_INLINE void lane_order(LaneManifold* m, u32 k) {
  const lane_mask swap = m->feature[k] > m->feature[k + 1u];
  LANE_SWAP(swap, m->feature[k], m->feature[k + 1u])
  LANE_SWAP3(swap, m->anchor_a[k], m->anchor_a[k + 1u])
  LANE_SWAP3(swap, m->anchor_b[k], m->anchor_b[k + 1u])
}

// The points that are there, ordered by feature, in the frames of the bodies, for the first `members` lanes. Lanes are
// turned into records by transpositions; a record that is not full ends in what is left of other points.
LANE_INLINE void lane_store_found(const LaneSides* s, LaneManifold* m, u32 points, const LanePairs* pairs, u32 members,
                                  global const BodyInfo* body_infos, global FoundContacts* found_contacts,
                                  global u32* contact_starts) {
  if (points == 4u) {
    lane_order(m, 0u), lane_order(m, 2u), lane_order(m, 1u);
    lane_order(m, 0u), lane_order(m, 2u), lane_order(m, 1u);
  }
  const lane zero = LANE_OF(0), one = LANE_OF(1);
  const lane_mask of_a = m->frame == LANE_OF(NORMAL_OF_A), of_b = m->frame == LANE_OF(NORMAL_OF_B);
  LaneQuat frame;
  frame.x = of_b ? s->b.orientation.x : s->a.orientation.x;
  frame.y = of_b ? s->b.orientation.y : s->a.orientation.y;
  frame.z = of_b ? s->b.orientation.z : s->a.orientation.z;
  frame.w = of_b ? s->b.orientation.w : s->a.orientation.w;
  const Lane3 normal_in_body = lane_rotate3(lane_back(frame), m->normal);
  const LaneQuad normal = {of_a | of_b ? normal_in_body.x : m->normal.x, of_a | of_b ? normal_in_body.y : m->normal.y,
                           of_a | of_b ? normal_in_body.z : m->normal.z, zero};
  real normals[4 * LANES], features[4 * LANES], frames[LANES], counts[LANES], halves[8][4 * LANES];
  lane_keep_quad(normal, normals);
  LANE_STORE(m->frame, frames);
  const LaneQuat back_a = lane_back(s->a.orientation), back_b = lane_back(s->b.orientation);
  lane count = zero;
  for (u32 k = 0u; k < points; ++k) {
    const Lane3 a = lane_add3(s->a.offset, lane_rotate3(back_a, m->anchor_a[k]));
    const Lane3 b = lane_add3(s->b.offset, lane_rotate3(back_b, m->anchor_b[k]));
    const LaneQuad half_a = {a.x, a.y, a.z, m->radius_a}, half_b = {b.x, b.y, b.z, m->radius_b};
    lane_keep_quad(half_a, halves[2u * k]);
    lane_keep_quad(half_b, halves[2u * k + 1u]);
    count = count + (m->feature[k] < LANE_OF(LANE_NO_FEATURE) ? one : zero);
  }
  const LaneQuad names = {m->feature[0], points == 4u ? m->feature[1] : zero, points == 4u ? m->feature[2] : zero,
                          points == 4u ? m->feature[3] : zero};
  lane_keep_quad(names, features);
  LANE_STORE(count, counts);
  for (u32 l = 0u; l < members; ++l) {
    const u32 p = pairs->pair[l];
    contact_starts[p] = (u32)counts[l];
    if (!(counts[l] > (real)0)) continue;
    global FoundContacts* found = found_contacts + p;
    for (u32 k = 0u; k < points; ++k) {
      vstore4(lane_kept_quad(halves[2u * k], l), 0, found->points[k]);
      vstore4(lane_kept_quad(halves[2u * k + 1u], l), 0, found->points[k] + 4);
    }
    vstore4(lane_kept_quad(normals, l), 0, found->normal);
    vstore4(convert_uint4(lane_kept_quad(features, l)), 0, found->features);
    const Pair pair = {pairs->shape_a[l], pairs->shape_b[l]};
    found->contact =
        found_contact(pair, pairs->body_a[l], pairs->body_b[l], body_infos[pairs->body_a[l]].world, (u32)frames[l]);
  }
}

#endif
