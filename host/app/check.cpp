#include <fmt/format.h>

#include <cstdio>

#include "host/app/command_files.hpp"
#include "host/app/commands.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/mismatch_picture.hpp"
#include "host/app/options.hpp"
#include "host/app/progress.hpp"
#include "host/app/start.hpp"
#include "host/backends/checked_backend.hpp"
#include "host/error.hpp"
#include "host/record/whole_file.hpp"
#include "host/report/report.hpp"
#include "host/scene/item_names.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "host/world_hash.hpp"

namespace lockstep::app {

namespace {

u32 stages_that_run(Features features) {
  u32 count = 0;
  for (u32 s = 0; s < stage_count; ++s) count += runs(static_cast<Stage>(s), features);
  return count;
}

struct CheckCommand : SceneOptions {
  std::vector<std::string> names;
  std::string picture;
};

// Throws Mismatch at the first word that differs; the hash of the state is compared as a last stage.
template <class real>
void check_scene(const Scene& scene, const CheckCommand& options, const DeviceInfo& device) {
  Start<real> start = make_start<real>(scene, options);
  tell_suspicions(scene, start);
  if (start.state.oracle)
    throw Error(Failure::input, "check",
                "compares an OpenCL device with the reference, and " + start.state.oracle.name +
                    " is an oracle that runs on the reference alone; record it and verify the recording");
  const StepParams<real> params = start.state.params;
  auto owned = std::make_unique<CheckedBackend<real>>(std::move(start.state), device, options.device_options,
                                                      CheckOptions{.fused = true});
  CheckedBackend<real>& backend = *owned;
  Simulation<real> simulation(std::move(owned), params, start.steps_done);

  const u32 steps = scene.settings.steps - start.steps_done;
  Interrupt::defer();
  {
    Progress progress(steps, !options.quiet);
    try {
      for (u32 step = 0; step < steps; ++step) {
        if (Interrupt::asked())
          throw Error(Failure::comparison, scene.name,
                      fmt::format("interrupted: the first {} of {} steps are equal", step, steps));
        simulation.step();
        progress.update(step + 1);
      }
    } catch (const Mismatch& mismatch) {
      if (!options.picture.empty())
        draw_mismatch(mismatch, backend, SceneModel(compile_shapes<real>(scene)), scene.name, options.picture);
      throw;
    }
  }
  const std::vector<WorldHash> hashes = simulation.world_hashes();
  if (options.quiet) return;
  fmt::print("{}, {}, {}: {} steps, {} stages, {} words compared: equal\n", scene.name, backend.name(),
             precision_of(scene.settings), steps, stages_that_run(backend.features()), backend.words_compared());
  fmt::print("state hash {}\n", hash_text(combined_state_hash(hashes)));
}

std::vector<Scene> scenes_of(CheckCommand& options) {
  if (options.names.empty())
    for (const SceneListing& scene : built_in_scenes()) options.names.push_back(scene.name);
  std::vector<Scene> scenes;
  for (const std::string& name : options.names) {
    options.scene = name;
    scenes.push_back(read_scene_with(options));
  }
  return scenes;
}

void check(CheckCommand& options) {
  expect_writable(options.picture, "the picture", png_signature);
  const std::optional<DeviceInfo> device = target_of(options).device;
  if (!device)
    throw Error(Failure::input, "check",
                "compares an OpenCL device with the reference; the reference alone has nothing to "
                "be compared with");
  const std::vector<Scene> scenes = scenes_of(options);
  if (!options.picture.empty() && scenes.size() > 1)
    throw Error(Failure::input, "--picture", "is of one scene: name it");

  u32 different = 0;
  for (const Scene& scene : scenes) {
    try {
      with_precision(scene, [&](auto real) {
        with_item_names({&scene, 1}, [&] { check_scene<decltype(real)>(scene, options, *device); });
      });
    } catch (const Mismatch& mismatch) {
      if (scenes.size() == 1) throw;
      // the others are compared all the same
      fmt::print("{}, {}: DIFFERENT: {}\n", scene.name, precision_of(scene.settings), mismatch.what());
      ++different;
    }
    std::fflush(stdout);
  }
  if (different)
    throw Error(Failure::comparison, "check", fmt::format("{} of {} scenes differ", different, scenes.size()));
}

}  // namespace

void add_check(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "check", "Run a device and the reference side by side; report the first word that differs");
  const auto options = std::make_shared<CheckCommand>();
  command->add_option(
      "scenes", options->names,
      "Built-in scenes (lockstep scenes), JSON files or robots (.urdf, .xml); default: every built-in scene");
  add_setting_options(*command, *options);
  add_file_option(*command, "--picture", options->picture, "Draw both states in this PNG file if they differ");
  command->add_flag("--quiet", options->quiet, "Print no progress bar, and nothing if all is equal");
  command->footer(
      "Examples:\n"
      "  lockstep check spheres8000 --steps 20 --lanes 8\n"
      "  lockstep check --steps 20 --device 1     # every built-in scene, on another device");
  command->callback([options] { check(*options); });
}

}  // namespace lockstep::app
