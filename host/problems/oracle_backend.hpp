// The reference with an oracle in the place of its sweeps: step-level truth (docs/solvers_oracle.md).
#pragma once

#include <memory>

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

  /// Gives the system its impulses and velocities.
  virtual oracle::SolveReport solve(ContactSystem& system, const StepParams<double>& params,
                                    const oracle::SolveLimits& limits, const std::string& where);

 private:
  const SystemSolver solver_;
  Unsolved unsolved_;
};

/// Velocities and impulses of a system, which was made from the same buffers.
void write_back(const ContactSystem& system, Buffers<double>& buffers);

/// All that can take the place of the sweeps: system_solver_names(), and impulse_based (impulse_backend.hpp).
std::vector<std::string> oracle_names();

/// `name`: one of them; `directions`: as for find_system_solver().
std::unique_ptr<OracleBackend> make_oracle_backend(InitialState<double> state, const std::string& name, int directions,
                                                   bool profile = false);

}  // namespace lockstep
