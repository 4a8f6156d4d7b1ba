// Joints that are solved directly: trees of the bodies that they hold (cpu_reference/articulations/).
#pragma once

#include "host/scene/compile.hpp"

namespace lockstep {

/// Finds the articulations of a state that has all bodies and joints: trees of movable bodies, which start at those
/// that a joint holds to what cannot move, and else at the first body of what floats. Springs (`frequency`) and joints
/// that close a loop are in none. Marks the joints that sweeps can leave out (JointInfo::direct): those that are in one
/// and have no free coordinate, on which a motor or limits might act.
template <class real>
void find_articulations(Buffers<real>& buffers);

/// Writes the slots of their joints, once these are laid out.
template <class real>
void place_link_joints(Buffers<real>& buffers);

}  // namespace lockstep
