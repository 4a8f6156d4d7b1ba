// The state of a scene carried over to one with other bodies.
#pragma once

#include <span>

#include "host/scene/compile.hpp"

namespace lockstep {

/// Puts what lives on of a state into another: poses and velocities of the bodies that are in both, bit for bit, the
/// impulses of their contacts and joints, who touches, the step. `old` holds the constant buffers of the scene that was
/// and `persistent` its state; `new_body` and `new_joint` say which body or joint each of them has become, NONE where
/// it is gone. Those that stay keep their order and their shapes.
template <class real>
void migrate_state(const InitialState<real>& old, const Buffers<real>& persistent, std::span<const u32> new_body,
                   std::span<const u32> new_joint, InitialState<real>& state);

}  // namespace lockstep
