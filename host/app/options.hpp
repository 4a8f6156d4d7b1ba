// What commands have in common: a scene, what to change in it, where to start, and what to run it on.
#pragma once

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "host/scene/robot_reading.hpp"
#include "host/scene/scene.hpp"
#include "host/steppers/stepper.hpp"

namespace lockstep::app {

/// A finite number above zero.
extern const CLI::Validator positive;
/// For what CLI::Range lets through: nan.
extern const CLI::Validator finite;

struct TargetOptions {
  std::string device = "auto";
  DeviceOptions device_options;
  bool quiet = false;  // nothing is told but what is wrong
};

struct SceneOptions : TargetOptions {
  std::string scene;
  std::map<std::string, std::string> settings;  // that are given, by the names of host/settings.def
  std::optional<Solver> solver;
  std::optional<double> time;  // s
  std::string sleeping;        // empty: as the scene says; off, or seconds
  u32 seed = 0;                // of what the scene draws at random
  RobotReading reading;
  std::string resume;  // a checkpoint to start from; empty: the beginning
};

void add_target_options(CLI::App& command, TargetOptions& options);
/// What to change in a scene, where to start, and what to run it on.
void add_setting_options(CLI::App& command, SceneOptions& options);
/// The scene's name too.
void add_scene_options(CLI::App& command, SceneOptions& options);

/// Takes over what is given of these settings; of all without names.
void apply_given(const SceneOptions& options, Settings& settings, std::initializer_list<const char*> names = {});

/// The scene with the settings that the command line asks for.
Scene read_scene_with(const SceneOptions& options);

/// Where the command line asks for steps by the oracle, or for those of a device or the reference. Throws Error (input)
/// where options go with a device only.
StepTarget target_of(const TargetOptions& options, const OracleChoice& oracle = {});

/// Calls `work` with a float or a double, as the scene says.
template <class Work>
void with_precision(const Scene& scene, Work&& work) {
  if (precision_of(scene.settings) == "double")
    work(double());
  else
    work(float());
}

}  // namespace lockstep::app
