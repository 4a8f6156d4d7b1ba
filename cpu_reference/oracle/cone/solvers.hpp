// The solvers of frictional contact problems. Each takes a problem without joints (JointElimination takes them out),
// limits, and in `r` the impulses to start from (empty: zero); it leaves in `r` the best impulses that it saw, in the
// measure ResidualMeter::residual, and tells how it went. Problems may be of any rank, and empty.
#pragma once

#include <span>
#include <string_view>

#include "cpu_reference/oracle/cone_problem.hpp"
#include "cpu_reference/oracle/solve.hpp"

namespace lockstep::oracle {

/// How Gauss-Seidel solves the problem of one contact (local_cone.hpp).
enum class LocalSolver { exact, enumeration, splitting };

/// Blocked non-smooth Gauss-Seidel: contact after contact, each solved for the impulses of the others.
SolveReport nsgs(const ConeProblem& problem, const SolveLimits& limits, Eigen::VectorXd& r,
                 LocalSolver local = LocalSolver::exact);

/// Normal impulses for given friction and friction for given normal impulses in turn, each a quadratic programme.
SolveReport staggered(const ConeProblem& problem, const SolveLimits& limits, Eigen::VectorXd& r);

/// Projected gradient with line search; De Saxce's shift is renewed in each iteration.
SolveReport projected_gradient(const ConeProblem& problem, const SolveLimits& limits, Eigen::VectorXd& r);

/// Nesterov's accelerated projected gradient. `relaxed`: of the cone complementarity problem, without De Saxce's shift,
/// another model that lets sliding contacts lift; else the shift is renewed as soon as it is what limits the accuracy.
SolveReport accelerated_gradient(const ConeProblem& problem, const SolveLimits& limits, Eigen::VectorXd& r,
                                 bool relaxed = false);

/// Alternating direction method of multipliers with De Saxce's shift. Of fixed_metric_admm it stays at sigma =
/// 0.03, where impulses that velocities hardly feel move further, instead of being balanced on the way.
SolveReport admm(const ConeProblem& problem, const SolveLimits& limits, Eigen::VectorXd& r);
SolveReport fixed_metric_admm(const ConeProblem& problem, const SolveLimits& limits, Eigen::VectorXd& r);

/// Semi-smooth Newton on the function of Alart and Curnier.
SolveReport newton(const ConeProblem& problem, const SolveLimits& limits, Eigen::VectorXd& r);

/// Proximal point iteration: Newton's method on a sequence of problems with W + alpha.
SolveReport proximal_point(const ConeProblem& problem, const SolveLimits& limits, Eigen::VectorXd& r);

/// Starts with Gauss-Seidel and goes on with what gets further, each from the best so far.
SolveReport solve_automatically(const ConeProblem& problem, const SolveLimits& limits, Eigen::VectorXd& r);

struct ConeSolver {
  std::string_view name, description;
  SolveReport (*solve)(const ConeProblem&, const SolveLimits&, Eigen::VectorXd&);
};

/// All of them by name; `auto` is the first.
std::span<const ConeSolver> cone_solvers();

/// Null where there is none of this name.
const ConeSolver* find_cone_solver(std::string_view name);

}  // namespace lockstep::oracle
