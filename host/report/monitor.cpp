#include "host/report/monitor.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace lockstep {

namespace {

// Of the inner radius: shapes that overlap by less do not.
constexpr double least_overlap = 0.01;

double maximum(std::span<const u32> counters, u32 counter) { return std::bit_cast<float>(counters[counter]); }

template <class real>
double energy(std::span<const u32> counters, u32 counter, const StepParams<real>& params) {
  const std::uint64_t units = std::uint64_t{counters[counter + 1]} << 32 | counters[counter];
  return double(static_cast<std::int64_t>(units)) / double(params.units_per_joule);
}

}  // namespace

Monitor::Monitor(const Verdict& bounds, double dt, const EnergyBudget& budget)
    : verdict_(bounds), budget_(budget), dt_(dt) {
  initial_.fill(-1);
  verdict_.energy_source = budget.source;
  restart(budget.power);
}

void Monitor::restart(double power) {
  budget_.power = power;
  least_energy_ = std::numeric_limits<double>::infinity();
}

void Monitor::note(Criterion criterion, double value, u32 step) {
  Judgement& judgement = verdict_[criterion];
  double& initial = initial_[static_cast<u32>(criterion)];
  if (initial < 0) {
    initial = value;
    judgement.bound = std::max(judgement.bound, 1.1 * initial);
  }
  if (value > judgement.bound) judgement.first_step = std::min(judgement.first_step, step);
  if (!(value > judgement.worst)) return;
  judgement.worst = value;
  judgement.worst_step = step;
}

// What began inside each other is pushed apart for as long as it comes apart, which takes energy.
void Monitor::note_separation(double overlap) {
  const bool is_first = std::isinf(last_overlap_);
  is_separating_ = (is_first || is_separating_) && overlap > least_overlap && overlap < last_overlap_;
  last_overlap_ = overlap;
}

void Monitor::note_energy(double energy, double kinetic, double seconds, u32 step) {
  const double of_its_own = energy - budget_.power * seconds;
  if (!budget_.has_springs || std::isinf(least_energy_)) least_energy_ = std::min(least_energy_, of_its_own);
  most_kinetic_ = std::max(most_kinetic_, kinetic);
  const double scale = most_kinetic_ + budget_.negligible, gain = of_its_own - least_energy_;
  note(Criterion::energy_gain, scale > 0 ? gain / scale : 0, step);
  if (is_separating_) least_energy_ = std::numeric_limits<double>::infinity();
}

template <class real>
void Monitor::observe(std::span<const u32> counters, const StepParams<real>& params, u32 steps_done) {
  note(Criterion::overlap, maximum(counters, COUNTER_MAX_OVERLAP_RATIO), steps_done);
  note(Criterion::joint_separation, maximum(counters, COUNTER_MAX_JOINT_SEPARATION_RATIO), steps_done);
  note(Criterion::joint_angle, maximum(counters, COUNTER_MAX_JOINT_ANGLE), steps_done);
  note(Criterion::speed, maximum(counters, COUNTER_MAX_SPEED), steps_done);
  overlap_m_ = std::max(overlap_m_, maximum(counters, COUNTER_MAX_OVERLAP));
  separation_m_ = std::max(separation_m_, maximum(counters, COUNTER_MAX_JOINT_SEPARATION));
  note_separation(maximum(counters, COUNTER_MAX_OVERLAP_RATIO));
  if (params.units_per_joule > 0)
    note_energy(energy(counters, COUNTER_ENERGY, params), energy(counters, COUNTER_KINETIC, params), dt_ * steps_done,
                steps_done);
}

void Monitor::observe(const Measures& measures, u32 steps_done) {
  double kinetic = 0;
  for (const WorldMeasures& world : measures.worlds) kinetic += world.kinetic;
  if (verdict_.energy_source == EnergySource::particles)  // whose stages tell no overlap
    note(Criterion::overlap, measures.penetration.ratio, steps_done);
  note(Criterion::speed, measures.max_speed, steps_done);
  overlap_m_ = std::max(overlap_m_, measures.penetration.max);
  if (measures.joint_drift) {
    note(Criterion::joint_separation, measures.joint_drift->ratio, steps_done);
    note(Criterion::joint_angle, measures.joint_drift->angle, steps_done);
    separation_m_ = std::max(separation_m_, measures.joint_drift->separation);
  }
  note_energy(measures.energy(), kinetic, dt_ * steps_done, steps_done);
}

bool Monitor::is_worse() {
  bool worse = false;
  for (u32 i = 0; i < criterion_count; ++i) {
    if (verdict_.keeps(static_cast<Criterion>(i)) || verdict_.judgements[i].worst <= 1.1 * last_reported_[i]) continue;
    last_reported_[i] = verdict_.judgements[i].worst;
    worse = true;
  }
  return worse;
}

template void Monitor::observe(std::span<const u32>, const StepParams<float>&, u32);
template void Monitor::observe(std::span<const u32>, const StepParams<double>&, u32);

}  // namespace lockstep
