// What math.h says of one vector, quaternion or frame, for one in each lane: the same operations in the same order.
#ifndef LOCKSTEP_LANE_MATH_H
#define LOCKSTEP_LANE_MATH_H

#include "lanes.h"

// A constant in all lanes, and the first lane alone.
#define LANE_OF(x) ((lane)(x))
#if LANES == 1
#define LANE_FIRST(x) (x)
#else
#define LANE_FIRST(x) (x).s0
#endif

typedef struct LaneAxes {
  Lane3 x, y, z;
} LaneAxes;

typedef struct LaneQuat {
  lane x, y, z, w;
} LaneQuat;

static inline lane lane_length3(Lane3 v) { return sqrt(lane_dot3(v, v)); }
static inline LaneAxes lane_axes_of(LaneQuat q) {
  const lane x2 = q.x + q.x, y2 = q.y + q.y, z2 = q.z + q.z;
  const lane xx = q.x * x2, yy = q.y * y2, zz = q.z * z2;
  const lane xy = q.x * y2, xz = q.x * z2, yz = q.y * z2;
  const lane wx = q.w * x2, wy = q.w * y2, wz = q.w * z2;
  LaneAxes axes;
  axes.x = lane_make3(LANE_OF(1) - (yy + zz), xy + wz, xz - wy);
  axes.y = lane_make3(xy - wz, LANE_OF(1) - (xx + zz), yz + wx);
  axes.z = lane_make3(xz + wy, yz - wx, LANE_OF(1) - (xx + yy));
  return axes;
}

static inline LaneQuat lane_multiply4(LaneQuat a, LaneQuat b) {
  LaneQuat q;
  q.x = a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y;
  q.y = a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x;
  q.z = a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w;
  q.w = a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z;
  return q;
}

static inline LaneQuat lane_back(LaneQuat q) {
  q.x = -q.x;
  q.y = -q.y;
  q.z = -q.z;
  return q;
}

static inline Lane3 lane_rotate3(LaneQuat q, Lane3 v) {
  const Lane3 u = lane_make3(q.x, q.y, q.z);
  const Lane3 t = lane_add3(lane_cross3(u, v), lane_scale3(q.w, v));
  return lane_add3(v, lane_scale3(LANE_OF(2), lane_cross3(u, t)));
}

static inline Lane3 lane_out_of_frame(LaneAxes axes, Lane3 v) {
  return lane_add3(lane_add3(lane_scale3(v.x, axes.x), lane_scale3(v.y, axes.y)), lane_scale3(v.z, axes.z));
}

static inline Lane3 lane_into_frame(LaneAxes axes, Lane3 v) {
  return lane_make3(lane_dot3(axes.x, v), lane_dot3(axes.y, v), lane_dot3(axes.z, v));
}

static inline Lane3 lane_absolute3(Lane3 v) { return lane_make3(fabs(v.x), fabs(v.y), fabs(v.z)); }

static inline lane lane_clamp_to(lane x, lane limit) { return x < -limit ? -limit : (x > limit ? limit : x); }

#endif
