// Watches a run step by step and comes to its verdict. What it looks at is measured where the step is computed, in the
// counters of the step (cpu_reference/measure.hpp); of the state that a run ends with, by measure().
#pragma once

#include <limits>
#include <span>

#include "host/energy_budget.hpp"
#include "host/report/measures.hpp"
#include "host/verdict.hpp"

namespace lockstep {

class Monitor {
 public:
  /// Bounds are those of `bounds`, or a tenth above what a figure is when it is first seen: nobody is blamed for how
  /// the run began. `dt` of a step, s.
  Monitor(const Verdict& bounds, double dt, const EnergyBudget& budget);

  /// The state that a step began with, when `steps_done` steps had been done. `params` are those of the step.
  template <class real>
  void observe(std::span<const u32> counters, const StepParams<real>& params, u32 steps_done);

  /// The state after so many steps; of its overlaps the contacts of the last step do not tell.
  void observe(const Measures& measures, u32 steps_done);

  /// Somebody acts on bodies or motors between steps: the energy that there is then is what they begin with. `power` is
  /// that of the motors, as in EnergyBudget.
  void restart(double power);
  /// What nobody sees from now on, as in EnergyBudget.
  void set_negligible(double joules) { budget_.negligible = joules; }
  /// From now on energy comes from where nobody counts it. Particles stay what it is not judged for.
  void add_source(EnergySource source) {
    if (verdict_.energy_source != EnergySource::particles) verdict_.energy_source = source;
  }

  /// Whether a figure is above its bound and a tenth above what it was when this last was true.
  bool is_worse();

  const Verdict& verdict() const { return verdict_; }
  double overlap_m() const { return overlap_m_; }        // the largest of two shapes
  double separation_m() const { return separation_m_; }  // and of the anchors of a joint
  double joint_angle() const { return verdict_[Criterion::joint_angle].worst; }

 private:
  void note(Criterion criterion, double value, u32 step);
  void note_separation(double overlap);
  void note_energy(double energy, double kinetic, double seconds, u32 step);

  Verdict verdict_;
  std::array<double, criterion_count> initial_;  // the figures that were seen first; negative before
  EnergyBudget budget_;
  double dt_;
  bool is_separating_ = false;  // what began inside each other
  double last_overlap_ = std::numeric_limits<double>::infinity();
  double least_energy_;      // of those that were seen, less what motors may have added until then, J
  double most_kinetic_ = 0;  // J
  double overlap_m_ = 0, separation_m_ = 0;
  std::array<double, criterion_count> last_reported_ = {};  // what they were when is_worse() last was true
};

}  // namespace lockstep
