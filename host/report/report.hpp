// What a run reports: its speed beside its errors. docs/reference/error_measures.md says what each figure is.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/report/measures.hpp"
#include "host/sensor.hpp"
#include "host/shape_tolerance.hpp"
#include "host/verdict.hpp"

namespace lockstep {

/// The figures of one run, and the keys of the report file. An empty optional is `null`: the figure does not apply.
struct Report {
  // what was run; the first step is not 0 where a checkpoint was resumed
  std::string scene, device, precision, solver, joint_solver, friction_model;
  bool bit_exact = true;             // what the canary says of the device
  std::string canary = "bit-exact";  // the same in words
  u32 ranks = 1;                     // processes that shared the worlds out
  u32 worlds = 0, bodies = 0, joints = 0, first_step = 0, steps = 0, substeps = 0, iterations = 0;
  bool interrupted = false;  // ended before its last step because it was asked to
  double dt = 0;             // of a step, s
  double tolerance = 0;      // m/s; 0 where all iterations are made
  std::array<ShapeTolerance, 3> shape_tolerances = {};
  u32 contacts_max = 0, steps_redone = 0, steps_measured = 0;

  // speed: all but the total leave the first step out, which warms up
  double ms_per_step_median = 0, ms_per_step_p99 = 0, ms_first_step = 0, ms_total = 0;
  // mean of a step, in the order of the pipeline, and then what it takes besides; empty unless profiled
  std::vector<std::pair<std::string, double>> stage_ms;
  std::vector<std::pair<std::string, u32>> steps_by_plan;  // of --plan; empty but on a device

  std::optional<double> sweeps_median, sweeps_max;  // of a step, in all its sub-steps; where a tolerance ends them

  // errors, over the measured steps
  double max_penetration_m = 0, mean_penetration_m = 0;
  std::optional<double> residual_median, residual_max, residual_floor, natural_map_max;
  std::optional<double> defect_velocity_max;  // m/s
  std::optional<WorstContact> worst;          // where it was seen
  u32 worst_step = 0;
  std::string worst_name_a, worst_name_b;  // of its bodies; empty where they have none
  std::optional<double> joint_drift_max_m, joint_angle_max_rad, momentum_error, energy_error, model_error;
  double energy_initial_j = 0, energy_final_j = 0;

  // of bodies as particles: how many there are, and the worst of how their centres of mass and their inertias, each
  // particle of a body taken as equally heavy, differ from those of the bodies
  std::optional<double> particles, particle_center_error_m, particle_inertia_error;

  // of scenes with sleeping: bodies and islands that sleep at the end, steps begun anew because islands woke
  std::optional<double> asleep, islands_asleep, wakings;

  Verdict verdict;  // of all steps

  bool has_tolerance = false;  // or a residual to reach, as oracles have: else nothing can be left unsolved

  std::optional<std::array<std::uint64_t, EVENT_KINDS>> events;  // by EventKind, where the scene asks for them

  std::vector<SensorReading> sensors;  // of the first world, after the last step; where the scene has any

  std::uint64_t state_hash = 0, pose_hash = 0;
  std::vector<std::uint64_t> world_state_hashes;  // where there are several

  /// Steps of a body in a second of wall time, without the first step.
  double body_steps_per_second() const;
};

/// Gathers the figures of a run, step by step.
class Recorder {
 public:
  /// `initial` is measured before the first step. `conserves_momentum`: see momentum_is_conserved().
  /// `conserves_energy`: nothing in the scene dissipates.
  Recorder(Measures initial, bool conserves_momentum, bool conserves_energy)
      : initial_(std::move(initial)), conserves_momentum_(conserves_momentum), conserves_energy_(conserves_energy) {}

  /// One step took this long and saw this many contacts.
  void time(double milliseconds, u32 contacts);

  /// One step made so many sweeps in all its sub-steps; told where a tolerance ends them.
  void sweeps(u32 count) { sweeps_.push_back(count); }

  /// The state at the end of a step (the first is 0, as in every message), `seconds` of simulated time after the start.
  void observe(u32 step, double seconds, Measures measures);

  /// Adds what was gathered to a report that says what was run.
  void finish(Report& report) const;

 private:
  struct Observation {
    u32 step;
    double seconds;
    Measures measures;
  };

  void finish_speed(Report& report) const;
  void finish_contacts(Report& report) const;
  std::optional<double> momentum_error() const;
  std::optional<double> energy_error() const;

  Measures initial_;
  bool conserves_momentum_, conserves_energy_;
  std::vector<double> milliseconds_, sweeps_;
  u32 contacts_max_ = 0;
  std::vector<Observation> observations_;
};

/// Combines the hashes of the worlds in order. That of one world is its own hash.
std::uint64_t combined_state_hash(std::span<const WorldHash> worlds);
std::uint64_t combined_pose_hash(std::span<const WorldHash> worlds);

/// The report as one JSON object.
std::string to_json(const Report& report);

/// The table that a run ends with: speed beside error.
std::string to_table(const Report& report);

}  // namespace lockstep
