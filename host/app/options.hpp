// What `run` and `check` have in common: a scene, what to change in it, and what to run it on.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "host/backends/device_backend.hpp"
#include "host/scene/scene.hpp"

namespace lockstep::app {

struct SceneOptions {
  std::string scene;
  std::string device = "auto";
  std::optional<u32> steps, substeps, iterations;
  std::optional<double> time, dt;   // s
  std::optional<double> tolerance;  // m/s
  std::optional<Solver> solver;
  std::optional<FrictionModel> friction_model;
  std::string precision;  // empty: the scene's
  DeviceOptions device_options;
};

void add_scene_options(CLI::App& command, SceneOptions& options);

/// The scene with the settings that the command line asks for.
Scene read_scene_with(const SceneOptions& options);

/// The device that the command line asks for; nothing for the reference. Throws Error (input) where options go with a
/// device only.
std::optional<DeviceInfo> device_of(const SceneOptions& options);

/// Calls `work` with a float or a double, as the scene says.
template <class Work>
void with_precision(const Scene& scene, Work&& work) {
  if (scene.settings.precision == "double")
    work(double());
  else
    work(float());
}

}  // namespace lockstep::app
