#pragma OPENCL FP_CONTRACT OFF
// In which order the pairs of each cell are solved: in batches that share no movable body
// (cpu_reference/schedule_contacts.hpp). Two ways to the same batches. For a device with few threads a work-item takes
// a cell, pair after pair into the first batch that it fits. For one with thousands a work-group takes it and fills
// batch after batch: pairs bid on their bodies with their rank in the order, in local memory; who is first on both of
// its bodies is in the batch, and who shares a body with it is out of it, until all are one or the other. Of those that
// are in, the first PACK stay.
#include "common.h"
#include "pair_contacts.h"
#include "solver_cell.h"
#include "types.h"

// What a pair waits for while its cell is scheduled, in cell_slots; its number of points is in the low bits.
#define SCHEDULE_WAITS 0x80000000u
#define SCHEDULE_BIDS 0x90000000u
#define SCHEDULE_CHOSEN 0xa0000000u
#define SCHEDULE_STATE 0xf0000000u
#define SCHEDULE_POINTS 0x0fffffffu

// Bits of the batches that a movable body is in; of the phase of the cell alone, as no other cell of it has the body.
static inline global u32* schedule_batches_of(u32 body, global const BodyInfo* body_infos, global u32* phase_batches) {
  return body_infos[body].kind == BODY_DYNAMIC ? phase_batches + 2u * body : 0;
}
static inline global u32* schedule_phase_batches(u32 cell, const StepParams* params, global u32* body_batches) {
  return body_batches + 2u * (cell / cells_in_phase(params) * params->bodies);
}

static inline void schedule_clear_body(global u32* batches) {
  if (!batches) return;
  batches[0] = 0u;
  batches[1] = 0u;
}
// Pairs that share the body do so at once.
static inline void schedule_clear_shared(global u32* batches) {
  if (!batches) return;
  atomic_and(&batches[0], 0u);
  atomic_and(&batches[1], 0u);
}

static inline bool schedule_has(global const u32* batches, u32 batch) {
  return batches && (batches[batch / 32u] >> (batch % 32u) & 1u) != 0u;
}

static inline void schedule_flip(global u32* batches, u32 batch) {
  if (batches) batches[batch / 32u] ^= 1u << (batch % 32u);
}

kernel void schedule_clear(global u32* cell_slots, global const u32* counters) {
  FOR_EACH(i, counters[COUNTER_CONTACTS]) cell_slots[i] = NONE;
}

// ---- in order -----------------------------------------------------------------------------------------------------

// The first batch that is neither full nor has one of the bodies; CELL_BATCHES where there is none.
static inline u32 schedule_first_fit(const u32* full, global const u32* a, global const u32* b) {
  for (u32 k = 0u; k < 2u; ++k) {
    const u32 free = ~(full[k] | (a ? a[k] : 0u) | (b ? b[k] : 0u));
    if (free != 0u) return 32u * k + lowest_bit(free);
  }
  return CELL_BATCHES;
}

