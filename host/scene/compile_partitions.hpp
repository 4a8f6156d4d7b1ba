// The sizes of the cells of `cell_gauss_seidel` (cpu_reference/solver_cell.hpp).
#pragma once

#include "host/scene/compile.hpp"

namespace lockstep {

/// The size of the cells of each world, m, into a state that has all bodies and shapes: `settings.cell_size`, or a
/// multiple of the width of the bodies that can move, the median.
template <class real>
void compile_partitions(std::span<const Scene> worlds, InitialState<real>& state);

}  // namespace lockstep
