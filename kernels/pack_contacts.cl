#pragma OPENCL FP_CONTRACT OFF
// Sorts the contacts by colour, in a colour by index, and lays them into blocks (cpu_reference/pack_contacts.hpp).
// A counting sort over chunks of CHUNK contacts: pack_counts holds, colour by colour, a word a chunk.
#include "common.h"
#include "types.h"

#define PACK_COLORS (MAX_COLORS + 1u)  // the last is the overflow
#define PACK_CHUNKS(counters) ((counters)[COUNTER_CONTACTS] / CHUNK + 1u)

static inline void pack_count_chunk(u32 chunk, u32 chunks, u32 contact_count, global const u32* contact_colors,
                                    global u32* pack_counts) {
  for (u32 color = 0u; color < PACK_COLORS; ++color) pack_counts[color * chunks + chunk] = 0u;
  const u32 end = min((chunk + 1u) * CHUNK, contact_count);
  for (u32 i = chunk * CHUNK; i < end; ++i) ++pack_counts[contact_colors[i] * chunks + chunk];
}

// From the scanned counts: where every colour starts, and what to add to the rank of a contact in the sorted order to
// find its slot (of an overflow contact: its block).
static inline void pack_lay_out(u32 contact_count, u32 chunks, u32 block_capacity, global const u32* pack_counts,
                                global u32* pack_offsets, global u32* color_starts, global u32* counters) {
  u32 block = 0u, colors = 0u, large_colors = 0u;
  for (u32 color = 0u; color < MAX_COLORS; ++color) {
    const u32 first = pack_counts[color * chunks];
    const u32 size = pack_counts[(color + 1u) * chunks] - first;
    color_starts[color] = block;
    pack_offsets[color] = block * PACK - first;
    block += (size + PACK - 1u) / PACK;
    if (size > 0u) colors = color + 1u;
    if (size > (LARGE_COLOR - 1u) * PACK) large_colors = color + 1u;
  }
  const u32 first = pack_counts[MAX_COLORS * chunks];
  color_starts[MAX_COLORS] = block;
  pack_offsets[MAX_COLORS] = block - first;
  block += contact_count - first;
  color_starts[MAX_COLORS + 1u] = block;

  counters[COUNTER_COLORS] = colors;
  counters[COUNTER_LARGE_COLORS] = large_colors;
  counters[COUNTER_OVERFLOW] = contact_count - first;
  counters[COUNTER_BLOCKS_NEEDED] = block;
  counters[COUNTER_BLOCKS] = min(block, block_capacity);
  if (block > block_capacity) counters[COUNTER_STATUS] |= STATUS_BLOCKS_FULL;
}

static inline void pack_write(u32 slot, u32 block_capacity, u32 body_a, u32 body_b, u32 kind, u32 contact,
                              global BlockBodies* block_bodies) {
  if (slot / PACK >= block_capacity) return;
  global BlockBodies* block = block_bodies + slot / PACK;
  block->body_a[slot % PACK] = body_a;
  block->body_b[slot % PACK] = body_b;
  block->kind[slot % PACK] = kind;
  block->contact[slot % PACK] = contact;
}

// Lanes that no contact fills: the end of each colour, and all but the first lane of the overflow blocks.
static inline void pack_pad(u32 first, u32 stride, u32 chunks, u32 bodies, u32 block_capacity,
                            global const u32* pack_counts, global const u32* color_starts,
                            global BlockBodies* block_bodies) {
  for (u32 i = first; i < MAX_COLORS * PACK; i += stride) {
    const u32 color = i / PACK;
    const u32 size = pack_counts[(color + 1u) * chunks] - pack_counts[color * chunks];
    const u32 used = color_starts[color] * PACK + size;
    const u32 slot = used + i % PACK;
    if (slot < color_starts[color + 1u] * PACK)
      pack_write(slot, block_capacity, bodies, bodies, BLOCK_PADDING, NONE, block_bodies);
  }
  for (u32 slot = color_starts[MAX_COLORS] * PACK + first; slot < color_starts[MAX_COLORS + 1u] * PACK;
       slot += stride) {
    if (slot % PACK != 0u) pack_write(slot, block_capacity, bodies, bodies, BLOCK_PADDING, NONE, block_bodies);
  }
}

static inline u32 pack_is_central(u32 body, u32 shape, global const BodyInfo* body_infos,
                                  global const ShapeInfo* shape_infos) {
  if (body_infos[body].kind != BODY_DYNAMIC) return 1u;
  return body_infos[body].isotropic & shape_infos[shape].flags & SHAPE_IS_CENTRAL;
}

