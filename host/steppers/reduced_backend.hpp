// The reference with articulated bodies in reduced coordinates in the place of joints that are solved and closed
// (docs/theory/oracles.md).
#pragma once

#include <memory>
#include <optional>

#include "host/report/measures.hpp"
#include "host/steppers/oracle_backend.hpp"
#include "host/steppers/reduced_solvers.hpp"
#include "host/steppers/reduced_system.hpp"

namespace lockstep {

/// Runs the stages of the reference but for the bodies that joints hold: their velocities, impulses and poses are those
/// of a Step in reduced coordinates, from their poses and velocities at the start of each sub-step, so that the state
/// of the simulation is in the buffers alone. Stages that start joints from old impulses or close them have nothing to
/// do. For states as OracleBackend takes them. Throws Error (input) for joints that are soft on purpose.
class ReducedBackend final : public OracleBackend {
 public:
  ReducedBackend(InitialState<double> state, ReducedSolver solver, bool profile = false);

  /// How well the last sub-step's cones were solved, in reduced coordinates, limits counted as contacts; nothing before
  /// the first. Its `worst` is a contact, or a joint that has limits.
  std::optional<Residual> residual() const;
  /// Where that is.
  WorstContact worst_contact(const Residual& residual);
  void take_own_residual(Measures& measures) override;
  void restore(SavedBuffers& saved) override;
  /// The largest error of a closure after the last sub-step, m or rad.
  double open() const { return open_; }

 private:
  void work(Stage stage, const StepParams<double>& params) override;
  void start(const StepParams<double>& params);
  void solve(const StepParams<double>& params);
  void finish();
  void write_twists(const std::vector<oracle::articulated::Vector6>& twists, bool links_only);
  void write_impulses(const ContactSystem& system);

  const ReducedSolver solver_;
  const oracle::articulated::System system_;
  const oracle::articulated::Tree tree_;
  const oracle::articulated::Laws laws_;
  std::unique_ptr<oracle::articulated::Step> step_;
  oracle::articulated::Demand demand_;
  std::optional<ReducedSolution> solution_;
  double open_ = 0;
};

}  // namespace lockstep
