// A team: work-items that share out work and meet at barriers. Usually a work-group; where TEAM_IS_GRID, all work-items
// of the launch, whose work-groups the device must then run at the same time (host/device/fused_substeps.hpp).
#ifndef LOCKSTEP_TEAM_H
#define LOCKSTEP_TEAM_H

// Words behind the counters, for the barrier of a grid: how many groups have arrived, how often all have, and whether
// one has waited too long. Each on a line of its own.
#define TEAM_ARRIVED 16
#define TEAM_BARRIERS 32
#define TEAM_STALLED 48
#define TEAM_WORDS 64

#ifndef __cplusplus

#include "types.h"

#if TEAM_IS_GRID

// Looks at the barrier word, some seconds.
#define TEAM_PATIENCE 0x40000000u

// All work-groups of the launch meet. The last one to arrive lets the others go. A group that has waited too long says
// so, and from then on none waits: what the launch computes is worthless, but it ends (STATUS_STALLED).
static inline void grid_barrier(global u32* counters) {
  barrier(CLK_GLOBAL_MEM_FENCE);
  if (get_local_id(0) == 0) {
    volatile global u32* words = counters + COUNTER_COUNT;
    const u32 barriers = atomic_add(words + TEAM_BARRIERS, 0u);
    if (atomic_inc(words + TEAM_ARRIVED) + 1u == (u32)get_num_groups(0)) {
      atomic_xchg(words + TEAM_ARRIVED, 0u);
      atomic_inc(words + TEAM_BARRIERS);
    } else {
      for (u32 looks = 0u; words[TEAM_BARRIERS] == barriers && words[TEAM_STALLED] == 0u; ++looks) {
        if (looks == TEAM_PATIENCE) atomic_xchg(words + TEAM_STALLED, 1u);
      }
      atomic_add(words + TEAM_BARRIERS, 0u);  // what others wrote before is seen from here on
    }
  }
  barrier(CLK_GLOBAL_MEM_FENCE);
}

// Behind the last barrier of a launch.
static inline void note_stalled_team(global u32* counters) {
  if (get_local_id(0) == 0 && atomic_add((volatile global u32*)counters + COUNTER_COUNT + TEAM_STALLED, 0u) != 0u)
    atomic_or(counters + COUNTER_STATUS, STATUS_STALLED);
}

// Groups take turns, so that each has its share of a few items, too.
#define TEAM_ITEM ((u32)get_local_id(0) * (u32)get_num_groups(0) + (u32)get_group_id(0))
#define EACH_ITEM TEAM_ITEM
#define TEAM_SIZE ((u32)get_global_size(0))
#define TEAM_BARRIER(counters) grid_barrier((global u32*)(counters))
#else
#define EACH_ITEM ((u32)get_global_id(0))
#define TEAM_ITEM ((u32)get_local_id(0))
#define TEAM_SIZE ((u32)get_local_size(0))
#define TEAM_BARRIER(counters) barrier(CLK_GLOBAL_MEM_FENCE)
#endif

#define FOR_EACH_OF_TEAM(i, begin, end) for (u32 i = (begin) + TEAM_ITEM; i < (end); i += TEAM_SIZE)

#endif

#endif