static inline void pack_place_chunk(u32 chunk, u32 chunks, u32 contact_count, u32 block_capacity,
                                    global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                                    global const Contact* contacts, global const u32* contact_colors,
                                    global const u32* pack_offsets, global u32* pack_counts, global u32* contact_slots,
                                    global BlockBodies* block_bodies) {
  const u32 end = min((chunk + 1u) * CHUNK, contact_count);
  for (u32 i = chunk * CHUNK; i < end; ++i) {
    const u32 color = contact_colors[i];
    const u32 place = pack_counts[color * chunks + chunk]++ + pack_offsets[color];
    const u32 slot = color == MAX_COLORS ? place * PACK : place;
    const Contact c = contacts[i];
    const u32 central = pack_is_central(c.body_a, c.shape_a, body_infos, shape_infos) &
                        pack_is_central(c.body_b, c.shape_b, body_infos, shape_infos);
    contact_slots[i] = slot;
    pack_write(slot, block_capacity, c.body_a, c.body_b, central != 0u ? BLOCK_CENTRAL : BLOCK_GENERAL, i,
               block_bodies);
  }
}

kernel void pack_count(global const u32* contact_colors, global u32* pack_counts, global const u32* counters) {
  const u32 chunks = PACK_CHUNKS(counters);
  FOR_EACH(chunk, chunks) pack_count_chunk(chunk, chunks, counters[COUNTER_CONTACTS], contact_colors, pack_counts);
}

// One work-group.
kernel void pack_starts(const StepParams params, global const u32* pack_counts, global u32* pack_offsets,
                        global u32* color_starts, global BlockBodies* block_bodies, global u32* counters) {
  const u32 chunks = PACK_CHUNKS(counters), lane = (u32)get_local_id(0);
  if (lane == 0u) {
    pack_lay_out(counters[COUNTER_CONTACTS], chunks, params.block_capacity, pack_counts, pack_offsets, color_starts,
                 counters);
  }
  barrier(CLK_GLOBAL_MEM_FENCE);
  pack_pad(lane, (u32)get_local_size(0), chunks, params.bodies, params.block_capacity, pack_counts, color_starts,
           block_bodies);
}

kernel void pack_place(const StepParams params, global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                       global const Contact* contacts, global const u32* contact_colors, global const u32* pack_offsets,
                       global u32* pack_counts, global u32* contact_slots, global BlockBodies* block_bodies,
                       global const u32* counters) {
  const u32 chunks = PACK_CHUNKS(counters);
  FOR_EACH(chunk, chunks)
  pack_place_chunk(chunk, chunks, counters[COUNTER_CONTACTS], params.block_capacity, body_infos, shape_infos, contacts,
                   contact_colors, pack_offsets, pack_counts, contact_slots, block_bodies);
}

// The whole stage in one work-group. An item scans the chunks of a colour.
kernel void pack_small(const StepParams params, global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                       global const Contact* contacts, global const u32* contact_colors, global u32* pack_offsets,
                       global u32* pack_counts, global u32* color_starts, global u32* contact_slots,
                       global BlockBodies* block_bodies, global u32* counters) {
  const u32 contact_count = counters[COUNTER_CONTACTS], chunks = PACK_CHUNKS(counters);
  const u32 lane = (u32)get_local_id(0), lanes = (u32)get_local_size(0);
  for (u32 chunk = lane; chunk < chunks; chunk += lanes)
    pack_count_chunk(chunk, chunks, contact_count, contact_colors, pack_counts);
  barrier(CLK_GLOBAL_MEM_FENCE);

  for (u32 color = lane; color < PACK_COLORS; color += lanes) {
    u32 sum = 0u;
    for (u32 chunk = 0u; chunk < chunks; ++chunk) sum += pack_counts[color * chunks + chunk];
    pack_offsets[color] = sum;
  }
  barrier(CLK_GLOBAL_MEM_FENCE);
  for (u32 color = lane; color < PACK_COLORS; color += lanes) {
    u32 sum = 0u;
    for (u32 before = 0u; before < color; ++before) sum += pack_offsets[before];
    for (u32 chunk = 0u; chunk < chunks; ++chunk) {
      const u32 size = pack_counts[color * chunks + chunk];
      pack_counts[color * chunks + chunk] = sum;
      sum += size;
    }
  }
  barrier(CLK_GLOBAL_MEM_FENCE);

  if (lane == 0u) {
    pack_lay_out(contact_count, chunks, params.block_capacity, pack_counts, pack_offsets, color_starts, counters);
  }
  barrier(CLK_GLOBAL_MEM_FENCE);
  pack_pad(lane, lanes, chunks, params.bodies, params.block_capacity, pack_counts, color_starts, block_bodies);
  barrier(CLK_GLOBAL_MEM_FENCE);
  for (u32 chunk = lane; chunk < chunks; chunk += lanes) {
    pack_place_chunk(chunk, chunks, contact_count, params.block_capacity, body_infos, shape_infos, contacts,
                     contact_colors, pack_offsets, pack_counts, contact_slots, block_bodies);
  }
}
