// Contacts in Coulomb's cone, bounds and drives in reduced coordinates, by the solvers of cone problems.
#pragma once

#include "cpu_reference/oracle/articulated/reduced_problem.hpp"
#include "cpu_reference/oracle/cone/solvers.hpp"

namespace lockstep::oracle::articulated {

/// The problem as one of cones: a bound is a contact without friction, whose tangents are as mobile as it is and
/// coupled with nothing. Drives are not in it: they push with what they have in `impulses`, of all rows.
ConeProblem cone_problem(const ReducedProblem& problem, const VectorXd& impulses);
/// What of these is of cones, as that problem has them.
VectorXd cone_impulses(const ReducedProblem& problem, const VectorXd& impulses);

/// Impulses of all rows, from `r` on where that has the right size. Each drive holds its speed, or pushes with all its
/// reach; those that would have to reach farther, or push the wrong way, change over until none does (an active set):
/// the problem of cones between is solved with drives that hold eliminated. Where they hold a bound on its wrong side
/// one of them yields first. The report's residual is that of the last of these; where drives keep changing over it
/// ends with Stop::stalled and a residual of 1.
SolveReport solve_reduced_cones(const ConeSolver& solver, const ReducedProblem& problem, const SolveLimits& limits,
                                VectorXd& r);

}  // namespace lockstep::oracle::articulated
