// Boxes against spheres and planes, LANES pairs at once: box_round.h of each, bit for bit.
#ifndef LOCKSTEP_BOX_ROUND_LANES_H
#define LOCKSTEP_BOX_ROUND_LANES_H

#include "lane_sides.h"

LANE_INLINE lane lane_sign_of(lane x) { return x < LANE_OF(0) ? LANE_OF(-1) : LANE_OF(1); }

// The first where the first mask is set, the second where the second is, else the third.
LANE_INLINE lane lane_pick(lane_mask first, lane_mask second, lane a, lane b, lane c) {
  return first ? a : (second ? b : c);
}

// As sphere_box.
LANE_INLINE void lane_sphere_box(const LaneSide* sphere, const LaneSide* box, LaneManifold* m) {
  const lane zero = LANE_OF(0);
  const Lane3 h = box->size;
  const LaneAxes axes = lane_axes_of(box->rotation);
  const Lane3 p = lane_into_frame(axes, lane_sub3(sphere->center, box->center)), far = lane_absolute3(p);
  const lane_mask out_x = far.x > h.x, out_y = far.y > h.y, out_z = far.z > h.z;
  const lane_mask beside = (out_x & out_y) | (out_x & out_z) | (out_y & out_z);
  // over an edge or a corner
  const Lane3 inside = lane_make3(lane_clamp_to(p.x, h.x), lane_clamp_to(p.y, h.y), lane_clamp_to(p.z, h.z));
  const Lane3 core = lane_add3(box->center, lane_out_of_frame(axes, inside));
  const Lane3 d = lane_sub3(sphere->center, core);
  const lane distance = lane_length3(d);
  const lane_mask is_outside = distance > zero;
  const Lane3 between = lane_make3(is_outside ? d.x / distance : axes.z.x, is_outside ? d.y / distance : axes.z.y,
                                   is_outside ? d.z / distance : axes.z.z);
  // over a face, or inside
  const lane x = far.x - h.x, y = far.y - h.y, z = far.z - h.z;
  const lane_mask past_x = y > x, on_z = z > (past_x ? y : x);
  const lane_mask on_y = past_x & !on_z, on_x = !(on_y | on_z);
  const lane side = lane_sign_of(lane_pick(on_x, on_y, p.x, p.y, p.z));
  const Lane3 up = lane_make3(on_x ? side : zero, on_y ? side : zero, on_z ? side : zero);
  const Lane3 foot = lane_make3(on_x ? side * h.x : p.x, on_y ? side * h.y : p.y, on_z ? side * h.z : p.z);
  const Lane3 normal = lane_out_of_frame(axes, up), on_face = lane_add3(box->center, lane_out_of_frame(axes, foot));
  m->normal = lane_make3(beside ? between.x : normal.x, beside ? between.y : normal.y, beside ? between.z : normal.z);
  const lane_mask at_corner = out_x & out_y & out_z;
  m->frame = at_corner ? LANE_OF(NORMAL_BETWEEN) : (beside ? LANE_OF(NORMAL_FIXED) : LANE_OF(NORMAL_OF_B));
  m->radius_a = sphere->size.x;
  m->radius_b = zero;
  m->anchor_a[0] = sphere->center;
  m->anchor_b[0] = lane_make3(beside ? core.x : on_face.x, beside ? core.y : on_face.y, beside ? core.z : on_face.z);
  m->feature[0] = zero;
}

// As box_plane.
LANE_INLINE void lane_box_plane(const LaneSide* box, const LaneSide* plane, LaneManifold* m) {
  const lane zero = LANE_OF(0), one = LANE_OF(1);
  const Lane3 h = box->size;
  const LaneAxes axes = lane_axes_of(box->rotation);
  m->normal = lane_rotate3(plane->rotation, lane_make3(zero, zero, one));
  m->frame = LANE_OF(NORMAL_OF_B);
  m->radius_a = m->radius_b = zero;
  const Lane3 n = lane_into_frame(axes, m->normal), steep = lane_absolute3(n);
  const lane_mask past_x = steep.y > steep.x, on_z = steep.z > (past_x ? steep.y : steep.x);
  const lane_mask on_y = past_x & !on_z, on_x = !(on_y | on_z);
  const lane down = -lane_sign_of(lane_pick(on_x, on_y, n.x, n.y, n.z));
  for (u32 corner = 0u; corner < 4u; ++corner) {
    const lane side_1 = corner == 1u || corner == 2u ? one : -one, side_2 = corner >= 2u ? one : -one;
    const Lane3 p =
        lane_make3(lane_pick(on_x, on_z, down, side_1, side_2) * h.x, lane_pick(on_y, on_x, down, side_1, side_2) * h.y,
                   lane_pick(on_z, on_y, down, side_1, side_2) * h.z);
    m->anchor_a[corner] = lane_add3(box->center, lane_out_of_frame(axes, p));
    m->anchor_b[corner] = plane->center;
    m->feature[corner] =
        (p.x > zero ? one : zero) + (p.y > zero ? LANE_OF(2) : zero) + (p.z > zero ? LANE_OF(4) : zero);
  }
}

// As flip.
LANE_INLINE void lane_flip(LaneManifold* m, u32 points) {
  const lane_mask of_a = m->frame == LANE_OF(NORMAL_OF_A), of_b = m->frame == LANE_OF(NORMAL_OF_B);
  m->normal = lane_scale3(LANE_OF(-1), m->normal);
  const lane_mask fixed = m->frame == LANE_OF(NORMAL_FIXED), fixed_on_b = m->frame == LANE_OF(NORMAL_FIXED_ON_B);
  m->frame = of_a ? LANE_OF(NORMAL_OF_B) : (of_b ? LANE_OF(NORMAL_OF_A) : m->frame);
  m->frame = fixed ? LANE_OF(NORMAL_FIXED_ON_B) : (fixed_on_b ? LANE_OF(NORMAL_FIXED) : m->frame);
  const lane radius = m->radius_a;
  m->radius_a = m->radius_b;
  m->radius_b = radius;
  for (u32 k = 0u; k < points; ++k) {
    const Lane3 anchor = m->anchor_a[k];
    m->anchor_a[k] = m->anchor_b[k];
    m->anchor_b[k] = anchor;
  }
}

#endif
