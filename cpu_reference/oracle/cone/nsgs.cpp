// Non-smooth Gauss-Seidel (Jean and Moreau's contact dynamics; Jean 1999; survey 4.2.2): in a sweep each contact in
// turn gets the impulse that solves its own problem while the others keep theirs,
//   r_i <- solution of u_i = W_ii r_i + (q_i + sum_j W_ij r_j),  u^_i in K*, r_i in K.
#include <vector>

#include "cpu_reference/oracle/cone/local_cone.hpp"
#include "cpu_reference/oracle/cone/solvers.hpp"
#include "cpu_reference/oracle/cone/start.hpp"
#include "cpu_reference/oracle/cone/watch.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

Vector3d solve_contact(const LocalCone& cone, LocalSolver local, const Vector3d& q, const Vector3d& r) {
  switch (local) {
    case LocalSolver::enumeration: return cone.enumerate(q);
    case LocalSolver::splitting: return cone.split(q, r);
    case LocalSolver::exact: break;
  }
  return cone.solve(q);
}

}  // namespace

SolveReport nsgs(const ConeProblem& problem, const SolveLimits& limits, VectorXd& r, LocalSolver local) {
  Watch watch(problem, limits);
  VectorXd x = start_of(problem, r);
  const BlockMatrix& w = problem.w;
  std::vector<LocalCone> cones;
  std::vector<Eigen::Matrix3d> diagonal;
  for (std::uint32_t i = 0; i < problem.contacts(); ++i) {
    diagonal.push_back(w.symmetric_diagonal(i));
    cones.emplace_back(diagonal[i], problem.mu[i]);
  }

  for (std::uint32_t sweep = 1; !watch.look_seldom(x, sweep - 1); ++sweep) {
    for (std::uint32_t i = 0; i < problem.contacts(); ++i) {
      const Vector3d own = x.segment<3>(3 * i);
      const Vector3d q = problem.q.segment<3>(3 * i) + w.row_times(i, x) - diagonal[i] * own;
      x.segment<3>(3 * i) = solve_contact(cones[i], local, q, own);
    }
  }
  return watch.finish(r);
}

}  // namespace lockstep::oracle
