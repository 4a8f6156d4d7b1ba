#include "host/app/options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "host/error.hpp"
#include "host/scene/read.hpp"
#include "host/scene/setting_table.hpp"

namespace lockstep::app {

// A finite number that `allows`, or what it `must_be`.
template <class Test>
static std::string number_error(const std::string& text, const char* must_be, Test&& allows) {
  if (text.size() > 1 && text[0] == '0' && text.find_first_not_of("0123456789") == std::string::npos)
    return "must not begin with 0, or it would be read in base eight, is '" + text + "'";
  double value = 0;
  const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && allows(value);
  return good ? std::string() : std::string("must be a ") + must_be + ", is '" + text + "'";
}

const CLI::Validator positive(
    [](const std::string& text) { return number_error(text, "number > 0", [](double value) { return value > 0; }); },
    "> 0");

const CLI::Validator finite(
    [](const std::string& text) { return number_error(text, "finite number", [](double) { return true; }); }, "");

namespace {

// What stands behind the name of an option in --help: the names that it takes, or bounds and unit. What has neither is
// true or false.
std::string value_text(const SettingInfo& row) {
  if (row.bounds.kind == Bounds::Kind::name) return fmt::format("{}", fmt::join(names_of(row), "|"));
  const std::string bounds = row.bounds.text(), unit = row.unit;
  if (bounds.empty() && unit.empty()) return "true|false";
  return "[" + bounds + (bounds.empty() || unit.empty() ? "" : ", ") + unit + "]";
}

// The first clause of what a row means: the rest is on the page of settings.
std::string help_text(const SettingInfo& row) {
  std::string text = row.meaning;
  const bool begins_with_name = text.starts_with('`');
  for (const char* end : {" (docs/", "; ", ". ", ": "}) {
    if (begins_with_name && (end[0] == ':' || row.bounds.kind == Bounds::Kind::name) && end[0] != ' ') continue;
    text = text.substr(0, text.find(end));
  }
  return text;
}

// --setting-of-a-row, in the group of the row.
CLI::Option* add_setting(CLI::App& command, const SettingInfo& row, SceneOptions& options) {
  std::string name = row.name;
  std::ranges::replace(name, '_', '-');
  const auto check = [&row](const std::string& text) {
    Settings ignored;
    try {
      read_setting(text, row, ignored);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const auto take = [&row, &options](const std::string& text) { options.settings[row.name] = text; };
  return command.add_option_function<std::string>("--" + name, take, help_text(row))
      ->check(CLI::Validator(check, ""))
      ->type_name(value_text(row))
      ->group(setting_group_names[static_cast<u32>(row.group)]);
}

// The oracles are too many to be listed with the others.
void add_solver(CLI::App& command, std::optional<Solver>& solver) {
  std::vector<std::string> names, sweeping;
  for (const SolverInfo& each : solver_infos) {
    names.emplace_back(each.name);
    if (!each.is_oracle) sweeping.emplace_back(each.name);
  }
  const auto take = [&solver](const std::string& name) { solver = find_solver(name); };
  const auto known = [names](const std::string& name) {
    const bool is_known = std::ranges::find(names, name) != names.end();
    return is_known ? std::string() : fmt::format("unknown solver {}; {}", quote(name), suggestion(name, names));
  };
  command
      .add_option_function<std::string>(
          "--solver", take,
          fmt::format("Use this solver instead of the scene's: {}; or an oracle (listed by lockstep run --help)",
                      fmt::join(sweeping, ", ")))
      ->check(CLI::Validator(known, ""))
      ->type_name("NAME")
      ->group(setting_group_names[static_cast<u32>(SettingGroup::solver)]);
}

}  // namespace

void add_target_options(CLI::App& command, TargetOptions& options) {
  command
      .add_option("--device", options.device,
                  "Device to compute on: auto, gpu, cpu, reference, or an index from `lockstep devices`")
      ->capture_default_str();

  const std::string group = "Speed only: these change no bit";
  DeviceOptions& device = options.device_options;
  command.add_option("--lanes", device.lanes, "Contact pairs per work-item in the solver")
      ->check(CLI::IsMember({1, 8, 16}))
      ->group(group);
  command.add_option("--work-group", device.work_group, "Work-items per work-group")->check(positive)->group(group);
  command
      .add_option("--threads", device.threads,
                  "Compute units of a CPU device; default: all, or the calling thread for small scenes")
      ->check(positive)
      ->group(group);
  const std::vector<std::string> plans(std::begin(substep_plan_names), std::end(substep_plan_names));
  command
      .add_option_function<std::string>(
          "--plan",
          [&device, plans](const std::string& name) {
            device.substeps = static_cast<SubstepPlan>(std::ranges::find(plans, name) - plans.begin());
          },
          "How sub-steps run: launches for each stage, or one launch of one work-group or of all; default: what suits "
          "the scene and the device")
      ->check(CLI::IsMember(plans))
      ->group(group);
}

void add_scene_options(CLI::App& command, SceneOptions& options) {
  command.add_option("scene", options.scene, "Built-in scene (lockstep scenes), JSON file, or robot (.urdf, .xml)")
      ->required();
  const std::string group = "Robots";
  command
      .add_flag("--strict", options.reading.strict,
                "Refuse a robot file with anything that would be left out; default: warn")
      ->group(group);
  command
      .add_flag("--approximate", options.reading.approximate,
                "Leave out or replace what changes a robot's motion but is not simulated, with a warning")
      ->group(group);
  command
      .add_option("--keyframe", options.reading.keyframe,
                  "Start joints and servos from this <key> of an MJCF file, by its name or number")
      ->group(group);
  command
      .add_option_function<std::vector<std::string>>(
          "--package",
          [&options](const std::vector<std::string>& packages) {
            for (const std::string& package : packages) {
              const std::size_t at = package.find('=');
              if (at == package.npos || at == 0)
                throw CLI::ValidationError("--package", "must be NAME=FOLDER, is '" + package + "'");
              options.reading.packages[package.substr(0, at)] = package.substr(at + 1);
            }
          },
          "Folder of package://NAME in robot files; searched before ROS_PACKAGE_PATH")
      ->type_name("NAME=FOLDER")
      ->allow_extra_args(false)
      ->group(group);
  add_setting_options(command, options);
}

void add_setting_options(CLI::App& command, SceneOptions& options) {
  for (const SettingInfo& row : setting_infos()) {
    const std::string_view name = row.name;
    if (name == "events") continue;  // run --events FILE
    if (name == "solver")
      add_solver(command, options.solver);
    else if (name == "sleeping")
      command
          .add_option("--sleeping", options.sleeping, "Put islands to sleep after this many seconds at rest, or off")
          ->check(CLI::Validator([](const std::string& text) { return text == "off" ? std::string() : positive(text); },
                                 ""))
          ->type_name("[> 0, s]|off")
          ->group(setting_group_names[static_cast<u32>(row.group)]);
    else
      add_setting(command, row, options);
  }
  command.add_option("--time", options.time, "Simulated time, instead of --steps")
      ->check(CLI::Validator(positive).description(""))
      ->type_name("[> 0, s]")
      ->excludes(command.get_option("--steps"))
      ->group(setting_group_names[static_cast<u32>(SettingGroup::time)]);
  command.add_option("--seed", options.seed, "Random seed offset (0 = as in the scene file)")
      ->check(CLI::Validator(finite).description(""));
  command.add_option("--resume", options.resume,
                     "Continue from this checkpoint; --steps counts from the start of the original run");
  add_target_options(command, options);
}

// A world of many says it once.
static void print_notes(const Scene& scene) {
  static std::set<std::string> printed;
  for (const std::string& note : scene.notes)
    if (printed.insert(scene.source + ": " + note).second) fmt::print(stderr, "lockstep: {}: {}\n", scene.source, note);
}

void apply_given(const SceneOptions& options, Settings& settings, std::initializer_list<const char*> names) {
  for (const auto& [name, text] : options.settings) {
    if (names.size() == 0 || std::ranges::find(names, name) != names.end())
      read_setting(text, setting_info(name), settings);
  }
}

Scene read_scene_with(const SceneOptions& options) {
  Scene scene = read_scene(options.scene, options.seed, options.reading);
  print_notes(scene);
  Settings& settings = scene.settings;
  if (options.solver && *options.solver != settings.solver) replace_solver(settings, *options.solver);
  apply_given(options, settings);
  if (options.sleeping == "off") {
    settings.sleeping.reset();
  } else if (!options.sleeping.empty()) {
    if (!settings.sleeping) settings.sleeping.emplace();
    settings.sleeping->after = std::stod(options.sleeping);
  }
  if (options.time) {
    const double steps = std::max(1.0, std::round(*options.time / settings.dt));
    if (!(steps < 4e9)) throw Error(Failure::input, "--time", "that is more than 4,000,000,000 steps");
    settings.steps = static_cast<u32>(steps);
  }
  return scene;
}

StepTarget target_of(const TargetOptions& options, const OracleChoice& oracle) {
  StepTarget target = lockstep::target_of(options.device, options.device_options, oracle);
  if (!options.quiet) target.options.tell_building = tell_on_terminal;
  const DeviceOptions& wanted = options.device_options;
  if (!target.device && (wanted.lanes || wanted.work_group || wanted.threads || wanted.substeps))
    throw Error(Failure::input, "--lanes --work-group --threads --plan",
                "are for OpenCL devices; this runs on the reference");
  if (target.device && target.device->type != DeviceType::cpu && wanted.threads)
    throw Error(Failure::input, "--threads", "is for CPU devices; leave it out on " + target.device->name);
  return target;
}

}  // namespace lockstep::app
