#include "cpu_reference/oracle/joints/mixed.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "cpu_reference/oracle/cone/watch.hpp"
#include "cpu_reference/oracle/joints/creep.hpp"
#include "cpu_reference/oracle/joints/mixed_state.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::VectorXd;

constexpr std::uint32_t patience = 400;       // looks
constexpr std::uint32_t joints_patience = 5;  // the same where all is solved at once
constexpr double sweep_accuracy = 1e-3;       // of joints by iteration: what one sweep leaves of them the next takes up
constexpr double single_accuracy = 1e-12;     // where joints are solved once, not in each sweep

constexpr std::array solvers = {
    MixedSolver{"mixed_ldlt", "contacts one by one, joints together along their tree (Baraff)", "ldlt", false},
    MixedSolver{"mixed_sparse", "the same, joints by a parallel sparse factorisation (CHOLMOD)", "sparse", false},
    MixedSolver{"mixed_pcg", "the same, joints by conjugate gradients", "pcg", false},
    MixedSolver{"mixed_ichol", "the same, with an incomplete Cholesky factorisation", "ichol", false},
    MixedSolver{"articulated", "contacts one by one, each felt by all that hangs on its bodies", "ldlt", true},
};

VectorXd stacked(const MixedImpulses& x) {
  VectorXd all(x.r.size() + x.l.size() + x.z.size());
  all << x.r, x.l, x.z;
  return all;
}

}  // namespace

std::span<const MixedSolver> mixed_solvers() { return solvers; }

const MixedSolver* find_mixed_solver(std::string_view name) {
  const auto found = std::ranges::find(solvers, name, &MixedSolver::name);
  return found == solvers.end() ? nullptr : &*found;
}

SolveReport solve_mixed(const MixedProblem& problem, const MixedSolver& solver, const SolveLimits& limits,
                        MixedImpulses& impulses) {
  if (problem.cones.dimension != 3) throw std::runtime_error("is in the plane, and mixed solvers work in space");
  const bool only_joints = problem.cones.mu.size() == 0 && problem.laws.empty();
  Progress progress(limits, only_joints ? joints_patience : patience);
  MixedState state(problem, joint_method(solver.joints), solver.articulated,
                   only_joints ? single_accuracy : sweep_accuracy, impulses);
  const auto parts = [&](const VectorXd& all) {
    const Eigen::Index contacts = problem.cones.h.cols(), joints = problem.cones.g.cols();
    return MixedImpulses{all.head(contacts), all.segment(contacts, joints), all.tail(problem.d.cols())};
  };
  Creep creep(problem.cones.mu);
  for (std::uint32_t sweep = 1;; ++sweep) {
    if (progress.is_due(sweep - 1)) {
      state.settle();
      const VectorXd x = stacked(state.impulses());
      if (progress.look(x, state.residual(), sweep - 1)) break;
      if (const auto further = creep.leap(x, progress.residual(), sweep - 1)) state.restart(parts(*further));
    }
    state.sweep();
    if (!solver.articulated) state.close_joints();
  }
  VectorXd best;
  const SolveReport report = progress.finish(best);
  impulses = parts(best);
  return report;
}

}  // namespace lockstep::oracle
