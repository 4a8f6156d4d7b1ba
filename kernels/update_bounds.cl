#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "shape_bound.h"
#include "top_level_shapes.h"
#include "types.h"

// A work-item takes many shapes, so that the one word of the largest extent is not fought over.
kernel void update_bounds(global const ShapeInfo* shape_infos, global const Shape* shapes,
                          global const u32* top_level_shapes, global const Vec4* positions,
                          global const Vec4* orientations, global const Motion* motions, global Bound* bounds,
                          global u32* counters, const StepParams params) {
  u32 largest = 0u;
  FOR_EACH(k, top_level_count(&params)) {
    const u32 i = TOP_LEVEL_SHAPE(k), body = shape_infos[i].body;
    Bound bound;
    const bool finite = shape_bound(shape_infos[i].kind, &shapes[i], &positions[body], &orientations[body],
                                    &motions[body], &params, &bound);
    bounds[k] = bound;
    note_extent(finite, bound.extent, body, &largest, counters);
  }
  if (largest > 0u) atomic_max(&counters[COUNTER_MAX_EXTENT], largest);
}
