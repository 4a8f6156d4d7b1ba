#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "shapes/pairs.h"
#include "shapes/reach.h"
#include "types.h"

// A sphere stands where its bound does, however it is turned.
static inline Placed collide_place(u32 kind, Vec4 bound, Pose pose, global const Shape* shape) {
  if (kind != SHAPE_SPHERE) return place_shape(pose, *shape);
  Placed sphere;
  sphere.center = make3(bound.x, bound.y, bound.z);
  sphere.rotation = make4((real)0, (real)0, (real)0, (real)1);
  sphere.size = make3(shape->size[0], shape->size[1], shape->size[2]);
  return sphere;
}

// Contacts of each pair: none or one, as long as all shapes are round.
kernel void collide_count(global const ShapeInfo* shape_infos, global const Shape* shapes, global const Vec4* positions,
                          global const Vec4* orientations, global const Motion* motions, global const Vec4* bounds,
                          global const Pair* pairs, global u32* contact_starts, global const u32* counters,
                          const StepParams params) {
  const u32 count = counters[COUNTER_PAIRS];
  FOR_EACH(p, count + 1u) {
    u32 contacts = 0u;
    if (p < count) {
      const u32 i = pairs[p].shape_a, j = pairs[p].shape_b;
      const u32 kind_a = shape_infos[i].kind, body_a = shape_infos[i].body;
      const u32 kind_b = shape_infos[j].kind, body_b = shape_infos[j].body;
      const Pose pose_a = make_pose(positions[body_a], orientations[body_a]);
      const Pose pose_b = make_pose(positions[body_b], orientations[body_b]);
      const Touch touch = touch_shapes(kind_a, collide_place(kind_a, bounds[i], pose_a, &shapes[i]), kind_b,
                                       collide_place(kind_b, bounds[j], pose_b, &shapes[j]));
      const real speed = approach_speed(touch, &motions[body_a], pose_a.position, &motions[body_b], pose_b.position);
      contacts = within_reach(params, touch.gap, speed) ? 1u : 0u;
    }
    contact_starts[p] = contacts;
  }
}

// After the scan of contact_starts. The contacts of a world follow each other, as its shapes do.
kernel void collide_write(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                          global const ShapeInfo* shape_infos, global const u32* pair_starts, global const Pair* pairs,
                          global const u32* contact_starts, global Contact* contacts, global u32* counters,
                          const StepParams params) {
  const u32 count = counters[COUNTER_PAIRS];
  const u32 total = contact_starts[count];
  const bool full = total > params.contact_capacity;
  if (get_global_id(0) == 0) {
    counters[COUNTER_CONTACTS_NEEDED] = total;
    counters[COUNTER_CONTACTS] = full ? 0u : total;
    if (full) counters[COUNTER_STATUS] |= STATUS_CONTACTS_FULL;
  }
  FOR_EACH(p, full ? 0u : count) {
    const u32 index = contact_starts[p];
    if (index == contact_starts[p + 1u]) continue;
    Contact contact;
    contact.shape_a = pairs[p].shape_a;
    contact.shape_b = pairs[p].shape_b;
    contact.feature = 0u;
    contact.body_a = shape_infos[contact.shape_a].body;
    contact.body_b = shape_infos[contact.shape_b].body;
    contact.world = body_infos[contact.body_a].world;
    contact.rank = index - contact_starts[pair_starts[world_ranges[contact.world].first_shape]];
    contact.pad = 0u;
    contacts[index] = contact;
  }
}
