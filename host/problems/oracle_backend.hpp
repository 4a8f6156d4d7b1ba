// The reference with an oracle in the place of its sweeps: step-level truth (docs/solvers_oracle.md).
#pragma once

#include "host/backends/reference_backend.hpp"
#include "host/problems/system_solvers.hpp"

namespace lockstep {

/// The sub-steps that an oracle left with a residual larger than what was asked for, and the worst of them.
struct Unsolved {
  u32 count = 0, worst_step = 0;
  double worst_residual = 0;
  oracle::Stop worst_stop = oracle::Stop::tolerance;
};

/// "left more than a residual of 1e-10 in 3 sub-steps, 2e-9 at worst in step 7 (iterations)".
std::string in_words(const Unsolved& unsolved, double tolerance);

/// Makes settings those of an oracle: double, hard contacts in cones, a residual of 1e-10 in 100,000 iterations at
/// most.
void use_oracle(Settings& settings);

/// Runs every stage as the reference does but `solve_constraints`: there the constraint system as it stands is solved,
/// to a residual of StepParams::tolerance and in StepParams::iterations at most, and the impulses are applied. For
/// states compiled with Solver::gauss_seidel and FrictionModel::cones: hard contacts, each in a cone. COUNTER_SWEEPS
/// counts the oracle's iterations.
class OracleBackend : public ReferenceBackend<double> {
 public:
  OracleBackend(InitialState<double> state, SystemSolver solver, bool profile = false)
      : ReferenceBackend(std::move(state), profile), solver_(std::move(solver)) {}

  const Unsolved& unsolved() const { return unsolved_; }

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
  Unsolved unsolved_;
};

}  // namespace lockstep
