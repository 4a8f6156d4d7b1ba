// What every kernel file starts from: the loop idiom and the status word.
#ifndef LOCKSTEP_COMMON_H
#define LOCKSTEP_COMMON_H

// Loops over `count` items with any number of work-items: the launch plan can size the grid as it likes.
#define FOR_EACH(i, count) for (u32 i = (u32)get_global_id(0); i < (count); i += (u32)get_global_size(0))

// Stages that write persistent state leave it alone once a list was full: the step is redone.
#define STEP_IS_VOID(counters) (((counters)[COUNTER_STATUS] & STATUS_FULL) != 0u)

#endif
