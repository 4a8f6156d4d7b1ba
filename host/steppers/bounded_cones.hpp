// Contacts in cones beside limits, motors, dry friction and springs of joints, by the solvers of cone problems.
#pragma once

#include "cpu_reference/oracle/cone/solvers.hpp"
#include "host/steppers/system_problem.hpp"

namespace lockstep {

/// Gives a system, whose problem is `whole`, the impulses that the solver finds. Joints are eliminated; a limit is a
/// contact without friction; a motor or dry friction holds its speed or pushes with all that it has
/// (articulated/reduced_cones.hpp, which solves problems of this form in reduced coordinates). The report's residual is
/// that of the whole problem (joints/mixed.hpp).
oracle::SolveReport solve_bounded_cones(const oracle::ConeSolver& solver, const WholeSystemProblem& whole,
                                        ContactSystem& system, const oracle::SolveLimits& limits);

}  // namespace lockstep
