// What a host does to sleepers (docs/sleeping.md).
#pragma once

#include <vector>

#include "kernels/types.h"

namespace lockstep {

inline bool is_asleep(const Sleeper& sleeper) { return sleeper.island < ISLAND_WAKES; }

/// Wakes the island that the body sleeps in; false where it does not sleep. The next step finds its impulses again.
inline bool wake_island_of(std::vector<Sleeper>& sleepers, u32 body) {
  if (body >= sleepers.size() || !is_asleep(sleepers[body])) return false;
  const u32 island = sleepers[body].island;
  for (Sleeper& sleeper : sleepers) {
    if (sleeper.island == island) sleeper = {0, ISLAND_WAKES};
  }
  return true;
}

}  // namespace lockstep
