#pragma OPENCL FP_CONTRACT OFF
// Who began and who ceased to touch (cpu_reference/find_events.hpp): the two ordered lists are merged, each entry to
// its own place, and the places of those that are in one list only are counted.
#include "common.h"
#include "shapes/overlap.h"
#include "shapes/reach.h"
#include "types.h"

#if FEATURE_SENSORS
static inline bool events_sensor_overlaps(Pair pair, ShapeInfo info_a, ShapeInfo info_b, global const Shape* shapes,
                                          global const Vec4* positions, global const Vec4* orientations,
                                          HullTables tables) {
  const Pose pose_a = make_pose(positions[info_a.body], orientations[info_a.body]);
  const Pose pose_b = make_pose(positions[info_b.body], orientations[info_b.body]);
  return shapes_overlap(info_a.kind, place_shape(pose_a, shapes + pair.shape_a, info_a.hull, pose_a.position),
                        info_b.kind, place_shape(pose_b, shapes + pair.shape_b, info_b.hull, pose_a.position), tables);
}
#endif

// 1 for each pair that touches, and 0 behind the last one for the total.
kernel void find_events_mark(global const ShapeInfo* shape_infos, global const Shape* shapes,
                             global const Vec4* positions, global const Vec4* orientations, global const Pair* pairs,
                             global const u32* contact_starts, global const u32* touched, global const Hull* hulls,
                             global const Vec4* hull_vertices, global const Vec4* hull_planes,
                             global const HullFace* hull_faces, global const HullEdge* hull_edges,
                             global const u32* hull_corners, global u32* touch_slots, global const u32* counters) {
  if (STEP_IS_VOID(counters)) return;
#if FEATURE_SENSORS
  const HullTables tables = {hulls, hull_vertices, hull_planes, hull_faces, hull_edges, hull_corners};
#endif
  const u32 count = counters[COUNTER_PAIRS];
  FOR_EACH(p, count + 1u) {
    bool touches = false;
    if (p < count) {
      for (u32 i = contact_starts[p]; i < contact_starts[p + 1u]; ++i) touches = touches || touched[i] != 0u;
#if FEATURE_SENSORS
      const Pair pair = pairs[p];
      const ShapeInfo info_a = shape_infos[pair.shape_a], info_b = shape_infos[pair.shape_b];
      if (IS_SENSOR(info_a) || IS_SENSOR(info_b))
        touches = events_sensor_overlaps(pair, info_a, info_b, shapes, positions, orientations, tables);
#endif
    }
    touch_slots[p] = touches ? 1u : 0u;
  }
}

// After the scan of touch_slots. COUNTER_EVENTS is the length of both lists until find_events_write knows better.
kernel void find_events_gather(global const Pair* pairs, global const u32* touch_slots,
                               global const u32* touching_count, global Pair* touching_now, global u32* counters) {
  if (STEP_IS_VOID(counters)) return;
  const u32 count = counters[COUNTER_PAIRS];
  if (get_global_id(0) == 0) {
    counters[COUNTER_TOUCHES] = touch_slots[count];
    counters[COUNTER_EVENTS] = touch_slots[count] + touching_count[0];
  }
  FOR_EACH(p, count) {
    if (touch_slots[p + 1u] > touch_slots[p]) touching_now[touch_slots[p]] = pairs[p];
  }
}

static inline bool events_before(Pair p, Pair q) {
  return p.shape_a != q.shape_a ? p.shape_a < q.shape_a : p.shape_b < q.shape_b;
}

// The place of entry k of both lists, those of now first, in the merged list; where both have it, `known`, that of now
// is first.
static inline u32 events_place(u32 k, u32 now, u32 before, global const Pair* touching_now, global const Pair* touching,
                               bool* known) {
  const bool is_now = k < now;
  const Pair pair = is_now ? touching_now[k] : touching[k - now];
  global const Pair* others = is_now ? touching : touching_now;
  const u32 count = is_now ? before : now;
  u32 low = 0u, high = count;
  while (low < high) {
    const u32 middle = low + (high - low) / 2u;
    if (events_before(others[middle], pair)) {
      low = middle + 1u;
    } else {
      high = middle;
    }
  }
  *known = low < count && !events_before(pair, others[low]);
  return is_now ? k + low : k - now + low + (*known ? 1u : 0u);
}

// 1 for each place of the merged list that is an event, and 0 behind the last one for the total.
kernel void find_events_compare(global const u32* touching_count, global const Pair* touching,
                                global const Pair* touching_now, global u32* event_slots, global const u32* counters) {
  if (STEP_IS_VOID(counters)) return;
  const u32 now = counters[COUNTER_TOUCHES], before = touching_count[0];
  FOR_EACH(k, now + before + 1u) {
    if (k == now + before) {
      event_slots[k] = 0u;
    } else {
      bool known;
      const u32 place = events_place(k, now, before, touching_now, touching, &known);
      event_slots[place] = known ? 0u : 1u;
    }
  }
}

// After the scan of event_slots.
kernel void find_events_write(global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                              global const u32* step_index, global const u32* touching_count,
                              global const Pair* touching, global const Pair* touching_now,
                              global const u32* event_slots, global Event* events, global u32* counters) {
  if (STEP_IS_VOID(counters)) return;
  const u32 now = counters[COUNTER_TOUCHES], before = touching_count[0];
  if (get_global_id(0) == 0) counters[COUNTER_EVENTS] = event_slots[now + before];
  FOR_EACH(k, now + before) {
    bool known;
    const u32 place = events_place(k, now, before, touching_now, touching, &known);
    if (known) continue;
    const bool begins = k < now;
    const Pair pair = begins ? touching_now[k] : touching[k - now];
    const bool turned = IS_SENSOR(shape_infos[pair.shape_b]);
    const ShapeInfo info_a = shape_infos[turned ? pair.shape_b : pair.shape_a];
    const ShapeInfo info_b = shape_infos[turned ? pair.shape_a : pair.shape_b];
    Event event;
    event.kind = begins ? EVENT_CONTACT_BEGIN : EVENT_CONTACT_END;
    if (IS_SENSOR(info_a)) event.kind = begins ? EVENT_SENSOR_ENTER : EVENT_SENSOR_LEAVE;
    event.step = step_index[0];
    event.world = body_infos[info_a.body].world;
    event.body_a = body_infos[info_a.body].id;
    event.shape_a = info_a.id;
    event.body_b = body_infos[info_b.body].id;
    event.shape_b = info_b.id;
    event.pad = 0u;
    events[event_slots[place]] = event;
  }
}

// The last one: what the next step compares with.
kernel void find_events_keep(global const Pair* touching_now, global u32* touching_count, global Pair* touching,
                             global const u32* counters) {
  if (STEP_IS_VOID(counters)) return;
  const u32 now = counters[COUNTER_TOUCHES];
  if (get_global_id(0) == 0) touching_count[0] = now;
  FOR_EACH(i, now) { touching[i] = touching_now[i]; }
}
