#include <algorithm>
#include <cmath>

#include "host/report/report.hpp"
#include "host/world_hash.hpp"

namespace lockstep {

namespace {

// The value that `share` of the sorted values do not exceed (nearest rank).
double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  return values[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

// The largest deviation of a run beside the largest size of what deviated.
struct Deviation {
  double largest = 0, size = 0;

  void add(double deviation, double magnitude) {
    largest = std::max(largest, deviation);
    size = std::max(size, magnitude);
  }
  double relative() const { return size > 0 ? largest / size : 0; }
};

// A finalizer with good avalanche (MurmurHash3), so that the order of the worlds counts.
std::uint64_t mix(std::uint64_t h) {
  h = (h ^ (h >> 33)) * 0xff51afd7ed558ccdu;
  h = (h ^ (h >> 33)) * 0xc4ceb9fe1a85ec53u;
  return h ^ (h >> 33);
}

}  // namespace

void Recorder::time(double milliseconds, u32 contacts) {
  milliseconds_.push_back(milliseconds);
  contacts_max_ = std::max(contacts_max_, contacts);
}

void Recorder::observe(u32 step, double seconds, Measures measures) {
  observations_.push_back({step, seconds, std::move(measures)});
}

void Recorder::finish(Report& report) const {
  finish_speed(report);
  finish_contacts(report);
  report.steps_measured = static_cast<u32>(observations_.size());
  report.energy_initial_j = initial_.energy();
  report.energy_final_j = observations_.empty() ? initial_.energy() : observations_.back().measures.energy();
  report.momentum_error = momentum_error();
  report.energy_error = energy_error();
  for (const Observation& o : observations_) {
    if (o.measures.pivot_drift)
      report.joint_drift_max_m = std::max(report.joint_drift_max_m.value_or(0), *o.measures.pivot_drift);
    if (!o.measures.joint_drift) continue;
    const JointDrift& drift = *o.measures.joint_drift;
    report.joint_drift_max_m = std::max(report.joint_drift_max_m.value_or(0), drift.separation);
    report.joint_angle_max_rad = std::max(report.joint_angle_max_rad.value_or(0), drift.angle);
  }
}

void Recorder::finish_speed(Report& report) const {
  report.contacts_max = contacts_max_;
  if (milliseconds_.empty()) return;
  report.ms_first_step = milliseconds_.front();
  for (const double ms : milliseconds_) report.ms_total += ms;
  const bool alone = milliseconds_.size() == 1;
  const std::vector<double> warm(milliseconds_.begin() + (alone ? 0 : 1), milliseconds_.end());
  report.ms_per_step_median = percentile(warm, 0.5);
  report.ms_per_step_p99 = percentile(warm, 0.99);
  if (sweeps_.empty()) return;
  report.sweeps_median = percentile(sweeps_, 0.5);
  report.sweeps_max = percentile(sweeps_, 1);
}

void Recorder::finish_contacts(Report& report) const {
  std::vector<double> residuals, model_errors;
  double depths = 0, touching = 0;
  for (const Observation& o : observations_) {
    const Penetration& p = o.measures.penetration;
    report.max_penetration_m = std::max(report.max_penetration_m, p.max);
    depths += p.mean * p.touching;
    touching += p.touching;

    const std::optional<Residual>& r = o.measures.residual;
    if (!r) continue;
    residuals.push_back(r->relative);
    if (r->model_error) model_errors.push_back(*r->model_error);
    report.residual_floor = std::max(report.residual_floor.value_or(0), r->rounding);
    report.natural_map_max = std::max(report.natural_map_max.value_or(0), r->natural_map);
    if (!report.defect_velocity_max || r->defect_max > *report.defect_velocity_max) {
      report.defect_velocity_max = r->defect_max;
      report.worst = o.measures.worst;
      report.worst_step = o.step;
    }
  }
  if (touching > 0) report.mean_penetration_m = depths / touching;
  if (residuals.empty()) return;
  report.residual_median = percentile(residuals, 0.5);
  report.residual_max = percentile(residuals, 1);
  if (!model_errors.empty()) report.model_error = percentile(model_errors, 0.5);
}

std::optional<double> Recorder::momentum_error() const {
  if (!conserves_momentum_) return std::nullopt;
  double error = 0;
  for (std::size_t w = 0; w < initial_.worlds.size(); ++w) {
    const WorldMeasures& start = initial_.worlds[w];
    Deviation linear, angular;
    linear.add(0, start.momentum_size);
    angular.add(0, start.angular_momentum_size);
    for (const Observation& o : observations_) {
      const WorldMeasures& current = o.measures.worlds[w];
      linear.add((current.momentum - start.momentum - o.seconds * start.weight).norm(), current.momentum_size);
      angular.add((current.angular_momentum - start.angular_momentum).norm(), current.angular_momentum_size);
    }
    error = std::max({error, linear.relative(), angular.relative()});
  }
  return error;
}

std::optional<double> Recorder::energy_error() const {
  if (!conserves_energy_) return std::nullopt;
  Deviation deviation;
  const auto kinetic = [](const Measures& measures) {
    double sum = 0;
    for (const WorldMeasures& world : measures.worlds) sum += world.kinetic;
    return sum;
  };
  deviation.add(0, kinetic(initial_));
  for (const Observation& o : observations_)
    deviation.add(std::abs(o.measures.energy() - initial_.energy()), kinetic(o.measures));
  return deviation.relative();
}

std::uint64_t combined_state_hash(std::span<const WorldHash> worlds) {
  std::uint64_t hash = 0;
  for (const WorldHash& world : worlds) hash = mix(hash) ^ state_hash(world);
  return hash;
}

std::uint64_t combined_pose_hash(std::span<const WorldHash> worlds) {
  std::uint64_t hash = 0;
  for (const WorldHash& world : worlds) hash = mix(hash) ^ pose_hash(world);
  return hash;
}

}  // namespace lockstep
