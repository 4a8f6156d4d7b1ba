#include "cpu_reference/oracle/joints/mixed.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <stdexcept>

#include "cpu_reference/oracle/cone/watch.hpp"
#include "cpu_reference/oracle/joints/contradiction.hpp"
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
    MixedSolver{"mixed_articulated", "contacts one by one, each felt by all that hangs on its bodies", "ldlt", true},
};

bool is_of_joints_alone(const MixedProblem& problem) { return problem.cones.mu.size() == 0 && problem.laws.empty(); }

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

MixedSweeps::MixedSweeps(const MixedProblem& problem, const MixedSolver& solver, MixedImpulses start)
    : problem_(problem), solver_(solver) {
  if (problem.cones.dimension != 3) throw std::runtime_error("is in the plane, and mixed solvers work in space");
  state_ =
      std::make_unique<MixedState>(problem, joint_method(solver.joints), solver.articulated,
                                   is_of_joints_alone(problem) ? single_accuracy : sweep_accuracy, std::move(start));
}

MixedSweeps::~MixedSweeps() = default;

const MixedImpulses& MixedSweeps::impulses() const { return state_->impulses(); }
VectorXd MixedSweeps::joint_rates() const { return problem_.cones.g.transpose() * state_->velocity(); }
VectorXd MixedSweeps::row_rates() const { return problem_.d.transpose() * state_->velocity(); }

SolveReport MixedSweeps::run(const SolveLimits& limits) {
  Progress progress(limits, is_of_joints_alone(problem_) ? joints_patience : patience);
  const auto unstacked = [&](const VectorXd& all) {
    const Eigen::Index contacts = problem_.cones.h.cols(), joints = problem_.cones.g.cols();
    return MixedImpulses{all.head(contacts), all.segment(contacts, joints), all.tail(problem_.d.cols())};
  };
  Creep creep(problem_.cones.mu);
  state_->close_joints();
  for (std::uint32_t sweep = 1;; ++sweep) {
    if (progress.is_due(sweep - 1)) {
      state_->settle();
      const VectorXd x = stacked(state_->impulses());
      if (progress.look(x, state_->residual(), sweep - 1)) break;
      if (const auto further = creep.leap(x, progress.residual(), sweep - 1)) {
        state_->set(unstacked(*further));
        state_->close_joints();
      }
    }
    state_->sweep();
    if (!solver_.articulated) state_->close_joints();
  }
  VectorXd best;
  SolveReport report = progress.finish(best);
  state_->set(unstacked(best));
  if (report.stop == Stop::stalled && proves_contradiction(problem_.cones, state_->beyond_joints()))
    report.stop = Stop::infeasible;
  return report;
}

SolveReport solve_mixed(const MixedProblem& problem, const MixedSolver& solver, const SolveLimits& limits,
                        MixedImpulses& impulses) {
  const auto start = std::chrono::steady_clock::now();
  MixedSweeps sweeps(problem, solver, impulses);
  SolveReport report = sweeps.run(limits);
  impulses = sweeps.impulses();
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace lockstep::oracle
