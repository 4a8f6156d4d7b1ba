#pragma OPENCL FP_CONTRACT OFF
// Sorts the pairs in contact by colour and by number of points, in the order of the list, and lays them into blocks,
// behind those of cells (cpu_reference/pack_contacts.hpp). A counting sort over chunks of CHUNK contacts: pack_counts
// holds, key by key, a word a chunk. A key is a colour and a class, that of the pairs with most points first.
#include "common.h"
#include "pair_contacts.h"
#include "solver_cell.h"
#include "types.h"

#if FEATURE_MANIFOLDS
#define PACK_CLASSES MANIFOLD_POINTS
#else
#define PACK_CLASSES 1u
#endif
#define PACK_COLORS (MAX_COLORS + 1u)  // the last is the overflow
#define PACK_KEYS (PACK_COLORS * PACK_CLASSES)
#define PACK_CHUNKS(counters) ((counters)[COUNTER_CONTACTS] / CHUNK + 1u)

// Without colours all pairs are laid out as one.
static inline u32 pack_color(global const u32* contact_colors, u32 i) {
#if FEATURE_JACOBI
  return 0u;
#else
  return contact_colors[i];
#endif
}

static inline u32 pack_key(u32 color, u32 count) { return color * PACK_CLASSES + (PACK_CLASSES - count); }

// How many contacts a pair of a key has.
static inline u32 pack_contacts_of(u32 key) { return PACK_CLASSES - key % PACK_CLASSES; }

// The key of the pair that contact i is the first of; NONE where it is the first of none, or of one that stands in a
// cell.
static inline u32 pack_key_of(u32 i, u32 contact_count, global const Contact* contacts,
                              global const u32* contact_colors) {
  if (i >= contact_count) return NONE;
#if FEATURE_PARTITIONS
  if (contact_colors[i] == COLOR_OF_CELL) return NONE;
#endif
  const u32 count = pair_contact_count(contacts, i, contact_count);
  return count > 0u ? pack_key(pack_color(contact_colors, i), count) : NONE;
}

static inline void pack_count_chunk(u32 chunk, u32 chunks, u32 contact_count, global const Contact* contacts,
                                    global const u32* contact_colors, global u32* pack_counts) {
  for (u32 key = 0u; key < PACK_KEYS; ++key) pack_counts[key * chunks + chunk] = 0u;
  const u32 end = min((chunk + 1u) * CHUNK, contact_count);
  for (u32 i = chunk * CHUNK; i < end; ++i) {
    const u32 key = pack_key_of(i, contact_count, contacts, contact_colors);
    if (key != NONE) ++pack_counts[key * chunks + chunk];
  }
}

static inline u32 pack_blocks(u32 slots) { return (slots + PACK - 1u) / PACK; }

// Lanes from one pair to the next.
static inline u32 pack_stride(u32 color) { return color == MAX_COLORS ? PACK : 1u; }