kernel void schedule_cells(const StepParams params, global const BodyInfo* body_infos, global const Contact* contacts,
                           global const u32* cell_starts, global const u32* cell_pairs, global u32* body_batches,
                           global u32* cell_slots, global u32* cell_blocks, global u32* cell_rows,
                           global const u32* counters) {
  FOR_EACH(cell, CELL_PHASES * cells_in_phase(&params)) {
    const u32 begin = cell_starts[cell], end = cell_starts[cell + 1u];
    global u32* phase_batches = schedule_phase_batches(cell, &params, body_batches);
    u32 sizes[CELL_BATCHES], pairs_of[MANIFOLD_POINTS + 1u] = {0u, 0u, 0u, 0u, 0u};
    u32 full[2] = {0u, 0u}, batches = 0u, rows = 0u;
    for (u32 k = begin; k < end; ++k) {
      const u32 i = cell_pairs[k], count = pair_contact_count(contacts, i, counters[COUNTER_CONTACTS]);
      cell_slots[i] = SCHEDULE_WAITS | count;
      ++pairs_of[count];
      schedule_clear_body(schedule_batches_of(contacts[i].body_a, body_infos, phase_batches));
      schedule_clear_body(schedule_batches_of(contacts[i].body_b, body_infos, phase_batches));
    }
    for (u32 points = MANIFOLD_POINTS; points > 0u; --points) {
      for (u32 k = begin; k < end && pairs_of[points] > 0u; ++k) {
        const u32 i = cell_pairs[k];
        if (cell_slots[i] != (SCHEDULE_WAITS | points)) continue;
        --pairs_of[points];
        global u32* a = schedule_batches_of(contacts[i].body_a, body_infos, phase_batches);
        global u32* b = schedule_batches_of(contacts[i].body_b, body_infos, phase_batches);
        const u32 batch = schedule_first_fit(full, a, b);
        cell_slots[i] = NONE;
        if (batch == CELL_BATCHES) continue;
        if (batch == batches) {
          sizes[batches++] = 0u;
          rows += points;
        }
        cell_slots[i] = batch * PACK + sizes[batch]++;
        if (sizes[batch] == PACK) full[batch / 32u] |= 1u << (batch % 32u);
        schedule_flip(a, batch);
        schedule_flip(b, batch);
      }
    }
    cell_blocks[cell] = batches;
    cell_rows[cell] = rows;
  }
}

// ---- by work-groups -----------------------------------------------------------------------------------------------

// Words in which bodies are bid on. Two that share a word only make a pair wait for another.
#define SCHEDULE_BODIES 256u

// The rank of the k-th pair of a cell in the order, as a falling priority: never 0, "no bid".
static inline u32 schedule_priority(u32 k, u32 state) { return (state & SCHEDULE_POINTS) << 28 | (0x0fffffffu - k); }

static inline void schedule_bid(u32 body, global const u32* batches, u32 priority, local u32* bids) {
  if (batches) atomic_max(&bids[body % SCHEDULE_BODIES], priority);
}

static inline bool schedule_wins(u32 body, global const u32* batches, u32 priority, local const u32* bids) {
  return !batches || bids[body % SCHEDULE_BODIES] == priority;
}

// How many chosen pairs come before this one.
static inline u32 schedule_rank(u32 begin, u32 end, u32 priority, global const u32* cell_pairs,
                                global const u32* cell_slots) {
  u32 rank = 0u;
  for (u32 k = begin; k < end; ++k) {
    const u32 state = cell_slots[cell_pairs[k]];
    if ((state & SCHEDULE_STATE) == SCHEDULE_CHOSEN && schedule_priority(k - begin, state) > priority) ++rank;
  }
  return rank;
}

#define SCHEDULE_BARRIER barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE)

