#pragma OPENCL FP_CONTRACT OFF
// Splits each dynamic body among its pairs in contact (cpu_reference/split_bodies.hpp). A side is a lane of a block and
// one of its two bodies: 2 slot for a, 2 slot + 1 for b.
#include "common.h"
#include "sort.h"
#include "types.h"

// Of a side: its body, NONE where that cannot move.
static inline u32 split_body(u32 side, u32 bodies, global const BlockBodies* block_bodies,
                             global const BodyInfo* body_infos) {
  global const BlockBodies* block = block_bodies + side / (2u * PACK);
  const u32 lane = side / 2u % PACK, body = side % 2u == 0u ? block->body_a[lane] : block->body_b[lane];
  return body < bodies && body_infos[body].kind == BODY_DYNAMIC ? body : NONE;
}

static inline void split_write(u32 side, real copies, u32 slot, global BodyCopyBlock* body_copy_blocks) {
  global BodyCopyBlock* block = body_copy_blocks + side / (2u * PACK);
  const u32 lane = side / 2u % PACK;
  if (side % 2u == 0u) {
    block->copies_a[lane] = copies;
    block->slot_a[lane] = slot;
  } else {
    block->copies_b[lane] = copies;
    block->slot_b[lane] = slot;
  }
}

kernel void split_clear(const StepParams params, global u32* body_copy_starts) {
  FOR_EACH(i, params.bodies + 1u) body_copy_starts[i] = 0u;
}

// The order of arrival at a body depends on the scheduling; split_order makes up for it.
kernel void split_count(const StepParams params, global const BodyInfo* body_infos,
                        global const BlockBodies* block_bodies, global u32* body_copy_starts, global u32* copy_arrivals,
                        global const u32* counters) {
  FOR_EACH(side, counters[COUNTER_BLOCKS] * (2u * PACK)) {
    const u32 body = split_body(side, params.bodies, block_bodies, body_infos);
    if (body != NONE) copy_arrivals[side] = atomic_inc(&body_copy_starts[body]);
  }
}

kernel void split_fill(const StepParams params, global const BodyInfo* body_infos,
                       global const BlockBodies* block_bodies, global const u32* body_copy_starts,
                       global const u32* copy_arrivals, global u32* copy_sides, global BodyCopyBlock* body_copy_blocks,
                       global const u32* counters) {
  FOR_EACH(side, counters[COUNTER_BLOCKS] * (2u * PACK)) {
    const u32 body = split_body(side, params.bodies, block_bodies, body_infos);
    if (body != NONE)
      copy_sides[body_copy_starts[body] + copy_arrivals[side]] = side;
    else
      split_write(side, (real)0, NONE, body_copy_blocks);
  }
}

kernel void split_order(const StepParams params, global const u32* body_copy_starts, global u32* copy_sides,
                        global BodyCopyBlock* body_copy_blocks) {
  FOR_EACH(i, params.bodies) {
    const u32 begin = body_copy_starts[i], count = body_copy_starts[i + 1u] - begin;
    sort_ascending(copy_sides + begin, count);
    for (u32 k = 0u; k < count; ++k) split_write(copy_sides[begin + k], (real)count, begin + k, body_copy_blocks);
  }
}
