// The cells in which pairs in contact are solved (feature partitions): Harada, A Parallel Constraint Solver for a Rigid
// Body Simulation, SIGGRAPH Asia 2011 Sketches; survey, section 5. kernels/solver_cell.h is the twin.
//
// Space is cut into cubes. The cell of a body that can move is that of its centre of mass; the cell of a pair is, along
// each axis, the lower of those of its bodies. So the bodies of a cell's pairs stand in it or in the next one along an
// axis, and cells whose coordinates are odd along the same axes have no movable body in common: they are a phase of a
// sweep, one of eight, and are solved at once. Pairs whose bodies are farther apart are in no cell.
//
// A world has slots for its cells by the number of its bodies; a hash of a cell's coordinates says which. Cells of a
// phase that meet in a slot are solved as one, which they can be: they share no movable body either.
#pragma once

#include <algorithm>

#include "cpu_reference/grid.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// The slot of the pair's cell among those of all phases and worlds; NONE where it is in no cell.
template <class real>
u32 cell_of_pair(const Buffers<real>& b, const StepParams<real>& params, const Contact& contact) {
  const real size = b.cell_sizes[contact.world];
  bool movable = false;
  i32 low[3] = {}, high[3] = {};
  for (const u32 body : {contact.body_a, contact.body_b}) {
    if (b.body_infos[body].kind != BODY_DYNAMIC) continue;
    const Vec4<real>& at = b.positions[body];
    if (!in_grid(at.x, size) || !in_grid(at.y, size) || !in_grid(at.z, size)) return NONE;
    const i32 cell[3] = {cell_of(at.x, size), cell_of(at.y, size), cell_of(at.z, size)};
    for (u32 axis = 0; axis < 3; ++axis) {
      low[axis] = movable ? std::min(low[axis], cell[axis]) : cell[axis];
      high[axis] = movable ? std::max(high[axis], cell[axis]) : cell[axis];
    }
    movable = true;
  }
  if (!movable) return NONE;
  for (u32 axis = 0; axis < 3; ++axis)
    if (u32(high[axis]) - u32(low[axis]) > 1) return NONE;

  const u32 phase = (u32(low[0]) & 1) + 2 * (u32(low[1]) & 1) + 4 * (u32(low[2]) & 1);
  const u32 hash = row_hash(low[1] >> 1, low[2] >> 1, 0) + u32(low[0] >> 1);
  const WorldRange& world = b.world_ranges[contact.world];
  const u32 first = world.first_body / CELL_BODIES + contact.world, cells = world.body_count / CELL_BODIES + 1;
  return phase * cells_in_phase(params.bodies, params.worlds) + first + hash % cells;
}

}  // namespace lockstep::reference