kernel void schedule_cells_by_groups(const StepParams params, global const BodyInfo* body_infos,
                                     global const Contact* contacts, global const u32* cell_starts,
                                     global const u32* cell_pairs, global u32* body_batches, global u32* pair_ranks,
                                     global u32* cell_slots, global u32* cell_blocks, global u32* cell_rows,
                                     global const u32* counters) {
  local u32 bids[SCHEDULE_BODIES], rows, lost, left;
  const u32 cells = CELL_PHASES * cells_in_phase(&params), id = (u32)get_local_id(0), size = (u32)get_local_size(0);
  u32 cell = (u32)get_group_id(0);
  do {
    const u32 begin = cell < cells ? cell_starts[cell] : 0u, end = cell < cells ? cell_starts[cell + 1u] : 0u;
    global u32* phase_batches = schedule_phase_batches(cell, &params, body_batches);
    for (u32 k = begin + id; k < end; k += size) {
      const u32 i = cell_pairs[k];
      cell_slots[i] = SCHEDULE_WAITS | pair_contact_count(contacts, i, counters[COUNTER_CONTACTS]);
      schedule_clear_shared(schedule_batches_of(contacts[i].body_a, body_infos, phase_batches));
      schedule_clear_shared(schedule_batches_of(contacts[i].body_b, body_infos, phase_batches));
    }
    if (id == 0u) rows = 0u;
    u32 batch = 0u;
    bool more = begin < end;
    do {
      // all that the batch could hold
      bool undecided = true;
      do {
        for (u32 k = id; k < SCHEDULE_BODIES; k += size) bids[k] = 0u;
        if (id == 0u) lost = left = 0u;
        SCHEDULE_BARRIER;
        for (u32 k = begin + id; k < end; k += size) {
          const u32 i = cell_pairs[k], state = cell_slots[i];
          if ((state & SCHEDULE_STATE) != SCHEDULE_WAITS) continue;
          const u32 body_a = contacts[i].body_a, body_b = contacts[i].body_b;
          global const u32* a = schedule_batches_of(body_a, body_infos, phase_batches);
          global const u32* b = schedule_batches_of(body_b, body_infos, phase_batches);
          if (schedule_has(a, batch) || schedule_has(b, batch)) continue;
          const u32 priority = schedule_priority(k - begin, state);
          schedule_bid(body_a, a, priority, bids);
          schedule_bid(body_b, b, priority, bids);
          cell_slots[i] = SCHEDULE_BIDS | (state & SCHEDULE_POINTS);
        }
        SCHEDULE_BARRIER;
        for (u32 k = begin + id; k < end; k += size) {
          const u32 i = cell_pairs[k], state = cell_slots[i];
          if ((state & SCHEDULE_STATE) != SCHEDULE_BIDS) continue;
          const u32 body_a = contacts[i].body_a, body_b = contacts[i].body_b;
          global u32* a = schedule_batches_of(body_a, body_infos, phase_batches);
          global u32* b = schedule_batches_of(body_b, body_infos, phase_batches);
          const u32 priority = schedule_priority(k - begin, state);
          const bool wins = schedule_wins(body_a, a, priority, bids) && schedule_wins(body_b, b, priority, bids);
          cell_slots[i] = (wins ? SCHEDULE_CHOSEN : SCHEDULE_WAITS) | (state & SCHEDULE_POINTS);
          if (wins) {
            schedule_flip(a, batch);
            schedule_flip(b, batch);
          } else {
            lost = 1u;
          }
        }
        SCHEDULE_BARRIER;
        undecided = lost != 0u;
        SCHEDULE_BARRIER;
      } while (undecided);
      // the first PACK of them; the others wait for the next batch
      for (u32 k = begin + id; k < end; k += size) {
        const u32 state = cell_slots[cell_pairs[k]];
        if ((state & SCHEDULE_STATE) == SCHEDULE_CHOSEN)
          pair_ranks[k] = schedule_rank(begin, end, schedule_priority(k - begin, state), cell_pairs, cell_slots);
      }
      SCHEDULE_BARRIER;
      for (u32 k = begin + id; k < end; k += size) {
        const u32 i = cell_pairs[k], state = cell_slots[i], points = state & SCHEDULE_POINTS;
        if ((state & SCHEDULE_STATE) == SCHEDULE_WAITS) left = 1u;
        if ((state & SCHEDULE_STATE) != SCHEDULE_CHOSEN) continue;
        if (pair_ranks[k] == 0u) rows += points;
        if (pair_ranks[k] < PACK) {
          cell_slots[i] = batch * PACK + pair_ranks[k];
          continue;
        }
        left = 1u;
        cell_slots[i] = SCHEDULE_WAITS | points;
        schedule_flip(schedule_batches_of(contacts[i].body_a, body_infos, phase_batches), batch);
        schedule_flip(schedule_batches_of(contacts[i].body_b, body_infos, phase_batches), batch);
      }
      SCHEDULE_BARRIER;
      if (more) ++batch;
      more = left != 0u && batch < CELL_BATCHES;
      SCHEDULE_BARRIER;
    } while (more);
    for (u32 k = begin + id; k < end; k += size) {
      const u32 i = cell_pairs[k];
      if ((cell_slots[i] & SCHEDULE_STATE) == SCHEDULE_WAITS) cell_slots[i] = NONE;
    }
    if (id == 0u && cell < cells) {
      cell_blocks[cell] = batch;
      cell_rows[cell] = rows;
    }
    SCHEDULE_BARRIER;
    cell += (u32)get_num_groups(0);
  } while (cell < cells);
}
