#pragma OPENCL FP_CONTRACT OFF
// Sorts the pairs in contact into the cells in which they are solved (cpu_reference/partition_contacts.hpp).
#include "common.h"
#include "pair_contacts.h"
#include "solver_cell.h"
#include "sort.h"
#include "types.h"

kernel void partition_clear(const StepParams params, global u32* cell_starts, global u32* cell_pairs,
                            global const u32* counters) {
  FOR_EACH(k, CELL_PHASES * cells_in_phase(params) + 1u) cell_starts[k] = 0u;
  FOR_EACH(i, counters[COUNTER_CONTACTS]) cell_pairs[i] = NONE;
}

// The order of arrival in a cell depends on the scheduling; partition_order makes up for it.
kernel void partition_count(const StepParams params, global const WorldRange* world_ranges,
                            global const BodyInfo* body_infos, global const Vec4* positions,
                            global const real* cell_sizes, global const Contact* contacts, global u32* cell_starts,
                            global u32* pair_cells, global u32* pair_arrivals, global const u32* counters) {
  FOR_EACH(i, counters[COUNTER_CONTACTS]) {
    u32 cell = NONE;
    if (pair_contact_is_first(contacts, i))
      cell = cell_of_pair(params, contacts[i], world_ranges, body_infos, positions, cell_sizes);
    if (cell != NONE) pair_arrivals[i] = atomic_inc(&cell_starts[cell]);
    pair_cells[i] = cell;
  }
}

kernel void partition_fill(global const u32* cell_starts, global const u32* pair_cells, global const u32* pair_arrivals,
                           global u32* cell_pairs, global const u32* counters) {
  FOR_EACH(i, counters[COUNTER_CONTACTS]) {
    const u32 cell = pair_cells[i];
    if (cell != NONE) cell_pairs[cell_starts[cell] + pair_arrivals[i]] = i;
  }
}

kernel void partition_order(const StepParams params, global const u32* cell_starts, global u32* cell_pairs) {
  FOR_EACH(cell, CELL_PHASES * cells_in_phase(params)) {
    const u32 start = cell_starts[cell];
    sort_ascending(cell_pairs + start, cell_starts[cell + 1u] - start);
  }
}