// From where the keys start among all pairs in order: where every colour starts; what to add to the rank of a pair in
// the sorted order to find its slot (of an overflow pair: its block); and what to add to the rows of a block's number
// of blocks to find its first.
static inline void pack_lay_out(const StepParams* params, global const u32* cell_blocks, global const u32* cell_rows,
                                local const u32* key_starts, global u32* pack_offsets, global u32* pack_rows,
                                global u32* color_starts, global u32* counters) {
  u32 block = 0u, row = 0u, colors = 0u, large_colors = 0u;
#if FEATURE_PARTITIONS
  block = cell_blocks[CELL_PHASES * cells_in_phase(params)];
  row = cell_rows[CELL_PHASES * cells_in_phase(params)];
#endif
  for (u32 color = 0u; color < PACK_COLORS; ++color) {
    const u32 stride = pack_stride(color);
    color_starts[color] = block;
    u32 slot = block * PACK;
    u32 first = key_starts[color * PACK_CLASSES];
    if (first == key_starts[(color + 1u) * PACK_CLASSES]) continue;
    for (u32 key = color * PACK_CLASSES; key < (color + 1u) * PACK_CLASSES; ++key) {
      const u32 points = (color + 1u) * PACK_CLASSES - key, end = key_starts[key + 1u];
      pack_offsets[key] = slot / stride - first;
      pack_rows[key] = row - pack_blocks(slot) * points;
      const u32 next_slot = slot + (end - first) * stride;
      row += (pack_blocks(next_slot) - pack_blocks(slot)) * points;
      slot = next_slot;
      first = end;
    }
    const u32 size = pack_blocks(slot) - block;
    block += size;
    if (color < MAX_COLORS) colors = color + 1u;
    if (color < MAX_COLORS && size >= LARGE_COLOR) large_colors = color + 1u;
  }
  color_starts[PACK_COLORS] = block;

  counters[COUNTER_COLORS] = colors;
  counters[COUNTER_LARGE_COLORS] = large_colors;
  counters[COUNTER_OVERFLOW] = block - color_starts[MAX_COLORS];
  counters[COUNTER_BLOCKS_NEEDED] = block;
  counters[COUNTER_BLOCKS] = min(block, params->block_capacity);
  counters[COUNTER_ROWS_NEEDED] = row;
  counters[COUNTER_ROWS] = min(row, params->row_capacity);
  if (block > params->block_capacity) counters[COUNTER_STATUS] |= STATUS_BLOCKS_FULL;
  if (row > params->row_capacity) counters[COUNTER_STATUS] |= STATUS_ROWS_FULL;
}

static inline void pack_write(u32 slot, u32 block_capacity, u32 body_a, u32 body_b, u32 kind, u32 contact, u32 count,
                              global BlockBodies* block_bodies) {
  if (slot / PACK >= block_capacity) return;
  global BlockBodies* block = block_bodies + slot / PACK;
  block->body_a[slot % PACK] = body_a;
  block->body_b[slot % PACK] = body_b;
  block->kind[slot % PACK] = kind;
  block->contact[slot % PACK] = contact;
  block->count[slot % PACK] = count;
}

// Lanes that no pair fills: the end of each colour, and all but the first lane of the overflow blocks.
static inline void pack_pad(u32 first, u32 stride, u32 bodies, u32 block_capacity, local const u32* key_starts,
                            global const u32* color_starts, global BlockBodies* block_bodies) {
  for (u32 i = first; i < MAX_COLORS * PACK; i += stride) {
    const u32 color = i / PACK;
    const u32 size = key_starts[(color + 1u) * PACK_CLASSES] - key_starts[color * PACK_CLASSES];
    const u32 used = color_starts[color] * PACK + size;
    const u32 slot = used + i % PACK;
    if (slot < color_starts[color + 1u] * PACK)
      pack_write(slot, block_capacity, bodies, bodies, BLOCK_PADDING, NONE, 0u, block_bodies);
  }
  for (u32 slot = color_starts[MAX_COLORS] * PACK + first; slot < color_starts[MAX_COLORS + 1u] * PACK;
       slot += stride) {
    if (slot % PACK != 0u) pack_write(slot, block_capacity, bodies, bodies, BLOCK_PADDING, NONE, 0u, block_bodies);
  }
}

static inline u32 pack_is_central(u32 body, u32 shape, global const BodyInfo* body_infos,
                                  global const ShapeInfo* shape_infos) {
  if (body_infos[body].kind != BODY_DYNAMIC) return 1u;
  return body_infos[body].isotropic & shape_infos[shape].flags & SHAPE_IS_CENTRAL;
}

