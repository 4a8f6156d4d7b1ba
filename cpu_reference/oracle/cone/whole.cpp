#include "cpu_reference/oracle/cone/whole.hpp"

#include <algorithm>

namespace lockstep::oracle {

// Without its joints a contact is less mobile, and U another velocity, so that a residual is not the same with them and
// without. What is missing in the one is asked for in the other.
ConeSolution solve_whole(const ConeProblem& problem, const ConeSolver& solver, const SolveLimits& limits,
                         const Eigen::VectorXd& r) {
  const JointElimination elimination(problem);
  ConeSolution solution;
  solution.r = r;
  solution.beyond_joints = elimination.beyond_joints();
  SolveLimits left = limits;
  for (int attempt = 0; attempt < 5; ++attempt) {
    const SolveReport inner = solver.solve(elimination.reduced(), left, solution.r);
    SolveReport& sum = solution.report;
    sum.stop = inner.stop;
    sum.iterations += inner.iterations;
    sum.residuals.insert(sum.residuals.end(), inner.residuals.begin(), inner.residuals.end());
    sum.seconds += inner.seconds;
    solution.l = elimination.joint_impulses(solution.r);
    solution.error = cone_error(problem, solution.r, solution.l);
    sum.residual = solution.error.residual;
    if (inner.stop != Stop::solved || sum.residual <= limits.tolerance) break;
    sum.stop = Stop::stalled;
    left.tolerance *= std::min(0.5, 0.5 * limits.tolerance / sum.residual);
    left.iterations -= std::min(left.iterations, inner.iterations);
    left.seconds -= inner.seconds;
  }
  if (solution.report.residual <= limits.tolerance) solution.report.stop = Stop::solved;
  return solution;
}

}  // namespace lockstep::oracle
