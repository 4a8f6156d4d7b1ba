#include <fmt/format.h>

#include "cpu_reference/oracle/error.hpp"
#include "host/app/commands.hpp"
#include "host/app/options.hpp"
#include "host/app/progress.hpp"
#include "host/app/start.hpp"
#include "host/backends/reference_backend.hpp"
#include "host/error.hpp"
#include "host/problems/system_problem.hpp"
#include "host/record/whole_file.hpp"
#include "host/report/measures.hpp"
#include "host/simulation.hpp"

namespace lockstep::app {

namespace {

struct ExportOptions : SceneOptions {
  std::string output;
  u32 at = 0;
  bool local = false, quiet = false;
};

template <class real>
std::unique_ptr<Backend<real>> make_backend(const InitialState<real>& state, const SceneOptions& options) {
  const std::optional<DeviceInfo> device = device_of(options);
  if (!device) return std::make_unique<ReferenceBackend<real>>(state);
  return std::make_unique<DeviceBackend<real>>(state, *device, options.device_options);
}

// The system that the last sub-step of step `at` solved.
template <class real>
SystemProblem system_at(const Scene& scene, const ExportOptions& options) {
  Start<real> start = make_start<real>(scene, options);
  if (!has(start.state.features, Feature::contacts) && !has(start.state.features, Feature::joints))
    throw Error(Failure::input, scene.name, "has neither contacts nor joints, there is nothing to solve in it");
  Simulation<real> simulation(make_backend(start.state, options), start.state.params, start.steps_done);
  {
    Progress progress(options.at, !options.quiet);
    while (simulation.steps_done() < options.at) {
      simulation.step();
      progress.update(simulation.steps_done());
    }
  }
  Backend<real>& backend = simulation.backend();
  const Buffers<real>& buffers = backend.download(measured_buffers(backend.features()));
  return problem_of(contact_system(buffers, simulation.counters()), fmt::format("{}, step {}", scene.name, options.at));
}

void export_system(const ExportOptions& options) {
  expect_writable(options.output, "the problem", "\x89HDF");
  Scene scene = read_scene_with(options);
  scene.settings.steps = std::max(scene.settings.steps, options.at + 1);  // it is not the scene's end that counts
  SystemProblem system;
  with_precision(scene, [&](auto real) { system = system_at<decltype(real)>(scene, options); });
  const std::string title = fmt::format("{}, step {}", scene.name, options.at);
  const oracle::ConeProblem local = oracle::local_form(system.problem);
  replace_file(options.output, options.local ? encode_fclib(local, title, system.impulses)
                                             : encode_fclib(system.problem, title, system.impulses));
  if (options.quiet) return;
  fmt::print("{}: {} contacts, {} rows of joints, {} velocities; residual of the step's own impulses {:.3g}\n", title,
             system.problem.mu.size(), system.problem.g.cols(), system.problem.m.rows(),
             oracle::cone_error(local, system.impulses.r, system.impulses.l).residual);
}

}  // namespace

void add_export(CLI::App& program) {
  CLI::App* command = program.add_subcommand("export", "Write the constraint system of a step as an FCLIB file");
  const auto options = std::make_shared<ExportOptions>();
  add_scene_options(*command, *options);
  command->add_option("--at", options->at, "The step, counted from 1")->required()->check(positive);
  command->add_option("-o,--output", options->output, "The file to write (.hdf5)")->required();
  command->add_flag("--local", options->local, "W, q instead of M, f, H, w");
  command->add_flag("--quiet", options->quiet, "No progress bar and no line");
  command->footer("Example:\n  lockstep export wall --at 100 -o wall.hdf5\n  lockstep solve wall.hdf5");
  command->callback([options] { export_system(*options); });
}

}  // namespace lockstep::app