// Puts the pair that contact i is the first of into a slot; false where that is beyond the blocks.
static inline bool pack_pair(u32 i, u32 count, u32 slot, u32 block_capacity, global const BodyInfo* body_infos,
                             global const ShapeInfo* shape_infos, global const Contact* contacts,
                             global u32* contact_slots, global BlockBodies* block_bodies) {
  if (slot / PACK >= block_capacity) {
    for (u32 k = 0u; k < count; ++k) contact_slots[i + k] = NONE;
    return false;
  }
  const Contact c = contacts[i];
  const u32 central = pack_is_central(c.body_a, c.shape_a, body_infos, shape_infos) &
                      pack_is_central(c.body_b, c.shape_b, body_infos, shape_infos);
  pack_write(slot, block_capacity, c.body_a, c.body_b, central != 0u ? BLOCK_CENTRAL : BLOCK_GENERAL, i, count,
             block_bodies);
  return true;
}

// Puts the pair that contact i is the first of where it stands among those of its key; and says where the rows of its
// block are, where it begins one.
static inline void pack_scatter_pair(u32 i, u32 key, u32 rank, u32 block_capacity, global const BodyInfo* body_infos,
                                     global const ShapeInfo* shape_infos, global const Contact* contacts,
                                     global const u32* pack_offsets, global const u32* pack_rows,
                                     global u32* contact_slots, global BlockBodies* block_bodies,
                                     global BlockRows* block_rows) {
  const u32 count = pack_contacts_of(key), slot = (rank + pack_offsets[key]) * pack_stride(key / PACK_CLASSES);
  const bool is_there =
      pack_pair(i, count, slot, block_capacity, body_infos, shape_infos, contacts, contact_slots, block_bodies);
  if (is_there && slot % PACK == 0u) {
    block_rows[slot / PACK].first = pack_rows[key] + slot / PACK * count;
    block_rows[slot / PACK].count = count;
  }
}

// The pairs of a chunk, one after another.
static inline void pack_scatter_chunk(u32 chunk, u32 chunks, u32 contact_count, u32 block_capacity,
                                      global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                                      global const Contact* contacts, global const u32* contact_colors,
                                      global const u32* pack_offsets, global const u32* pack_rows,
                                      global u32* pack_counts, global u32* contact_slots,
                                      global BlockBodies* block_bodies, global BlockRows* block_rows) {
  const u32 end = min((chunk + 1u) * CHUNK, contact_count);
  for (u32 i = chunk * CHUNK; i < end; ++i) {
    const u32 key = pack_key_of(i, contact_count, contacts, contact_colors);
    if (key == NONE) continue;
    pack_scatter_pair(i, key, pack_counts[key * chunks + chunk]++, block_capacity, body_infos, shape_infos, contacts,
                      pack_offsets, pack_rows, contact_slots, block_bodies, block_rows);
  }
}

// Where the contacts of the pair in a slot stand.
static inline void pack_find_contacts(u32 slot, global const BlockBodies* block_bodies,
                                      global const BlockRows* block_rows, global u32* contact_slots) {
  const u32 lane = slot % PACK;
  global const BlockBodies* block = block_bodies + slot / PACK;
  for (u32 k = 0u; k < block->count[lane]; ++k)
    contact_slots[block->contact[lane] + k] = (block_rows[slot / PACK].first + k) * PACK + lane;
}

#if FEATURE_PARTITIONS
// The blocks of each cell: a batch of its schedule each.
kernel void pack_cells(const StepParams params, global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                       global const Contact* contacts, global const u32* cell_starts, global const u32* cell_pairs,
                       global const u32* cell_slots, global const u32* cell_blocks, global const u32* cell_rows,
                       global u32* contact_slots, global BlockBodies* block_bodies, global BlockRows* block_rows,
                       global const u32* counters) {
  FOR_EACH(cell, CELL_PHASES * cells_in_phase(&params)) {
    const u32 first_slot = cell_blocks[cell] * PACK, end_block = min(cell_blocks[cell + 1u], params.block_capacity);
    for (u32 slot = first_slot; slot < end_block * PACK; ++slot)
      pack_write(slot, params.block_capacity, params.bodies, params.bodies, BLOCK_PADDING, NONE, 0u, block_bodies);
    for (u32 k = cell_starts[cell]; k < cell_starts[cell + 1u]; ++k) {
      const u32 i = cell_pairs[k];
      if (cell_slots[i] == NONE) continue;
      pack_pair(i, pair_contact_count(contacts, i, counters[COUNTER_CONTACTS]), first_slot + cell_slots[i],
                params.block_capacity, body_infos, shape_infos, contacts, contact_slots, block_bodies);
    }
    u32 row = cell_rows[cell];
    for (u32 block = first_slot / PACK; block < end_block; ++block) {
      block_rows[block].first = row;
      block_rows[block].count = block_bodies[block].count[0];
      row += block_rows[block].count;
    }
  }
}
#endif

