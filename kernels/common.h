// What every kernel file starts from: the loop idiom and the status word.
#ifndef LOCKSTEP_COMMON_H
#define LOCKSTEP_COMMON_H

#include "team.h"
#include "types.h"

// Loops over `count` items with any number of work-items: the launch plan can size the grid as it likes. Where lanes
// say that the device is a CPU a work-item takes neighbours, which lie on one page; elsewhere it takes every n-th, so
// that work-items that run together read together.
#if EACH_TAKES_NEIGHBOURS
#define FOR_EACH(i, count) for (u32 i = each_begin(count), i##_end = each_end(count); i < i##_end; ++i)
static inline u32 each_share(u32 count) {
  const u32 size = (u32)get_global_size(0);
  if (count <= size) return 1u;  // the usual case, without a division
  return count / size + (count % size != 0u ? 1u : 0u);
}
static inline u32 each_begin(u32 count) { return EACH_ITEM * each_share(count); }
static inline u32 each_end(u32 count) {
  const u32 share = each_share(count), begin = EACH_ITEM * share;
  return begin < count && share < count - begin ? begin + share : count;
}
#else
#define FOR_EACH(i, count) for (u32 i = EACH_ITEM; i < (count); i += (u32)get_global_size(0))
#endif

// Loops in which all items of a work-group take part together, and over what the group shares out among them; the group
// may have any size. One meets at barriers between them.
#define FOR_EACH_GROUP(i, count) for (u32 i = (u32)get_group_id(0); i < (count); i += (u32)get_num_groups(0))
#define FOR_EACH_OF_GROUP(i, count) for (u32 i = (u32)get_local_id(0); i < (count); i += (u32)get_local_size(0))

// Which bit; `bits` are not zero.
static inline u32 lowest_bit(u32 bits) { return 31u - clz(bits & (0u - bits)); }

// Stages that write persistent state leave it alone once a list was full or somebody woke: the step is redone.
#define STEP_ABORTED(counters) (((counters)[COUNTER_STATUS] & STATUS_ABORTED) != 0u)

#endif
