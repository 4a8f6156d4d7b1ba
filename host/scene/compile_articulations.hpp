// Joints that are solved directly: trees of the bodies that they hold (cpu_reference/articulations/).
#pragma once

#include "host/scene/compile.hpp"

namespace lockstep {

/// Whether it can solve trees of joints at once.
inline bool takes_trees(Solver solver) { return solver == Solver::gauss_seidel || solver == Solver::cell_gauss_seidel; }

/// All trees, or those in which some body carries ten times its own mass or more, which sweeps are slow at.
enum class Trees { all, that_carry };

/// Finds the articulations of a state that has all bodies and joints: trees of movable bodies, which start at those
/// that a joint holds to what cannot move, and else at the first body of what floats; and the joints that close loops
/// of one, where these are no more than MAX_CLOSURES. Springs (`frequency`) are in none. Marks the joints that sweeps
/// can leave out (JointInfo::direct): those that are in one and have no free coordinate, on which a motor or limits
/// might act.
template <class real>
void find_articulations(Trees trees, Buffers<real>& buffers);

/// Answers that the closures of articulations with so many links keep (Sizes::closure_columns).
u32 count_closure_columns(std::span<const ClosureSet> sets, u32 links);

/// Writes the slots of their joints, once these are laid out.
template <class real>
void set_link_joints(Buffers<real>& buffers);

}  // namespace lockstep