// ---- many work-groups ---------------------------------------------------------------------------------------------

// On a CPU device a work-item takes a chunk, elsewhere a work-group does, with the keys of its contacts in local
// memory.

kernel void pack_count(global const Contact* contacts, global const u32* contact_colors, global u32* pack_counts,
                       global const u32* counters) {
  const u32 chunks = PACK_CHUNKS(counters), contact_count = counters[COUNTER_CONTACTS];
#if EACH_TAKES_NEIGHBOURS
  FOR_EACH(chunk, chunks) pack_count_chunk(chunk, chunks, contact_count, contacts, contact_colors, pack_counts);
#else
  local u32 counts[PACK_KEYS];
  FOR_EACH_GROUP(chunk, chunks) {
    FOR_EACH_OF_GROUP(key, PACK_KEYS) { counts[key] = 0u; }
    barrier(CLK_LOCAL_MEM_FENCE);
    FOR_EACH_OF_GROUP(i, CHUNK) {
      const u32 key = pack_key_of(chunk * CHUNK + i, contact_count, contacts, contact_colors);
      if (key != NONE) atomic_inc(&counts[key]);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    FOR_EACH_OF_GROUP(key, PACK_KEYS) { pack_counts[key * chunks + chunk] = counts[key]; }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
#endif
}

// One work-group. The scan has put the number of all pairs behind the counts.
kernel void pack_starts(const StepParams params, global const u32* cell_blocks, global const u32* cell_rows,
                        global const u32* pack_counts, global u32* pack_offsets, global u32* pack_rows,
                        global u32* color_starts, global BlockBodies* block_bodies, global u32* counters) {
  local u32 key_starts[PACK_KEYS + 1u];
  const u32 chunks = PACK_CHUNKS(counters), lane = (u32)get_local_id(0);
  FOR_EACH_OF_GROUP(key, PACK_KEYS + 1u) { key_starts[key] = pack_counts[key * chunks]; }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0u)
    pack_lay_out(&params, cell_blocks, cell_rows, key_starts, pack_offsets, pack_rows, color_starts, counters);
  barrier(CLK_GLOBAL_MEM_FENCE);
  pack_pad(lane, (u32)get_local_size(0), params.bodies, params.block_capacity, key_starts, color_starts, block_bodies);
}

kernel void pack_scatter(const StepParams params, global const BodyInfo* body_infos,
                         global const ShapeInfo* shape_infos, global const Contact* contacts,
                         global const u32* contact_colors, global const u32* pack_offsets, global const u32* pack_rows,
                         global u32* pack_counts, global u32* contact_slots, global BlockBodies* block_bodies,
                         global BlockRows* block_rows, global const u32* counters) {
  const u32 chunks = PACK_CHUNKS(counters), contact_count = counters[COUNTER_CONTACTS];
#if EACH_TAKES_NEIGHBOURS
  FOR_EACH(chunk, chunks)
  pack_scatter_chunk(chunk, chunks, contact_count, params.block_capacity, body_infos, shape_infos, contacts,
                     contact_colors, pack_offsets, pack_rows, pack_counts, contact_slots, block_bodies, block_rows);
#else
  local u32 keys[CHUNK];
  FOR_EACH_GROUP(chunk, chunks) {
    FOR_EACH_OF_GROUP(i, CHUNK) { keys[i] = pack_key_of(chunk * CHUNK + i, contact_count, contacts, contact_colors); }
    barrier(CLK_LOCAL_MEM_FENCE);
    FOR_EACH_OF_GROUP(i, CHUNK) {
      const u32 key = keys[i];
      if (key == NONE) continue;
      u32 rank = pack_counts[key * chunks + chunk];  // behind those of its key that are before it in the chunk
      for (u32 before = 0u; before < i; ++before) rank += keys[before] == key ? 1u : 0u;
      pack_scatter_pair(chunk * CHUNK + i, key, rank, params.block_capacity, body_infos, shape_infos, contacts,
                        pack_offsets, pack_rows, contact_slots, block_bodies, block_rows);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
#endif
}

kernel void pack_find(global const BlockBodies* block_bodies, global const BlockRows* block_rows,
                      global u32* contact_slots, global const u32* counters) {
  FOR_EACH(slot, counters[COUNTER_BLOCKS] * PACK) pack_find_contacts(slot, block_bodies, block_rows, contact_slots);
}

// ---- one work-group -----------------------------------------------------------------------------------------------

// The whole stage. An item scans the counts of a colour.
kernel void pack_small(const StepParams params, global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                       global const Contact* contacts, global const u32* contact_colors, global const u32* cell_blocks,
                       global const u32* cell_rows, global u32* pack_offsets, global u32* pack_rows,
                       global u32* pack_counts, global u32* color_starts, global u32* contact_slots,
                       global BlockBodies* block_bodies, global BlockRows* block_rows, global u32* counters) {
  local u32 key_starts[PACK_KEYS + 1u];
  const u32 contact_count = counters[COUNTER_CONTACTS], chunks = PACK_CHUNKS(counters);
  const u32 lane = (u32)get_local_id(0), lanes = (u32)get_local_size(0);
  for (u32 chunk = lane; chunk < chunks; chunk += lanes)
    pack_count_chunk(chunk, chunks, contact_count, contacts, contact_colors, pack_counts);
  barrier(CLK_GLOBAL_MEM_FENCE);

  const u32 words = PACK_CLASSES * chunks;  // of a colour
  for (u32 color = lane; color < PACK_COLORS; color += lanes) {
    u32 sum = 0u;
    for (u32 i = color * words; i < (color + 1u) * words; ++i) sum += pack_counts[i];
    pack_offsets[color] = sum;
  }
  barrier(CLK_GLOBAL_MEM_FENCE);
  for (u32 color = lane; color < PACK_COLORS; color += lanes) {
    u32 sum = 0u;
    for (u32 before = 0u; before < color; ++before) sum += pack_offsets[before];
    for (u32 i = color * words; i < (color + 1u) * words; ++i) {
      const u32 size = pack_counts[i];
      pack_counts[i] = sum;
      sum += size;
    }
    if (color == MAX_COLORS) pack_counts[PACK_COLORS * words] = sum;
  }
  barrier(CLK_GLOBAL_MEM_FENCE);

  FOR_EACH_OF_GROUP(key, PACK_KEYS + 1u) { key_starts[key] = pack_counts[key * chunks]; }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane == 0u)
    pack_lay_out(&params, cell_blocks, cell_rows, key_starts, pack_offsets, pack_rows, color_starts, counters);
  barrier(CLK_GLOBAL_MEM_FENCE);
  pack_pad(lane, lanes, params.bodies, params.block_capacity, key_starts, color_starts, block_bodies);
  barrier(CLK_GLOBAL_MEM_FENCE);
  for (u32 chunk = lane; chunk < chunks; chunk += lanes) {
    pack_scatter_chunk(chunk, chunks, contact_count, params.block_capacity, body_infos, shape_infos, contacts,
                       contact_colors, pack_offsets, pack_rows, pack_counts, contact_slots, block_bodies, block_rows);
  }
  barrier(CLK_GLOBAL_MEM_FENCE);
  for (u32 slot = lane; slot < counters[COUNTER_BLOCKS] * PACK; slot += lanes)
    pack_find_contacts(slot, block_bodies, block_rows, contact_slots);
}
