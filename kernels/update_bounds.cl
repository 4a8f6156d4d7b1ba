#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "grid.h"
#include "math.h"
#include "shapes/manifold.h"
#include "types.h"

// A work-item takes many shapes, so that the one word of the largest extent is not fought over.
kernel void update_bounds(global const ShapeInfo* shape_infos, global const Shape* shapes, global const Vec4* positions,
                          global const Vec4* orientations, global const Motion* motions, global Vec4* bounds,
                          global u32* counters, const StepParams params) {
  const real h = step_length(params);
  u32 largest = 0u;
  FOR_EACH(i, params.shapes) {
    const u32 body = shape_infos[i].body;
    const Pose pose = make_pose(positions[body], orientations[body]);
    const Vec3 center = shape_center(pose, &shapes[i]);
    real extent = (real)0;
    if (shape_infos[i].kind != SHAPE_PLANE) {
      const Vec3 v = make3(motions[body].v[0], motions[body].v[1], motions[body].v[2]);
      const Vec3 w = make3(motions[body].w[0], motions[body].w[1], motions[body].w[2]);
      const real speed = length3(v) + length3(w) * length3(sub3(center, pose.position));
      extent = shapes[i].reach + h * speed;
    }
    const bool finite = is_finite(center.x) && is_finite(center.y) && is_finite(center.z) && is_finite(extent);
    Vec4 bound;
    bound.x = finite ? center.x : (real)0;
    bound.y = finite ? center.y : (real)0;
    bound.z = finite ? center.z : (real)0;
    bound.w = finite ? extent : (real)0;
    bounds[i] = bound;
    if (finite) {
      const u32 bits = extent_bits(extent);
      largest = bits > largest ? bits : largest;
    } else {
      atomic_or(&counters[COUNTER_STATUS], (u32)STATUS_OUT_OF_GRID);
      atomic_max(&counters[COUNTER_BAD_BODY], NONE - body);
    }
  }
  if (largest > 0u) atomic_max(&counters[COUNTER_MAX_EXTENT], largest);
}
