// The sphere that each bounded shape stays in for a whole step of length h at its present velocity:
// centre c, extent r + h (|v| + |w| |c - x|), with r the reach and x the centre of mass. The grid's cells are sized by
// the largest extent.
#pragma once

#include <algorithm>

#include "cpu_reference/grid.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// Planes have extent 0 and stay out of the grid; so does a shape that has no finite place, which raises
/// STATUS_OUT_OF_GRID.
template <class real>
void update_bounds(Buffers<real>& b, const StepParams<real>& params) {
  const real h = step_length(params);
  for (u32 i = 0; i < params.shapes; ++i) {
    const u32 body = b.shape_infos[i].body;
    const Shape<real>& shape = b.shapes[i];
    const Motion<real>& motion = b.motions[body];
    const Pose<real> pose = make_pose(b.positions[body], b.orientations[body]);
    const Vec3<real> center = shape_center(pose, shape);
    real extent = 0;
    if (b.shape_infos[i].kind != SHAPE_PLANE) {
      const real arm = length3(sub3(center, pose.position));
      const real speed = length3(vec3(motion.v)) + length3(vec3(motion.w)) * arm;
      extent = shape.reach + h * speed;
    }
    const bool finite = is_finite(center.x) && is_finite(center.y) && is_finite(center.z) && is_finite(extent);
    if (finite) {
      b.bounds[i] = {center.x, center.y, center.z, extent};
      b.counters[COUNTER_MAX_EXTENT] = std::max(b.counters[COUNTER_MAX_EXTENT], extent_bits(extent));
    } else {
      b.bounds[i] = {0, 0, 0, 0};
      b.counters[COUNTER_STATUS] |= STATUS_OUT_OF_GRID;
      b.counters[COUNTER_BAD_BODY] = std::max(b.counters[COUNTER_BAD_BODY], NONE - body);
    }
  }
}

}  // namespace lockstep::reference
