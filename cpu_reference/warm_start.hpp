// Gives the bodies the impulses that the contacts start from, so that the solver only has to find the change since the
// last step.
#pragma once

#include "cpu_reference/joints/couplings.hpp"
#include "cpu_reference/joints/solve_joint.hpp"
#include "cpu_reference/sweep_contacts.hpp"

namespace lockstep::reference {

template <class real>
void warm_start(Buffers<real>& buffers, const StepParams<real>&) {
  if (step_aborted(buffers.counters)) return;
  start_joints(buffers);
  start_couplings(buffers);
  start_contacts(buffers);
}

}  // namespace lockstep::reference
