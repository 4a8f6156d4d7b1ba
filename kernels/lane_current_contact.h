// Contacts of LANES pairs at poses of their bodies. cpu_reference/current_contact.hpp is the twin.
#ifndef LOCKSTEP_LANE_CURRENT_CONTACT_H
#define LOCKSTEP_LANE_CURRENT_CONTACT_H

#include "lane_quads.h"
#include "solve_contact.h"
#include "types.h"

typedef struct LanePose {
  Lane3 position;
  LaneQuat orientation;
} LanePose;

// Padding lanes read the pose of the first lane, which pairs fill first: any other body may be moved by another item.
// Items of padding alone read that of the last body.
static inline LanePose lane_load_poses(global const u32* bodies, u32 body_count, global const Vec4* positions,
                                       global const Vec4* orientations) {
  u32 indices[LANES];
  for (u32 k = 0u; k < LANES; ++k) indices[k] = bodies[k] < body_count ? bodies[k] : min(bodies[0], body_count - 1u);
  LanePose pose;
  pose.position = lane_xyz(lane_gather_quad((global const real*)positions, 4u, indices));
  pose.orientation = lane_quat(lane_gather_quad((global const real*)orientations, 4u, indices));
  return pose;
}

// As correct_orientation.
static inline LaneQuat lane_correct_orientation(LaneQuat orientation, Lane3 angle) {
  const Lane3 z = lane_scale3((lane)0.5, angle);
  const LaneQuat half_rotation = {z.x, z.y, z.z, (lane)1};
  LaneQuat q = lane_multiply4(half_rotation, orientation);
  const lane s = (lane)1 / sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  q.x = s * q.x;
  q.y = s * q.y;
  q.z = s * q.z;
  q.w = s * q.w;
  return q;
}

// The contacts of a row at the current poses.
typedef struct LaneCurrentContact {
  Lane3 normal;
  lane gap;
  Lane3 arm_a, arm_b;
} LaneCurrentContact;

static inline void lane_current_contact(u32 first, global const PointBlock* points, const LanePose* a,
                                        const LanePose* b, LaneCurrentContact* current) {
  const lane_u32 frame = LANE_LOAD_U32(points->frame + first);
  const lane_mask of_a = LANE_MASK(frame == (lane_u32)NORMAL_OF_A), of_b = LANE_MASK(frame == (lane_u32)NORMAL_OF_B);
  const lane_mask is_between = LANE_MASK(frame == (lane_u32)NORMAL_BETWEEN);
  const lane radius_a = LANE_LOAD(points->radius_a + first), radius_b = LANE_LOAD(points->radius_b + first);
  const Lane3 anchor_a =
      lane_rotate3(a->orientation,
                   lane_load_xyz(points->anchor_a_x + first, points->anchor_a_y + first, points->anchor_a_z + first));
  const Lane3 anchor_b =
      lane_rotate3(b->orientation,
                   lane_load_xyz(points->anchor_b_x + first, points->anchor_b_y + first, points->anchor_b_z + first));
  const Lane3 offset_ab = lane_sub3(a->position, b->position);
  const Lane3 d = lane_sub3(lane_add3(offset_ab, anchor_a), anchor_b);
  const lane distance = lane_length3(d);

  const Lane3 kept = LANE_NORMAL(points, first);
  LaneQuat orientation;
  orientation.x = of_a ? a->orientation.x : b->orientation.x;
  orientation.y = of_a ? a->orientation.y : b->orientation.y;
  orientation.z = of_a ? a->orientation.z : b->orientation.z;
  orientation.w = of_a ? a->orientation.w : b->orientation.w;
  current->normal = lane_select3(of_a | of_b, lane_rotate3(orientation, kept), kept);
  if (LANE_ANY(is_between)) {
    current->normal = lane_select3(is_between & (distance > (lane)0),
                                   lane_make3(d.x / distance, d.y / distance, d.z / distance), current->normal);
  }
  current->gap = (is_between ? distance : lane_dot3(current->normal, d)) - radius_a - radius_b;

  const lane_mask fixed_on_b = LANE_MASK(frame == (lane_u32)NORMAL_FIXED_ON_B), on_b = of_a | fixed_on_b;
  const lane depth_a = of_b ? radius_a : radius_a + (lane)0.5 * current->gap;
  const lane depth_b = fixed_on_b ? radius_b + (lane)0.5 * current->gap : radius_b;
  const Lane3 end_b = lane_add3(anchor_b, lane_scale3(depth_b, current->normal));
  const Lane3 end_a = lane_sub3(anchor_a, lane_scale3(depth_a, current->normal));
  current->arm_a = lane_select3(on_b, lane_sub3(end_b, offset_ab), end_a);
  current->arm_b = lane_select3(on_b, end_b, lane_add3(end_a, offset_ab));
#if FEATURE_CONTINUOUS || FEATURE_BOXES
  const lane_mask of_impact = LANE_MASK(frame == (lane_u32)NORMAL_OF_IMPACT);
  current->arm_a = lane_select3(of_impact, lane_sub3(anchor_a, lane_scale3(radius_a, current->normal)), current->arm_a);
  current->arm_b = lane_select3(of_impact, end_b, current->arm_b);
#endif
}

#endif
