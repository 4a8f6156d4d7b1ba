// The oracles that solve a step of articulated bodies in reduced coordinates, by name: cones, and friction pyramids as
// complementarity problems.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cpu_reference/oracle/articulated/reduced_problem.hpp"
#include "cpu_reference/oracle/solve.hpp"

namespace lockstep {

/// Finds the impulses of what a demand asks of a step, from those given on: `impulses` are of the rows of the problem,
/// which is made on the way. Returns how it went; the residual is in the measure of the model that was solved. Throws
/// Error (input) that starts with `where` for a problem that is too large.
struct ReducedSolution {
  oracle::articulated::ReducedProblem problem;
  Eigen::VectorXd impulses;
  oracle::SolveReport report;
};
using ReducedSolver =
    std::function<ReducedSolution(const oracle::articulated::Step& step, const oracle::articulated::Demand& demand,
                                  const Eigen::VectorXd& start, const oracle::SolveLimits&, const std::string& where)>;

/// reduced_NAME of cone solvers; reduced_pyramid_NAME of solvers of complementarity problems (Model-DCA-LCP);
/// reduced_mlcp1_fischer_newton and reduced_mlcp2_fischer_newton, which takes mixed problems.
std::vector<std::string> reduced_solver_names();

/// `directions`: sides of the friction pyramid, at least 3. Empty where there is none of this name.
ReducedSolver find_reduced_solver(const std::string& name, int directions);

}  // namespace lockstep
