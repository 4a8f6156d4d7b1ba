// What commands have in common: a scene, what to change in it, where to start, and what to run it on.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "host/scene/scene.hpp"
#include "host/steppers/stepper.hpp"

namespace lockstep::app {

/// A finite number above zero.
extern const CLI::Validator positive;

struct TargetOptions {
  std::string device = "auto";
  DeviceOptions device_options;
};

struct SceneOptions : TargetOptions {
  std::string scene;
  std::optional<u32> steps, substeps, iterations, relaxations;
  std::optional<double> time, dt;   // s
  std::optional<double> tolerance;  // m/s
  std::string solver;  // of solver_names or oracle_names(); empty: the scene's
  std::optional<u32> directions;
  std::optional<JointSolver> joint_solver;
  std::optional<FrictionModel> friction_model;
  std::string sleeping;   // empty: as the scene says; off, or seconds
  std::string precision;  // empty: the scene's
  u32 seed = 0;           // of what the scene draws at random
  std::string resume;     // a checkpoint to start from; empty: the beginning
};

void add_target_options(CLI::App& command, TargetOptions& options);
/// What to change in a scene, where to start, and what to run it on.
void add_setting_options(CLI::App& command, SceneOptions& options);
/// The scene's name too.
void add_scene_options(CLI::App& command, SceneOptions& options);

/// The scene with the settings that the command line asks for.
Scene read_scene_with(const SceneOptions& options);

/// Where the command line asks for steps by the oracle, or for those of a device or the reference. Throws Error (input)
/// where options go with a device only.
StepTarget target_of(const TargetOptions& options, const OracleChoice& oracle = {});

/// Calls `work` with a float or a double, as the scene says.
template <class Work>
void with_precision(const Scene& scene, Work&& work) {
  if (scene.settings.precision == "double")
    work(double());
  else
    work(float());
}

}  // namespace lockstep::app
