#pragma OPENCL FP_CONTRACT OFF
// Who began and who ceased to touch (cpu_reference/find_events.hpp): the two ordered lists are merged, each entry to
// its own slot, and the slots of those that are in one list only are counted.
#include "common.h"
#include "shapes/may_touch.h"
#include "shapes/overlap.h"
#include "sleep.h"
#include "types.h"

#if FEATURE_TRIGGERS
static inline bool events_trigger_overlaps(Pair pair, ShapeInfo info_a, ShapeInfo info_b, global const Shape* shapes,
                                           global const Vec4* positions, global const Vec4* orientations,
                                           const HullTables* tables) {
  const Pose pose_a = make_pose(positions[info_a.body], orientations[info_a.body]);
  const Pose pose_b = make_pose(positions[info_b.body], orientations[info_b.body]);
  const WorldShape a = shape_in_world(pose_a, shapes + pair.shape_a, info_a.hull, pose_a.position);
  const WorldShape b = shape_in_world(pose_b, shapes + pair.shape_b, info_b.hull, pose_a.position);
  return shapes_overlap(info_a.kind, &a, info_b.kind, &b, tables);
}
#endif

// 1 for each pair that touches, and 0 behind the last one for the total. Of the list of the step before: entry s of
// touching_starts is the number of pairs whose shape_a is below s.
kernel void find_events_mark(global const ShapeInfo* shape_infos, global const Shape* shapes,
                             global const Vec4* positions, global const Vec4* orientations, global const Pair* pairs,
                             global const u32* contact_starts, global const u32* touched, global const Hull* hulls,
                             global const Vec4* hull_vertices, global const Vec4* hull_planes,
                             global const HullFace* hull_faces, global const HullEdge* hull_edges,
                             global const u32* hull_corners, global const Facet* facets,
                             global const FacetEdge* facet_edges, global const u32* touching_count,
                             global const Pair* touching, global u32* touching_starts, global u32* touch_slots,
                             global const u32* counters, const StepParams params) {
  if (STEP_ABORTED(counters)) return;
  const u32 before = touching_count[0];
  FOR_EACH(k, before + 1u) {
    const u32 first = k > 0u ? touching[k - 1u].shape_a + 1u : 0u;
    const u32 last = k < before ? touching[k].shape_a : params.shapes;
    for (u32 shape = first; shape <= last; ++shape) touching_starts[shape] = k;
  }
#if FEATURE_TRIGGERS
  const HullTables tables = {hulls,      hull_vertices, hull_planes, hull_faces,
                             hull_edges, hull_corners,  facets,      facet_edges};
#endif
  const u32 count = counters[COUNTER_PAIRS];
  FOR_EACH(p, count + 1u) {
    bool touches = false;
    if (p < count) {
      for (u32 i = contact_starts[p]; i < contact_starts[p + 1u]; ++i) touches = touches || touched[i] != 0u;
#if FEATURE_TRIGGERS
      const Pair pair = pairs[p];
      const ShapeInfo info_a = shape_infos[pair.shape_a], info_b = shape_infos[pair.shape_b];
      if (IS_TRIGGER(info_a) || IS_TRIGGER(info_b))
        touches = events_trigger_overlaps(pair, info_a, info_b, shapes, positions, orientations, &tables);
#endif
    }
    touch_slots[p] = touches ? 1u : 0u;
  }
}

// After the scan of touch_slots. COUNTER_EVENTS is the length of both lists until find_events_write knows better.
kernel void find_events_gather(global const Pair* pairs, global const u32* touch_slots,
                               global const u32* touching_count, global Pair* current_touching, global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  const u32 count = counters[COUNTER_PAIRS];
  if (get_global_id(0) == 0) {
    counters[COUNTER_TOUCHES] = touch_slots[count];
    counters[COUNTER_EVENTS] = touch_slots[count] + touching_count[0];
  }
  FOR_EACH(p, count) {
    if (touch_slots[p + 1u] > touch_slots[p]) current_touching[touch_slots[p]] = pairs[p];
  }
}

// Both lists, and where the pairs of each shape a begin in them.
typedef struct TouchLists {
  u32 current, before;  // lengths
  global const Pair* current_touching;
  global const Pair* touching;
  global const u32* pair_starts;
  global const u32* touch_slots;
  global const u32* touching_starts;
} TouchLists;

// The slot of entry k of both lists, those of now first, in the merged list; where both have it, `known`, that of now
// is first.
static inline u32 events_slot(const TouchLists* lists, u32 k, bool* known) {
  const bool is_current = k < lists->current;
  const Pair pair = is_current ? lists->current_touching[k] : lists->touching[k - lists->current];
  global const Pair* others = is_current ? lists->touching : lists->current_touching;
  u32 slot, last;  // the first of the others that is not before the pair is between them
  if (is_current) {
    slot = lists->touching_starts[pair.shape_a];
    last = lists->touching_starts[pair.shape_a + 1u];
  } else {
    slot = lists->touch_slots[lists->pair_starts[pair.shape_a]];
    last = lists->touch_slots[lists->pair_starts[pair.shape_a + 1u]];
  }
  const u32 end = last;
  while (slot < last) {
    const u32 middle = slot + (last - slot) / 2u;
    if (others[middle].shape_b < pair.shape_b) {
      slot = middle + 1u;
    } else {
      last = middle;
    }
  }
  *known = slot < end && others[slot].shape_b == pair.shape_b;
  return is_current ? k + slot : k - lists->current + slot + (*known ? 1u : 0u);
}

