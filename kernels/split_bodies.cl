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

static inline void split_write(u32 side, real parts, u32 slot, global PartBlock* part_blocks) {
  global PartBlock* block = part_blocks + side / (2u * PACK);
  const u32 lane = side / 2u % PACK;
  if (side % 2u == 0u) {
    block->parts_a[lane] = parts;
    block->slot_a[lane] = slot;
  } else {
    block->parts_b[lane] = parts;
    block->slot_b[lane] = slot;
  }
}

kernel void split_clear(const StepParams params, global u32* part_starts) {
  FOR_EACH(i, params.bodies + 1u) part_starts[i] = 0u;
}

// The order of arrival at a body depends on the scheduling; split_order makes up for it.
kernel void split_count(const StepParams params, global const BodyInfo* body_infos,
                        global const BlockBodies* block_bodies, global u32* part_starts, global u32* part_arrivals,
                        global const u32* counters) {
  FOR_EACH(side, counters[COUNTER_BLOCKS] * (2u * PACK)) {
    const u32 body = split_body(side, params.bodies, block_bodies, body_infos);
    if (body != NONE) part_arrivals[side] = atomic_inc(&part_starts[body]);
  }
}

kernel void split_fill(const StepParams params, global const BodyInfo* body_infos,
                       global const BlockBodies* block_bodies, global const u32* part_starts,
                       global const u32* part_arrivals, global u32* part_sides, global PartBlock* part_blocks,
                       global const u32* counters) {
  FOR_EACH(side, counters[COUNTER_BLOCKS] * (2u * PACK)) {
    const u32 body = split_body(side, params.bodies, block_bodies, body_infos);
    if (body != NONE)
      part_sides[part_starts[body] + part_arrivals[side]] = side;
    else
      split_write(side, (real)0, NONE, part_blocks);
  }
}

kernel void split_order(const StepParams params, global const u32* part_starts, global u32* part_sides,
                        global PartBlock* part_blocks) {
  FOR_EACH(i, params.bodies) {
    const u32 begin = part_starts[i], count = part_starts[i + 1u] - begin;
    sort_ascending(part_sides + begin, count);
    for (u32 k = 0u; k < count; ++k) split_write(part_sides[begin + k], (real)count, begin + k, part_blocks);
  }
}
