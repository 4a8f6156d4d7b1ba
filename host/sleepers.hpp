// What a host does to sleepers (docs/how_to/let_bodies_sleep.md).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/error.hpp"
#include "kernels/types.h"

namespace lockstep {

inline bool is_asleep(const Sleeper& sleeper) { return sleeper.island < ISLAND_WAKES; }

/// Wakes the island that the body sleeps in: the next step finds its impulses again. A body that is awake begins anew
/// to be still. False where that changes nothing.
inline bool wake_island_of(std::vector<Sleeper>& sleepers, u32 body) {
  if (body >= sleepers.size()) return false;
  const u32 island = sleepers[body].island;
  if (!is_asleep(sleepers[body])) return std::exchange(sleepers[body].still, 0u) != 0;
  for (Sleeper& sleeper : sleepers) {
    if (sleeper.island == island) sleeper = {0, ISLAND_WAKES};
  }
  return true;
}

/// The same of all of them.
inline bool wake_all(std::vector<Sleeper>& sleepers) {
  bool any = false;
  for (Sleeper& sleeper : sleepers) {
    any = any || is_asleep(sleeper) || sleeper.still != 0;
    sleeper = {0, is_asleep(sleeper) ? ISLAND_WAKES : sleeper.island};
  }
  return any;
}

/// Where islands sleep the order of colours has this many ranks (kernels/color_contacts.cl).
constexpr u32 max_color_ranks = (1u << 26) - 2;

/// Throws Error (comparison), naming the step, for more contacts than have ranks.
inline void expect_color_ranks_for(u32 contacts, u32 step) {
  if (contacts <= max_color_ranks) return;
  throw Error(Failure::comparison, "step " + std::to_string(step) + ", color_contacts",
              std::to_string(contacts) + " contacts, of which " + std::to_string(max_color_ranks) +
                  " have a place where bodies can sleep; run it with --sleeping off");
}

}  // namespace lockstep
