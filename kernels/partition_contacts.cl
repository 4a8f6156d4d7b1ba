#pragma OPENCL FP_CONTRACT OFF
// Sorts the pairs in contact into the cells in which they are solved (cpu_reference/partition_contacts.hpp). Cells are
// filled in the order of the list by one work-item a world, on a device with few threads; or by all as they arrive, and
// put in order then.
#include "common.h"
#include "pair_contacts.h"
#include "solver_cell.h"
#include "sort.h"
#include "types.h"

// The cells of the bodies, and empty ones of the pairs.
kernel void partition_bodies(const StepParams params, global const BodyInfo* body_infos, global const Vec4* positions,
                             global const real* cell_sizes, global Cell* body_cells, global u32* cell_starts,
                             global u32* cell_pairs, global const u32* counters) {
  FOR_EACH(body, params.bodies) body_cells[body] = cell_of_body(body, body_infos, positions, cell_sizes);
  FOR_EACH(k, CELL_PHASES * cells_in_phase(&params) + 1u) cell_starts[k] = 0u;
  FOR_EACH(i, counters[COUNTER_CONTACTS]) cell_pairs[i] = NONE;
}

kernel void partition_count(const StepParams params, global const WorldRange* world_ranges,
                            global const Cell* body_cells, global const Contact* contacts, global u32* cell_starts,
                            global u32* pair_cells, global u32* pair_arrivals, global const u32* counters) {
  FOR_EACH(i, counters[COUNTER_CONTACTS]) {
    u32 cell = NONE;
    if (pair_contact_is_first(contacts, i)) cell = cell_of_pair(&params, contacts[i], world_ranges, body_cells);
    if (cell != NONE) pair_arrivals[i] = atomic_inc(&cell_starts[cell]);
    pair_cells[i] = cell;
  }
}

kernel void partition_fill_worlds(const StepParams params, global const WorldRange* world_ranges,
                                  global const Contact* contacts, global const u32* cell_starts,
                                  global const u32* pair_cells, global u32* cell_ends, global u32* cell_pairs,
                                  global const u32* counters) {
  FOR_EACH(world, params.worlds) {
    const u32 begin = first_cell_of_world(world, world_ranges), in_phase = cells_in_phase(&params);
    for (u32 phase = 0u; phase < CELL_PHASES; ++phase) {
      for (u32 k = 0u; k < cells_of_world(world, world_ranges); ++k)
        cell_ends[phase * in_phase + begin + k] = cell_starts[phase * in_phase + begin + k];
    }
    const u32 end = first_contact_of_world(world + 1u, counters[COUNTER_CONTACTS], contacts);
    for (u32 i = first_contact_of_world(world, counters[COUNTER_CONTACTS], contacts); i < end; ++i) {
      const u32 cell = pair_cells[i];
      if (cell != NONE) cell_pairs[cell_ends[cell]++] = i;
    }
  }
}

// The order of arrival in a cell depends on the scheduling; partition_order makes up for it.
kernel void partition_fill(global const u32* cell_starts, global const u32* pair_cells, global const u32* pair_arrivals,
                           global u32* cell_pairs, global const u32* counters) {
  FOR_EACH(i, counters[COUNTER_CONTACTS]) {
    const u32 cell = pair_cells[i];
    if (cell != NONE) cell_pairs[cell_starts[cell] + pair_arrivals[i]] = i;
  }
}

kernel void partition_order(const StepParams params, global const u32* cell_starts, global u32* cell_pairs) {
  FOR_EACH(cell, CELL_PHASES * cells_in_phase(&params)) {
    const u32 start = cell_starts[cell];
    sort_ascending(cell_pairs + start, cell_starts[cell + 1u] - start);
  }
}
