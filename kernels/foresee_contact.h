// Where contacts of LANES pairs will be within the sub-step. cpu_reference/foresee_contact.hpp is the twin and states
// the law.
#ifndef LOCKSTEP_FORESEE_CONTACT_H
#define LOCKSTEP_FORESEE_CONTACT_H

#include "lane_current_contact.h"

#define RIM_FORESIGHT ((real)0.5)

// Where the body of a lane cannot be pushed and rotates.
static inline lane_mask lane_rotates_by_itself(const LaneBody* body) {
  return (body->inverse_mass == (lane)0) & (lane_dot3(body->w, body->w) > (lane)0);
}

// One side of the contacts: its bodies at the start of the sub-step, and the axes of rims, world frame, or 0.
typedef struct LaneForeseenSide {
  LanePose pose;
  Lane3 v, w, axis;
} LaneForeseenSide;

static inline LanePose lane_predicted_pose(const LanePose* pose, Lane3 v, Lane3 w, lane time) {
  LanePose predicted;
  predicted.position = lane_add3(pose->position, lane_scale3(time, v));
  predicted.orientation = lane_correct_orientation(pose->orientation, lane_scale3(time, w));
  return predicted;
}

// What rotates by itself carries its contact, with the velocities of the start.
static inline void lane_predict_arms(const StepParams* p, u32 first, global const PointBlock* points, lane_mask carried,
                                     const LaneForeseenSide* a, const LaneForeseenSide* b,
                                     LaneCurrentContact* current) {
  const lane_mask moved = carried & LANE_MASK(LANE_LOAD_U32(points->frame + first) != (lane_u32)NORMAL_OF_IMPACT);
  if (!(p->theta > (real)0) || !LANE_ANY(moved)) return;
  const lane time = (lane)((real)0.5 * p->dt / p->theta);
  const LanePose pose_a = lane_predicted_pose(&a->pose, a->v, a->w, time);
  const LanePose pose_b = lane_predicted_pose(&b->pose, b->v, b->w, time);
  LaneCurrentContact predicted;
  lane_current_contact(first, points, &pose_a, &pose_b, &predicted);
  current->arm_a = lane_select3(moved, predicted.arm_a, current->arm_a);
  current->arm_b = lane_select3(moved, predicted.arm_b, current->arm_b);
}

#if FEATURE_SEPARATED_CONTACTS

#if FEATURE_CYLINDERS
static inline void lane_set_rim_axes(u32 first, global const RimBlock* rims, LaneForeseenSide* a, LaneForeseenSide* b) {
  a->axis = lane_rotate3(a->pose.orientation,
                         lane_load_xyz(rims->axis_a_x + first, rims->axis_a_y + first, rims->axis_a_z + first));
  b->axis = lane_rotate3(b->pose.orientation,
                         lane_load_xyz(rims->axis_b_x + first, rims->axis_b_y + first, rims->axis_b_z + first));
}
#endif

// The angular velocity that takes the point of a contact along.
static inline Lane3 lane_contact_rotation(const LaneForeseenSide* side, Lane3 normal, lane step) {
#if FEATURE_CYLINDERS
  const lane along = lane_dot3(side->axis, side->w), cosine = lane_dot3(side->axis, normal);
  const lane square = (lane)1 - cosine * cosine;
  const lane runs = cosine * (lane_dot3(normal, side->w) - cosine * along) / square;
  const lane_mask follows = (square > (lane)0) & (fabs(step * runs) < (lane)RIM_FORESIGHT);
  return lane_add3(side->w, lane_scale3((follows ? runs : (lane)0) - along, side->axis));
#else
  return side->w;
#endif
}

static inline void lane_contact_after(u32 first, global const PointBlock* points, const LaneForeseenSide* a,
                                      const LaneForeseenSide* b, Lane3 normal, lane step, lane time,
                                      LaneCurrentContact* after) {
  const LanePose pose_a = lane_predicted_pose(&a->pose, a->v, lane_contact_rotation(a, normal, step), time);
  const LanePose pose_b = lane_predicted_pose(&b->pose, b->v, lane_contact_rotation(b, normal, step), time);
  lane_current_contact(first, points, &pose_a, &pose_b, after);
}

#endif

#endif
