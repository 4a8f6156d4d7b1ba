// Wakes each island of which a body is touched by one that moves, or is held by a joint of such a one: a body that is
// awake, or a kinematic one with a velocity. Whoever has a contact touches (cpu_reference/collide.hpp): a gap that can
// close within the step counts. An island wakes whole, and the step in which it does is aborted (STATUS_WOKEN) and
// begun anew, for the broad phase has left out what sleepers touch. Who touches whom depends on poses and velocities
// alone, which waking does not change: so who is awake in the end does not depend on how often the step is begun. An
// aborted step goes on without contacts.
//
// Here, too, is told whether there will be room for what falls asleep at the end of the step: every contact may join
// those of sleepers, and every pair that touches may stay where the pairs of the next step will not have it.
#pragma once

#include <vector>

#include "cpu_reference/rigid_body.hpp"
#include "cpu_reference/sleep.hpp"

namespace lockstep::reference {

template <class real>
void expect_room_for_sleepers(Buffers<real>& b, const StepParams<real>& params) {
  auto& counters = b.counters;
  counters[COUNTER_CONTACTS_NEEDED] += b.slept_count[0];
  if (counters[COUNTER_CONTACTS_NEEDED] > params.contact_capacity) counters[COUNTER_STATUS] |= STATUS_CONTACTS_FULL;
  if (b.touching_count.empty()) return;
  counters[COUNTER_PAIRS_NEEDED] += b.touching_count[0];
  if (counters[COUNTER_PAIRS_NEEDED] > params.pair_capacity) counters[COUNTER_STATUS] |= STATUS_PAIRS_FULL;
}

template <class real>
void wake_islands(Buffers<real>& b, const StepParams<real>& params) {
  expect_room_for_sleepers(b, params);
  std::vector<bool> touched(params.bodies, false);  // by island
  bool any = false;
  const auto meet = [&](u32 body, u32 other) {
    if (!is_asleep(b, body) || !is_moving(b, other)) return;
    touched[b.sleepers[body].island] = true;
    any = true;
  };
  const auto meet_each_other = [&](u32 body_a, u32 body_b) {
    meet(body_a, body_b);
    meet(body_b, body_a);
  };
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) meet_each_other(b.contacts[i].body_a, b.contacts[i].body_b);
  for_each_joined_pair(b, meet_each_other);
  if (any) b.counters[COUNTER_STATUS] |= STATUS_WOKEN;
  if (step_aborted(b.counters)) b.counters[COUNTER_CONTACTS] = 0;
  if (!any) return;
  for (Sleeper& sleeper : b.sleepers) {
    if (sleeper.island < ISLAND_WAKES && touched[sleeper.island]) sleeper = {0, ISLAND_WAKES};
  }
}

}  // namespace lockstep::reference
