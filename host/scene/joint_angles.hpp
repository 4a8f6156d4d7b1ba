// The angles that joints count revolutions by, where no stage has counted them: at load, and where velocities are set.
#pragma once

#include <span>
#include <vector>

#include "host/buffers.hpp"

namespace lockstep {

/// By how much the angle of each joint grows in a sub-step of `dt` with the velocities that its bodies have, rad; 0 of
/// joints that count no revolutions.
template <class real>
std::vector<double> angles_of_substep(const Buffers<real>& buffers, double dt);

/// Makes joint_angles of the angles that joints have where their bodies are: the stages expect those of a sub-step
/// before, from which these velocities have led here (cpu_reference/joints/revolutions.hpp).
template <class real>
void set_joint_angles(std::span<const double> angles, double dt, Buffers<real>& buffers);

}  // namespace lockstep
