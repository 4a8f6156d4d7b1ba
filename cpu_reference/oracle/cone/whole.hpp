// A problem as it comes, with its joints: they are taken out, the rest is solved, and all of it measured.
#pragma once

#include "cpu_reference/oracle/cone/solvers.hpp"
#include "cpu_reference/oracle/error.hpp"

namespace lockstep::oracle {

struct ConeSolution {
  Eigen::VectorXd r, l;                // impulses of contacts and of joints
  ConeError error;                     // of the whole problem
  SolveReport report;                  // its residual is that of the whole problem
  Eigen::VectorXd beyond_joints = {};  // what may prove that joints contradict each other (joints/contradiction.hpp)
};

/// Starts from the impulses `r` of the contacts (empty: zero). Where joints contradict each other it ends stalled, with
/// impulses that keep them as well as can be.
ConeSolution solve_whole(const ConeProblem& problem, const ConeSolver& solver, const SolveLimits& limits,
                         const Eigen::VectorXd& r = {});

}  // namespace lockstep::oracle
