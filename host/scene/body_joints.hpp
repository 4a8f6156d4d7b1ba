// The joints of each body.
#pragma once

#include "host/buffers.hpp"

namespace lockstep {

/// Writes body_joint_starts and body_joints from the joints and their lanes.
template <class real>
void list_body_joints(Buffers<real>& b);

/// Writes planar_joints: of each body that rigid planar joints tie to what cannot move, the first.
template <class real>
void list_planar_joints(Buffers<real>& b);

}  // namespace lockstep
