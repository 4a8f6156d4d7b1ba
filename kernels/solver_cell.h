// The cells in which pairs in contact are solved. cpu_reference/solver_cell.hpp is the twin.
#ifndef LOCKSTEP_SOLVER_CELL_H
#define LOCKSTEP_SOLVER_CELL_H

#include "grid.h"

// Places for the cells of one phase of a sweep, those of all worlds; there are CELL_PHASES times as many in all.
static inline u32 cells_in_phase(const StepParams* params) { return params->bodies / CELL_BODIES + params->worlds; }

// The slots of a world in the first phase.
static inline u32 first_cell_of_world(u32 world, global const WorldRange* world_ranges) {
  return world_ranges[world].first_body / CELL_BODIES + world;
}
static inline u32 cells_of_world(u32 world, global const WorldRange* world_ranges) {
  return world_ranges[world].body_count / CELL_BODIES + 1u;
}

// Of what has no cell: the bodies that cannot move, and those beyond the numbers of cells.
#define CELL_OF_IMMOVABLE 0x7fffffff
#define CELL_BEYOND 0x7ffffffe

// Where the body stands. Its `bucket` means nothing.
static inline Cell cell_of_body(u32 body, global const BodyInfo* body_infos, global const Vec4* positions,
                                global const real* cell_sizes) {
  const Vec4 at = positions[body];
  const real size = cell_sizes[body_infos[body].world];
  Cell cell = {CELL_BEYOND, CELL_BEYOND, CELL_BEYOND, 0u};
  if (body_infos[body].kind != BODY_DYNAMIC) {
    cell.x = CELL_OF_IMMOVABLE;
  } else if (in_grid(at.x, size) && in_grid(at.y, size) && in_grid(at.z, size)) {
    cell.x = cell_of(at.x, size);
    cell.y = cell_of(at.y, size);
    cell.z = cell_of(at.z, size);
  }
  return cell;
}

static inline bool cells_are_next(i32 a, i32 b) { return (u32)a - (u32)b + 1u <= 2u; }

// The slot of the pair's cell among those of all phases and worlds; NONE where it is in no cell.
static inline u32 cell_of_pair(const StepParams* params, Contact contact, global const WorldRange* world_ranges,
                               global const Cell* body_cells) {
  Cell a = body_cells[contact.body_a], b = body_cells[contact.body_b];
  if (a.x == CELL_OF_IMMOVABLE) a = b;
  if (b.x == CELL_OF_IMMOVABLE) b = a;
  if (a.x >= CELL_BEYOND || b.x >= CELL_BEYOND) return NONE;
  if (!cells_are_next(a.x, b.x) || !cells_are_next(a.y, b.y) || !cells_are_next(a.z, b.z)) return NONE;
  const i32 x = min(a.x, b.x), y = min(a.y, b.y), z = min(a.z, b.z);
  const u32 phase = ((u32)x & 1u) + 2u * ((u32)y & 1u) + 4u * ((u32)z & 1u);
  const u32 hash = row_hash(y >> 1, z >> 1, 0u) + (u32)(x >> 1);
  return phase * cells_in_phase(params) + first_cell_of_world(contact.world, world_ranges) +
         hash % cells_of_world(contact.world, world_ranges);
}

#endif