#if FEATURE_SLEEPING
// Whether a pair that touched is left out by the broad phase because both sides rest.
static inline bool events_pair_sleeps(Pair pair, u32 bodies, global const BodyInfo* body_infos,
                                      global const ShapeInfo* shape_infos, global const Motion* motions,
                                      global const Sleeper* sleepers) {
  return !looks_for_others(shape_infos[pair.shape_a], bodies, body_infos, motions, sleepers) &&
         !looks_for_others(shape_infos[pair.shape_b], bodies, body_infos, motions, sleepers);
}
#endif

// 1 for each slot of the merged list that is an event, and 0 behind the last one for the total. Where bodies sleep,
// touch_stays has the same of what touches now.
kernel void find_events_compare(const StepParams params, global const BodyInfo* body_infos,
                                global const ShapeInfo* shape_infos, global const Motion* motions,
                                global const Sleeper* sleepers, global const u32* touching_count,
                                global const Pair* touching, global const Pair* current_touching,
                                global const u32* pair_starts, global const u32* touch_slots,
                                global const u32* touching_starts, global u32* event_slots, global u32* touch_stays,
                                global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  const u32 current = counters[COUNTER_TOUCHES], before = touching_count[0];
  const TouchLists lists = {current, before, current_touching, touching, pair_starts, touch_slots, touching_starts};
  FOR_EACH(k, current + before + 1u) {
    bool is_event = false, stays = false;
    u32 slot = k;
    if (k < current + before) {
      bool known;
      slot = events_slot(&lists, k, &known);
      is_event = !known;
      stays = k < current;
#if FEATURE_SLEEPING
      if (!stays && !known)
        stays = events_pair_sleeps(touching[k - current], params.bodies, body_infos, shape_infos, motions, sleepers);
      is_event = is_event && (k < current || !stays);
#endif
    }
    event_slots[slot] = is_event ? 1u : 0u;
#if FEATURE_SLEEPING
    touch_stays[slot] = stays ? 1u : 0u;
#endif
  }
}

// After the scan of event_slots.
kernel void find_events_write(global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                              global const u32* step_index, global const u32* touching_count,
                              global const Pair* touching, global const Pair* current_touching,
                              global const u32* pair_starts, global const u32* touch_slots,
                              global const u32* touching_starts, global const u32* event_slots, global Event* events,
                              global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  const u32 current = counters[COUNTER_TOUCHES], before = touching_count[0];
  const TouchLists lists = {current, before, current_touching, touching, pair_starts, touch_slots, touching_starts};
  if (get_global_id(0) == 0) counters[COUNTER_EVENTS] = event_slots[current + before];
  FOR_EACH(k, current + before) {
    bool known;
    const u32 slot = events_slot(&lists, k, &known);
    if (event_slots[slot + 1u] == event_slots[slot]) continue;
    const bool begins = k < current;
    const Pair pair = begins ? current_touching[k] : touching[k - current];
    const bool swapped = IS_TRIGGER(shape_infos[pair.shape_b]);
    const ShapeInfo info_a = shape_infos[swapped ? pair.shape_b : pair.shape_a];
    const ShapeInfo info_b = shape_infos[swapped ? pair.shape_a : pair.shape_b];
    Event event;
    event.kind = begins ? EVENT_CONTACT_BEGIN : EVENT_CONTACT_END;
    if (IS_TRIGGER(info_a)) event.kind = begins ? EVENT_TRIGGER_ENTER : EVENT_TRIGGER_LEAVE;
    event.step = step_index[0];
    event.world = body_infos[info_a.body].world;
    event.body_a = body_infos[info_a.body].id;
    event.shape_a = info_a.id;
    event.body_b = body_infos[info_b.body].id;
    event.shape_b = info_b.id;
    event.pad = 0u;
    events[event_slots[slot]] = event;
  }
}

// The last one: what the next step compares with.
kernel void find_events_keep(global const Pair* current_touching, global u32* touching_count, global Pair* touching,
                             global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  const u32 current = counters[COUNTER_TOUCHES];
  if (get_global_id(0) == 0) touching_count[0] = current;
  FOR_EACH(i, current) { touching[i] = current_touching[i]; }
}

#if FEATURE_SLEEPING
// Or, after the scan of touch_stays, the last two: in its place goes what touches now, and what sleepers touch.
kernel void find_events_merge(global const u32* touching_count, global const Pair* touching,
                              global const Pair* current_touching, global const u32* pair_starts,
                              global const u32* touch_slots, global const u32* touching_starts,
                              global const u32* touch_stays, global Pair* touching_after, global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  const u32 current = counters[COUNTER_TOUCHES], before = touching_count[0];
  const TouchLists lists = {current, before, current_touching, touching, pair_starts, touch_slots, touching_starts};
  FOR_EACH(k, current + before) {
    bool known;
    const u32 slot = events_slot(&lists, k, &known);
    if (touch_stays[slot + 1u] > touch_stays[slot])
      touching_after[touch_stays[slot]] = k < current ? current_touching[k] : touching[k - current];
  }
}

// One work-group: all items know how many there were before one of them says how many there are.
kernel void find_events_replace(global const u32* touch_stays, global const Pair* touching_after,
                                global u32* touching_count, global Pair* touching, global u32* counters) {
  const bool is_aborted = STEP_ABORTED(counters);
  const u32 count = is_aborted ? 0u : touch_stays[counters[COUNTER_TOUCHES] + touching_count[0]];
  barrier(CLK_GLOBAL_MEM_FENCE);
  FOR_EACH(i, count) { touching[i] = touching_after[i]; }
  if (is_aborted || get_local_id(0) != 0) return;
  counters[COUNTER_TOUCHES] = count;
  touching_count[0] = count;
}
#endif
