// The reference with an oracle in the place of its sweeps: step-level truth (docs/theory/oracles.md).
#pragma once

#include "host/backends/reference_backend.hpp"
#include "host/steppers/system_solvers.hpp"

namespace lockstep {

/// Runs every stage as the reference does but `solve_constraints`: there the constraint system as it stands is solved,
/// to a residual of StepParams::tolerance and in StepParams::iterations at most, and the impulses are applied. For
/// states compiled with Solver::gauss_seidel and FrictionModel::cones: hard contacts, each in a cone. COUNTER_SWEEPS
/// counts the oracle's iterations.
class OracleBackend : public ReferenceBackend<double> {
 public:
  OracleBackend(InitialState<double> state, SystemSolver solver, bool profile = false)
      : ReferenceBackend(std::move(state), profile), solver_(std::move(solver)) {}

  /// Throws Stopped where the program was asked to end before the last system of a step was solved: the state is then
  /// that before the step.
  void run(Stage stage, const StepParams<double>& params) override;
  Unsolved unsolved() const override { return unsolved_; }
  void set_unsolved(const Unsolved& unsolved) override { unsolved_ = unsolved; }

 protected:
  /// A system gets 60 s. Throws what the solver does.
  void work(Stage stage, const StepParams<double>& params) override;

  static oracle::SolveLimits limits_of(const StepParams<double>& params);
  /// Counts what a solve took, and whether it got to where it was to get.
  void note(const oracle::SolveReport& report, const StepParams<double>& params);
  /// Gives a contact of the buffers its impulse on a, world frame, N s.
  void write_impulse(const SystemContact& contact, const Eigen::Vector3d& impulse);
  /// Gives the buffers that a system was made from its velocities and impulses.
  void write_back(const ContactSystem& system);

 private:
  /// Gives the system its impulses and velocities.
  virtual oracle::SolveReport solve_system(ContactSystem& system, const StepParams<double>& params,
                                           const std::string& where);

  const SystemSolver solver_;
  Unsolved unsolved_, unsolved_before_;
  Buffers<double> before_;  // the persistent ones, as they were at the start of the step
};

}  // namespace lockstep
