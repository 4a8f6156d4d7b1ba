#include "host/app/worlds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "host/device/devices.hpp"
#include "host/error.hpp"
#include "host/world_hash.hpp"

namespace lockstep::app {

namespace {

constexpr double most_bodies_of_batch = 50e6;
constexpr double none = std::numeric_limits<double>::quiet_NaN();

// Errors, of which a report of several ranks has the worst.
std::array<std::optional<double>*, 13> worst_figures(Report& report) {
  return {&report.residual_median,       &report.residual_max,      &report.residual_floor,
          &report.natural_map_max,       &report.joint_drift_max_m, &report.joint_angle_max_rad,
          &report.momentum_error,        &report.energy_error,      &report.model_error,
          &report.sweeps_median,         &report.sweeps_max,        &report.particle_center_error_m,
          &report.particle_inertia_error};
}

// And what is counted, of which it has the sum.
std::array<std::optional<double>*, 4> summed_figures(Report& report) {
  return {&report.particles, &report.asleep, &report.islands_asleep, &report.wakings};
}

// What rank 0 has to know of the reports of others. A figure that does not apply is NaN.
struct Figures {
  u32 worlds, bodies, joints, contacts_max, steps, steps_redone;
  u32 interrupted, bit_exact;
  double ms_median, ms_p99, ms_first, ms_total;
  double max_penetration, mean_penetration, energy_initial, energy_final;
  double defect;
  std::array<double, std::tuple_size_v<decltype(worst_figures(std::declval<Report&>()))>> worst_of;
  std::array<double, std::tuple_size_v<decltype(summed_figures(std::declval<Report&>()))>> sums_of;
  Verdict verdict;
  WorstContact worst;  // where it was, by worlds of the rank
  u32 worst_step;
};

Figures figures_of(Report report) {
  Figures f = {};
  f.worlds = report.worlds;
  f.bodies = report.bodies;
  f.joints = report.joints;
  f.contacts_max = report.contacts_max;
  f.steps = report.steps;
  f.steps_redone = report.steps_redone;
  f.interrupted = report.interrupted;
  f.bit_exact = report.bit_exact;
  f.ms_median = report.ms_per_step_median;
  f.ms_p99 = report.ms_per_step_p99;
  f.ms_first = report.ms_first_step;
  f.ms_total = report.ms_total;
  f.max_penetration = report.max_penetration_m;
  f.mean_penetration = report.mean_penetration_m;
  f.energy_initial = report.energy_initial_j;
  f.energy_final = report.energy_final_j;
  const auto figures = worst_figures(report);
  for (std::size_t i = 0; i < figures.size(); ++i) f.worst_of[i] = figures[i]->value_or(none);
  const auto sums = summed_figures(report);
  for (std::size_t i = 0; i < sums.size(); ++i) f.sums_of[i] = sums[i]->value_or(none);
  f.verdict = report.verdict;
  f.defect = report.defect_velocity_max.value_or(none);
  f.worst = report.worst.value_or(WorstContact{});
  f.worst_step = report.worst_step;
  return f;
}

void merge(const Figures& f, Report& report) {
  if (!std::isnan(f.defect) && !(f.defect <= report.defect_velocity_max.value_or(none))) {
    report.defect_velocity_max = f.defect;
    report.worst = f.worst;
    report.worst->world += report.worlds;  // those of the ranks before
    report.worst_step = f.worst_step;
  }
  report.verdict.add(f.verdict);
  report.worlds += f.worlds;
  report.bodies += f.bodies;
  report.joints += f.joints;
  report.contacts_max += f.contacts_max;
  report.steps = std::min(report.steps, f.steps);
  report.steps_redone += f.steps_redone;
  report.interrupted = report.interrupted || f.interrupted;
  report.bit_exact = report.bit_exact && f.bit_exact;
  for (const auto& [mine, other] : {std::pair(&report.ms_per_step_median, f.ms_median),
                                    {&report.ms_per_step_p99, f.ms_p99},
                                    {&report.ms_first_step, f.ms_first},
                                    {&report.ms_total, f.ms_total},
                                    {&report.max_penetration_m, f.max_penetration},
                                    {&report.mean_penetration_m, f.mean_penetration}})
    *mine = std::max(*mine, other);
  report.energy_initial_j += f.energy_initial;
  report.energy_final_j += f.energy_final;
  const auto figures = worst_figures(report);
  for (std::size_t i = 0; i < figures.size(); ++i)
    if (!std::isnan(f.worst_of[i])) *figures[i] = std::max(figures[i]->value_or(f.worst_of[i]), f.worst_of[i]);
  const auto sums = summed_figures(report);
  for (std::size_t i = 0; i < sums.size(); ++i)
    if (!std::isnan(f.sums_of[i])) *sums[i] = sums[i]->value_or(0) + f.sums_of[i];
}

}  // namespace

Share share_of(u32 worlds, const Ranks& ranks) {
  const u32 each = worlds / ranks.size(), more = worlds % ranks.size(), rank = ranks.rank();
  return {each * rank + std::min(rank, more), each + (rank < more ? 1 : 0)};
}

std::vector<Scene> read_worlds(const SceneOptions& options, const Share& share) {
  SceneOptions of_world = options;
  of_world.seed = options.seed + share.first;
  std::vector<Scene> worlds = {read_scene_with(of_world)};
  const double bodies = static_cast<double>(worlds[0].bodies.size()) * share.count;
  if (bodies > most_bodies_of_batch)
    throw Error(Failure::input, "--worlds",
                fmt::format("that is {:.0f} bodies on one device, and a batch can have {:.0f}; "
                            "ask for fewer worlds, or share them out with mpirun",
                            bodies, most_bodies_of_batch));
  worlds.reserve(share.count);
  for (u32 k = 1; k < share.count; ++k) {
    ++of_world.seed;
    worlds.push_back(worlds[0].seeded ? read_scene_with(of_world) : worlds[0]);
  }
  return worlds;
}

void spread_devices(const Ranks& ranks, TargetOptions& options) {
  if (ranks.local_size() == 1) return;
  std::vector<u32> gpus;
  for (const DeviceInfo& device : list_devices())
    if (device.type == DeviceType::gpu) gpus.push_back(device.index);
  if ((options.device == "auto" || options.device == "gpu") && gpus.size() > 1)
    options.device = std::to_string(gpus[ranks.local_rank() % gpus.size()]);
  const std::optional<DeviceInfo> device = select_device(options.device);
  if (device && device->type == DeviceType::cpu && !options.device_options.threads)
    options.device_options.threads = std::max(1u, device->compute_units / ranks.local_size());
}

Report merged(const Ranks& ranks, const Report& mine, const std::vector<WorldHash>& hashes) {
  Report report = mine;
  report.ranks = ranks.size();
  std::vector<WorldHash> all;
  for (const std::vector<WorldHash>& of_rank : ranks.gather(hashes))
    all.insert(all.end(), of_rank.begin(), of_rank.end());
  const std::vector<std::vector<Figures>> figures = ranks.gather(std::vector<Figures>{figures_of(mine)});
  for (std::size_t rank = 1; rank < figures.size(); ++rank)
    if (figures[rank][0].worlds > 0) merge(figures[rank][0], report);
  report.state_hash = combined_state_hash(all);
  report.pose_hash = combined_pose_hash(all);
  if (all.size() > 1)
    for (const WorldHash& hash : all) report.world_state_hashes.push_back(state_hash(hash));
  return report;
}

}  // namespace lockstep::app
