#include <fmt/format.h>

#include <bit>

#include "cpu_reference/oracle/error.hpp"
#include "cpu_reference/oracle/models/model_size.hpp"
#include "host/app/command_files.hpp"
#include "host/app/commands.hpp"
#include "host/app/export_motion.hpp"
#include "host/app/options.hpp"
#include "host/app/progress.hpp"
#include "host/app/render_options.hpp"
#include "host/app/start.hpp"
#include "host/error.hpp"
#include "host/problems/cone_file.hpp"
#include "host/record/whole_file.hpp"
#include "host/report/measures.hpp"
#include "host/scene/item_names.hpp"
#include "host/simulation.hpp"
#include "host/steppers/system_problem.hpp"

namespace lockstep::app {

namespace {

struct ExportOptions : MotionOptions {
  std::optional<u32> at;
  bool local = false, sizes = false;
};

// The system that the last sub-step of a step solved, and what was left of it.
struct SolvedStep {
  ContactSystem system;
  Unsolved unsolved;
};

template <class real>
SolvedStep system_at(const Scene& scene, u32 step, const ExportOptions& options) {
  Start<real> start = make_start<real>(scene, options);
  tell_suspicions(scene, start);
  if (!has(start.state.features, Feature::contacts) && !has(start.state.features, Feature::joints))
    throw Error(Failure::input, scene.name, "has neither contacts nor joints, there is nothing to solve in it");
  Simulation<real> simulation = simulate(start, options);
  {
    Progress progress(step, !options.quiet);
    while (simulation.steps_done() < step) {
      simulation.step();
      progress.update(simulation.steps_done());
    }
  }
  Backend<real>& backend = simulation.backend();
  const Buffers<real>& buffers = backend.download(measured_buffers(backend.features()));
  ContactSystem system = contact_system(buffers, simulation.counters(), backend.features());
  if (!system.angular_friction.empty())
    throw Error(Failure::input, scene.name,
                "has torsional or rolling friction, and a contact of a problem file has none");
  return {system, simulation.unsolved()};
}

void print_sizes(const ContactSystem& system, const std::string& title, std::size_t directions) {
  std::vector<bool> touches(system.bodies.size());
  for (const SystemContact& c : system.contacts) touches[c.body_a] = touches[c.body_b] = true;
  oracle::models::SceneSize size = {
      .joints = system.joints.size(), .contacts = system.contacts.size(), .directions = directions};
  for (std::size_t i = 0; i < system.bodies.size(); ++i) {
    const bool moves = system.bodies[i].inverse_mass > 0 || !system.bodies[i].inverse_inertia.isZero(0);
    size.bodies += moves;
    size.touching_bodies += moves && touches[i];
  }
  const oracle::models::ModelSizes models = model_sizes(size);
  fmt::print("{}: {} bodies that move, {} of them in contact; {} joints, {} contacts; pyramids of {} sides\n", title,
             size.bodies, size.touching_bodies, size.joints, size.contacts, directions);
  const auto row = [](const char* model, std::size_t unknowns, const char* what) {
    fmt::print("  {:<18}{:>10}  {}\n", model, unknowns, what);
  };
  fmt::print("  {:<18}{:>10}\n", "model", "unknowns");
  row("Model-dNCP", models.dncp, "the continuous model");
  row("Model-mNCP", models.mncp, "the nonlinear implicit step");
  row("Model-mLCP", models.mlcp, "the linear step with a friction pyramid");
  row("Model-LCP", models.lcp, "without velocities and joints");
  row("Model-DCA-mLCP1", models.dca_mlcp1, "reduced coordinates");
  row("Model-DCA-mLCP2", models.dca_mlcp2, "reduced coordinates");
  row("Model-DCA-LCP", models.dca_lcp, "reduced coordinates");
  const auto others =
      std::ranges::count_if(system.joints, [](const SystemJoint& j) { return std::popcount(j.locked) != 5; });
  if (others > 0)
    fmt::print("  counted as if each joint had one degree of freedom and dry friction; {} of {} have another number\n",
               others, size.joints);
}

// What is asked for of a step's system: its sizes, a file.
void write_system(const ContactSystem& solved, const Scene& scene, const ExportOptions& options) {
  const std::string title = fmt::format("{}, step {}", scene.name, *options.at);
  if (options.sizes) print_sizes(solved, title, scene.settings.directions);
  if (options.output.empty()) return;
  const SystemProblem system = problem_of(solved, title);
  const oracle::ConeProblem local = oracle::local_form(system.problem);
  if (options.output.ends_with(".dat")) {
    const std::string text = encode_siconos_text(local);
    replace_file(options.output, {reinterpret_cast<const unsigned char*>(text.data()), text.size()});
  } else {
    replace_file(options.output, options.local ? encode_fclib(local, title, system.impulses)
                                               : encode_fclib(system.problem, title, system.impulses));
  }
  if (options.quiet) return;
  fmt::print("{}: {} contacts, {} rows of joints, {} velocities; residual of the step's own impulses {:.3g}\n", title,
             system.problem.mu.size(), system.problem.g.cols(), system.problem.m.rows(),
             oracle::cone_error(local, system.impulses.r, system.impulses.l).residual);
}

void export_system(const ExportOptions& options) {
  if (options.fps) throw Error(Failure::input, "--fps", "is for a motion: let the name of the --output end in .glb");
  if (is_recording(options.scene))
    throw Error(Failure::input, options.scene,
                "is a recording, it has no constraint systems; export its motion (-o x.glb), or a step of its scene");
  if (!options.at)
    throw Error(Failure::input, "--at", "is missing: the step whose system is written; a motion's name ends in .glb");
  if (options.output.empty() && !options.sizes)
    throw Error(Failure::input, "--output", "is missing: name the file to write, or ask for --sizes");
  // what it writes over, it has written itself: FCLIB's signature, or the first line of the text, its dimension
  if (!options.output.empty())
    expect_writable(options.output, "the problem", options.output.ends_with(".dat") ? "3\n" : "\x89HDF");
  Scene scene = read_scene_with(options);
  scene.settings.steps = std::max(scene.settings.steps, *options.at + 1);  // it is not the scene's end that counts
  SolvedStep step;
  with_item_names({&scene, 1}, [&] {
    with_precision(scene, [&](auto real) { step = system_at<decltype(real)>(scene, *options.at, options); });
    write_system(step.system, scene, options);
  });
  expect_all_solved(scene.name, name_of(scene.settings.solver), step.unsolved);
}

}  // namespace

void add_export(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "export", "Write a motion as glTF, or the constraint system of a step; print its size in each model");
  const auto options = std::make_shared<ExportOptions>();
  add_scene_options(*command, *options);
  command->get_option("scene")->description("Built-in scene, JSON file or robot; for a motion also a recording");
  add_file_option(*command, "-o,--output", options->output,
                  "File to write: .glb a motion; .dat a system as text for Siconos; else a system as FCLIB");
  command->add_flag("--quiet", options->quiet, "Print no progress bar and no summary");
  command
      ->add_option("--fps", options->fps, "Keyframes per second of simulated time (default 60, at most one per step)")
      ->check(finite)
      ->check(CLI::Range(0.001, 1e6))
      ->group("A motion");
  const std::string group = "The system of a step";
  command->add_option("--at", options->at, "Step to write, counted from 1")->check(positive)->group(group);
  command->add_flag("--local", options->local, "Write W and q instead of M, f, H and w")->group(group);
  command
      ->add_flag("--sizes", options->sizes,
                 "Print how many unknowns each model of the survey has for this step; needs no --output")
      ->group(group);
  command->get_option("--directions")
      ->description("Sides of the friction pyramids, for --sizes and for oracles with pyramids");
  command->footer(
      "Example:\n  lockstep export heap.h5 -o heap.glb\n  lockstep export wall --at 100 -o wall.hdf5\n"
      "  lockstep solve wall.hdf5\n  lockstep export rag_doll --at 100 --sizes");
  command->callback([command, options] {
    if (is_motion(options->output))
      export_motion(*command, *options);
    else
      export_system(*options);
  });
}

}  // namespace lockstep::app
