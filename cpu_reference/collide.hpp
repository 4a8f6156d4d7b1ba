// Narrow phase: which pairs touch, or will within the step: gap <= margin + h max(0, approach speed). Where and how
// deep is measured again in each sub-step (prepare_contacts).
#pragma once

#include "cpu_reference/shapes/pairs.hpp"
#include "cpu_reference/shapes/reach.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// A sphere stands where its bound does, however it is turned.
template <class real>
Placed<real> collide_place(const Buffers<real>& b, u32 shape, const Pose<real>& pose) {
  if (b.shape_infos[shape].kind != SHAPE_SPHERE) return place_shape(pose, b.shapes[shape]);
  return {{b.bounds[shape].x, b.bounds[shape].y, b.bounds[shape].z}, {0, 0, 0, 1}, vec3(b.shapes[shape].size)};
}

template <class real>
bool makes_contact(const Buffers<real>& b, const StepParams<real>& params, Pair pair) {
  const ShapeInfo &a = b.shape_infos[pair.shape_a], &c = b.shape_infos[pair.shape_b];
  const Pose<real> pose_a = make_pose(b.positions[a.body], b.orientations[a.body]);
  const Pose<real> pose_b = make_pose(b.positions[c.body], b.orientations[c.body]);
  const Touch<real> touch =
      touch_shapes(a.kind, collide_place(b, pair.shape_a, pose_a), c.kind, collide_place(b, pair.shape_b, pose_b));
  const real speed = approach_speed(touch, b.motions[a.body], pose_a.position, b.motions[c.body], pose_b.position);
  return within_reach(params, touch.gap, speed);
}

/// Contacts ordered by (shape_a, shape_b, feature), numbered within their world. Where they are more than the capacity
/// none is kept, and the step is void.
template <class real>
void collide(Buffers<real>& b, const StepParams<real>& params) {
  const u32 pairs = b.counters[COUNTER_PAIRS];
  u32 total = 0;
  for (u32 p = 0; p < pairs; ++p) {
    b.contact_starts[p] = total;
    if (makes_contact(b, params, b.pairs[p])) ++total;
  }
  b.contact_starts[pairs] = total;
  b.counters[COUNTER_CONTACTS_NEEDED] = total;
  b.counters[COUNTER_CONTACTS] = total <= params.contact_capacity ? total : 0;
  if (total > params.contact_capacity) {
    b.counters[COUNTER_STATUS] |= STATUS_CONTACTS_FULL;
    return;
  }

  for (u32 p = 0; p < pairs; ++p) {
    if (b.contact_starts[p] == b.contact_starts[p + 1]) continue;
    const Pair pair = b.pairs[p];
    const u32 body_a = b.shape_infos[pair.shape_a].body, body_b = b.shape_infos[pair.shape_b].body;
    const u32 world = b.body_infos[body_a].world;
    const u32 first_pair = b.pair_starts[b.world_ranges[world].first_shape];
    const u32 contact = b.contact_starts[p];
    b.contacts[contact] = {
        pair.shape_a, pair.shape_b, 0, body_a, body_b, world, contact - b.contact_starts[first_pair], 0};
  }
}

}  // namespace lockstep::reference
