#pragma OPENCL FP_CONTRACT OFF
// Wakes each island that is touched by who moves (cpu_reference/wake_islands.hpp).
#include "common.h"
#include "sleep.h"
#include "types.h"

// The first of three: no island has been touched. Tells, too, whether there will be room for what falls asleep.
kernel void wake_clear(const StepParams params, global const u32* slept_count, global const u32* touching_count,
                       global u32* touched_islands, global u32* counters) {
  FOR_EACH(i, params.bodies) { touched_islands[i] = 0u; }
  if (get_global_id(0) != 0) return;
  counters[COUNTER_CONTACTS_NEEDED] += slept_count[0];
  if (counters[COUNTER_CONTACTS_NEEDED] > params.contact_capacity) counters[COUNTER_STATUS] |= STATUS_CONTACTS_FULL;
#if FEATURE_EVENTS
  counters[COUNTER_PAIRS_NEEDED] += touching_count[0];
  if (counters[COUNTER_PAIRS_NEEDED] > params.pair_capacity) counters[COUNTER_STATUS] |= STATUS_PAIRS_FULL;
#endif
}

static inline void wake_meet(u32 body, u32 other, u32 bodies, global const BodyInfo* body_infos,
                             global const Motion* motions, global const Sleeper* sleepers, global u32* touched_islands,
                             global u32* counters) {
  if (body >= bodies || !is_asleep(sleepers, body)) return;
  if (!is_moving(other, bodies, body_infos, motions, sleepers)) return;
  atomic_or(&touched_islands[sleepers[body].island], 1u);
  atomic_or(&counters[COUNTER_STATUS], (u32)STATUS_WOKEN);
}

kernel void wake_mark(const StepParams params, global const BodyInfo* body_infos, global const Motion* motions,
                      global const Contact* contacts, global const JointLanes* joint_lanes,
                      global const Sleeper* sleepers, global u32* touched_islands, global u32* counters) {
#if FEATURE_CONTACTS
  FOR_EACH(i, counters[COUNTER_CONTACTS]) {
    const u32 a = contacts[i].body_a, b = contacts[i].body_b;
    wake_meet(a, b, params.bodies, body_infos, motions, sleepers, touched_islands, counters);
    wake_meet(b, a, params.bodies, body_infos, motions, sleepers, touched_islands, counters);
  }
#endif
#if FEATURE_JOINTS
  FOR_EACH(slot, params.joint_blocks * PACK) {
    global const JointLanes* lanes = joint_lanes + slot / PACK;
    if (lanes->joint[slot % PACK] == NONE) continue;
    const u32 a = lanes->body_a[slot % PACK], b = lanes->body_b[slot % PACK];
    wake_meet(a, b, params.bodies, body_infos, motions, sleepers, touched_islands, counters);
    wake_meet(b, a, params.bodies, body_infos, motions, sleepers, touched_islands, counters);
  }
#endif
}

// The last one: islands wake whole, and the step that is aborted for them, or for want of room, has no contacts.
kernel void wake_apply(const StepParams params, global const u32* touched_islands, global Sleeper* sleepers,
                       global u32* counters) {
  if (STEP_ABORTED(counters) && get_global_id(0) == 0) counters[COUNTER_CONTACTS] = 0u;
  if ((counters[COUNTER_STATUS] & STATUS_WOKEN) == 0u) return;
  FOR_EACH(i, params.bodies) {
    const u32 island = sleepers[i].island;
    if (island >= ISLAND_WAKES || touched_islands[island] == 0u) continue;
    sleepers[i].still = 0u;
    sleepers[i].island = ISLAND_WAKES;
  }
}
