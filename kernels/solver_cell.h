// The cells in which pairs in contact are solved. cpu_reference/solver_cell.hpp is the twin.
#ifndef LOCKSTEP_SOLVER_CELL_H
#define LOCKSTEP_SOLVER_CELL_H

#include "grid.h"

// Places for the cells of one phase of a sweep, those of all worlds; there are CELL_PHASES times as many in all.
static inline u32 cells_in_phase(const StepParams params) { return params.bodies / CELL_BODIES + params.worlds; }

typedef struct CellRange {
  i32 low[3], high[3];
  bool movable;
} CellRange;

// False where the body is beyond the numbers of cells. What cannot move has no cell.
static inline bool cell_range_add(u32 body, real size, global const BodyInfo* body_infos, global const Vec4* positions,
                                  CellRange* range) {
  if (body_infos[body].kind != BODY_DYNAMIC) return true;
  const Vec4 at = positions[body];
  if (!in_grid(at.x, size) || !in_grid(at.y, size) || !in_grid(at.z, size)) return false;
  const i32 cell[3] = {cell_of(at.x, size), cell_of(at.y, size), cell_of(at.z, size)};
  for (u32 axis = 0u; axis < 3u; ++axis) {
    range->low[axis] = range->movable ? min(range->low[axis], cell[axis]) : cell[axis];
    range->high[axis] = range->movable ? max(range->high[axis], cell[axis]) : cell[axis];
  }
  range->movable = true;
  return true;
}

// The place of the pair's cell among those of all phases and worlds; NONE where it is in no cell.
static inline u32 cell_of_pair(const StepParams params, Contact contact, global const WorldRange* world_ranges,
                               global const BodyInfo* body_infos, global const Vec4* positions,
                               global const real* cell_sizes) {
  const real size = cell_sizes[contact.world];
  CellRange range = {{0, 0, 0}, {0, 0, 0}, false};
  if (!cell_range_add(contact.body_a, size, body_infos, positions, &range)) return NONE;
  if (!cell_range_add(contact.body_b, size, body_infos, positions, &range)) return NONE;
  if (!range.movable) return NONE;
  for (u32 axis = 0u; axis < 3u; ++axis)
    if ((u32)range.high[axis] - (u32)range.low[axis] > 1u) return NONE;

  const u32 phase = ((u32)range.low[0] & 1u) + 2u * ((u32)range.low[1] & 1u) + 4u * ((u32)range.low[2] & 1u);
  const u32 hash = row_hash(range.low[1] >> 1, range.low[2] >> 1, 0u) + (u32)(range.low[0] >> 1);
  const WorldRange world = world_ranges[contact.world];
  const u32 first = world.first_body / CELL_BODIES + contact.world, places = world.body_count / CELL_BODIES + 1u;
  return phase * cells_in_phase(params) + first + hash % places;
}

#endif
