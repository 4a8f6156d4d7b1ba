// Solves the contact problem by sweeps of blocked projected Gauss-Seidel (cpu_reference/solve_contact.hpp) in the fixed
// order of colours: pairs of one colour share no movable body, so that their order within it cannot matter. In scenes
// solved by Jacobi's method a sweep solves all pairs at once (cpu_reference/body_copies.hpp), after the joints. Scenes
// that are solved along a gradient, or by the dense matrix, have a schedule of their own
// (cpu_reference/gradient/solve_by_gradient.hpp, cpu_reference/solve_dense.hpp).
//
// Joints that are solved directly come first in each sweep, all those of a tree at once
// (cpu_reference/articulations/solve_links.hpp); motors, limits and what closes a loop are left to the sweep.
//
// With a tolerance the first sweep in which no solve changes a relative velocity by more is the last of its sub-step. A
// solve changes it by as much as its law was violated before, so that this measures what a sweep still finds to do; the
// maximum over all solves does not depend on their order. A sub-step without such a sweep is left unsolved, and
// counted.
#pragma once

#include <cmath>

#include "cpu_reference/articulations/solve_links.hpp"
#include "cpu_reference/gradient/solve_by_gradient.hpp"
#include "cpu_reference/joints/couplings.hpp"
#include "cpu_reference/joints/solve_joint.hpp"
#include "cpu_reference/solve_dense.hpp"
#include "cpu_reference/sweep_contacts.hpp"

namespace lockstep::reference {

template <class real>
void solve_constraints(Buffers<real>& buffers, const StepParams<real>& params) {
  if (step_aborted(buffers.counters)) return;
  if (!buffers.gradient_laws.empty()) return GradientDescent<real>(buffers, params).run();
  if (!buffers.contact_tiles.empty()) return DenseSweeps<real>(buffers).run(params);
  for (u32 sweep = 0; sweep < params.iterations; ++sweep) {
    const real of_articulations = solve_articulations(buffers);
    const real of_joints = larger(sweep_joints(Purpose::solve, buffers), of_articulations);
    const real of_couplings = larger(sweep_couplings(Purpose::solve, buffers), of_joints);
    const real change = larger(sweep_contacts(Purpose::solve, buffers), of_couplings);
    if (!(params.tolerance > 0)) continue;
    ++buffers.counters[COUNTER_SWEEPS];
    if (real(float(std::sqrt(change))) <= params.tolerance) return;
  }
  if (params.tolerance > 0) ++buffers.counters[COUNTER_UNSOLVED];
}

}  // namespace lockstep::reference
