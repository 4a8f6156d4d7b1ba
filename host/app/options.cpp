#include "host/app/options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "host/error.hpp"
#include "host/steppers/oracles.hpp"
#include "host/scene/read.hpp"

namespace lockstep::app {

const CLI::Validator positive(
    [](const std::string& text) {
      double value = 0;
      const bool good = CLI::detail::lexical_cast(text, value) && value > 0 && std::isfinite(value);
      return good ? std::string() : "must be a number > 0, is '" + text + "'";
    },
    "> 0");

namespace {

const CLI::Validator not_negative(
    [](const std::string& text) {
      double value = 0;
      const bool good = CLI::detail::lexical_cast(text, value) && value >= 0 && std::isfinite(value);
      return good ? std::string() : "must be a number >= 0, is '" + text + "'";
    },
    ">= 0");

// Takes a name and gives the number that it stands for.
template <class Choice, std::size_t count>
CLI::Validator one_of(const std::pair<const char*, Choice> (&names)[count]) {
  std::vector<std::string> known;
  for (const auto& [name, choice] : names) known.push_back(name);
  const auto take = [known](std::string& text) {
    const auto found = std::ranges::find(known, text);
    if (found == known.end()) return fmt::format("must be one of {}, is '{}'", fmt::join(known, ", "), text);
    text = std::to_string(found - known.begin());
    return std::string();
  };
  return CLI::Validator(take, fmt::format("{}", fmt::join(known, "|")));
}

// Solvers of both kinds.
std::vector<std::string> all_solvers() {
  std::vector<std::string> names;
  for (const auto& named : solver_names) names.emplace_back(named.first);
  for (std::string& name : oracle_names()) names.push_back(std::move(name));
  return names;
}

void use_solver(Settings& settings, const std::string& name) {
  const auto found = std::ranges::find(solver_names, name, &std::pair<const char*, Solver>::first);
  if (found == std::end(solver_names))
    use_oracle(settings, name);
  else if (found->second != settings.solver || !settings.oracle.empty())
    lockstep::use_solver(settings, found->second);
}

}  // namespace

void add_target_options(CLI::App& command, TargetOptions& options) {
  command.add_option("--device", options.device, "auto, gpu, cpu, reference, or an index of `lockstep devices`")
      ->capture_default_str();

  const std::string group = "What cannot change a bit";
  DeviceOptions& device = options.device_options;
  command.add_option("--lanes", device.lanes, "Contacts per work-item in the solver")
      ->check(CLI::IsMember({1, 8, 16}))
      ->group(group);
  command.add_option("--work-group", device.work_group, "Work-items per work-group")->check(positive)->group(group);
  command
      .add_option("--threads", device.threads,
                  "Compute units of a CPU device; unset, all of them, or for few bodies the thread that calls")
      ->check(positive)
      ->group(group);
  CLI::Option* fused = command.add_flag_callback(
      "--fused", [&device] { device.fused = true; }, "All sub-steps as one launch, whatever the scene's size");
  CLI::Option* staged = command.add_flag_callback(
      "--staged", [&device] { device.fused = false; }, "Launches for each stage of each sub-step");
  fused->group(group);
  staged->group(group)->excludes(fused);
}

void add_scene_options(CLI::App& command, SceneOptions& options) {
  command
      .add_option("scene", options.scene, "A built-in scene (lockstep scenes), a JSON file or a robot (.urdf, .xml)")
      ->required();
  add_setting_options(command, options);
}

void add_setting_options(CLI::App& command, SceneOptions& options) {
  CLI::Option* steps = command.add_option("--steps", options.steps, "Time steps")->check(positive);
  command.add_option("--time", options.time, "Simulated time instead of steps, s")->check(positive)->excludes(steps);
  command.add_option("--dt", options.dt, "Length of a step, s")->check(positive);
  command.add_option("--substeps", options.substeps, "Sub-steps of a step")->check(positive);
  command.add_option("--iterations", options.iterations, "Solver iterations of a sub-step")->check(positive);
  command
      .add_option("--relaxations", options.relaxations,
                  "Sweeps that take back what the springs of small_steps added in a sub-step")
      ->check(positive);
  command
      .add_option("--tolerance", options.tolerance,
                  "End the iterations of a sub-step at one that changes velocities by no more, m/s; 0: do not")
      ->check(not_negative);
  const auto known = [names = all_solvers()](const std::string& name) {
    if (std::ranges::find(names, name) != names.end()) return std::string();
    return fmt::format("must be one of {}, is '{}'", fmt::join(names, ", "), name);
  };
  command
      .add_option("--solver", options.solver,
                  "Contact solver instead of the scene's: gauss_seidel, small_steps, jacobi, gradient, "
                  "accelerated_gradient, dense_gauss_seidel, cell_gauss_seidel; or an oracle (`lockstep run --help` "
                  "has their names)")
      ->check(CLI::Validator(known, "NAME"));
  command.add_option("--directions", options.directions, "Sides of the friction pyramids of oracles that have them")
      ->check(CLI::Range(3u, 256u));
  command
      .add_option("--joint-solver", options.joint_solver,
                  "Joints by sweeps, or direct: all of a tree of bodies at once; instead of the scene's")
      ->transform(one_of(joint_solver_names));
  command.add_option("--friction-model", options.friction_model, "Friction model instead of the scene's")
      ->transform(one_of(friction_model_names));
  command
      .add_option("--sleeping", options.sleeping,
                  "Let islands sleep whose bodies have been slow for so many seconds, or off; instead of the scene's")
      ->check([](const std::string& text) { return text == "off" ? std::string() : positive(text); }, "S|off");
  command.add_option("--precision", options.precision, "float or double instead of what the scene asks for")
      ->check(CLI::IsMember({"float", "double"}));
  command.add_option("--seed", options.seed, "Draw what the scene draws at random otherwise: 0 is as its file has it");
  command.add_option("--resume", options.resume, "Go on from this checkpoint; --steps counts from the beginning");
  add_target_options(command, options);
}

Scene read_scene_with(const SceneOptions& options) {
  Scene scene = read_scene(options.scene, options.seed);
  Settings& settings = scene.settings;
  settings.dt = options.dt.value_or(settings.dt);
  settings.steps = options.steps.value_or(settings.steps);
  if (!options.solver.empty()) use_solver(settings, options.solver);
  settings.directions = options.directions.value_or(settings.directions);
  settings.joint_solver = options.joint_solver.value_or(settings.joint_solver);
  settings.friction_model = options.friction_model.value_or(settings.friction_model);
  settings.substeps = options.substeps.value_or(settings.substeps);
  settings.iterations = options.iterations.value_or(settings.iterations);
  settings.relaxations = options.relaxations.value_or(settings.relaxations);
  settings.tolerance = options.tolerance.value_or(settings.tolerance);
  if (options.sleeping == "off") {
    settings.sleeping.reset();
  } else if (!options.sleeping.empty()) {
    if (!settings.sleeping) settings.sleeping.emplace();
    settings.sleeping->after = std::stod(options.sleeping);
  }
  if (!options.precision.empty()) settings.precision = options.precision;
  if (options.time) {
    const double steps = std::max(1.0, std::round(*options.time / settings.dt));
    if (!(steps < 4e9)) throw Error(Failure::input, "--time", "that is more than 4,000,000,000 steps");
    settings.steps = static_cast<u32>(steps);
  }
  return scene;
}

StepTarget target_of(const TargetOptions& options, const OracleChoice& oracle) {
  const StepTarget target = lockstep::target_of(options.device, options.device_options, oracle);
  const DeviceOptions& wanted = options.device_options;
  if (!target.device && (wanted.lanes || wanted.work_group || wanted.threads || wanted.fused))
    throw Error(Failure::input, "--lanes --work-group --threads --fused --staged",
                "are for OpenCL devices; this runs on the reference");
  if (target.device && target.device->type != DeviceType::cpu && wanted.threads)
    throw Error(Failure::input, "--threads", "is for CPU devices; leave it out on " + target.device->name);
  return target;
}

}  // namespace lockstep::app
