#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>

#include "host/app/command_files.hpp"
#include "host/app/commands.hpp"
#include "host/app/event_log.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/progress.hpp"
#include "host/app/recording.hpp"
#include "host/app/report_file.hpp"
#include "host/app/start.hpp"
#include "host/app/worlds.hpp"
#include "host/error.hpp"
#include "host/record/measure_row.hpp"
#include "host/record/whole_file.hpp"
#include "host/report/monitor.hpp"
#include "host/report/report.hpp"
#include "host/scene/item_names.hpp"
#include "host/scene/sample_particles.hpp"
#include "host/scene/shape_tolerances.hpp"
#include "host/scene/verdict_bounds.hpp"
#include "host/simulation.hpp"
#include "host/steppers/measure_backend.hpp"
#include "host/steppers/oracles.hpp"
#include "host/steppers/sensors.hpp"
#include "host/stop_request.hpp"
#include "host/world_hash.hpp"

namespace lockstep::app {

namespace {

struct RunOptions : SceneOptions {
  std::string report, events, record, checkpoint;
  u32 worlds = 1;
  std::vector<u32> record_worlds;
  bool record_forces = false;
  bool is_first = true;  // of the ranks
};

// Makes what steps and says in the report what it is, and whether it can be trusted with the bits. The state is let go
// of where it is not recorded.
template <class real>
std::unique_ptr<Backend<real>> make_backend(InitialState<real>& state, const RunOptions& options, Report& report) {
  const StepTarget target = target_of(options, state.oracle);
  if (!target.device && options.device == "auto" && !state.oracle)
    fmt::print(stderr, "lockstep: there is no OpenCL device here; the plain C++ reference takes its place\n");
  Stepper<real> stepper =
      options.record.empty() ? make_stepper(std::move(state), target) : make_stepper(std::as_const(state), target);
  const CanaryVerdict verdict = stepper.canary();
  report.device = stepper.backend->name();
  report.bit_exact = verdict.bit_exact();
  report.canary = describe(verdict);
  return std::move(stepper.backend);
}

// Measuring takes longer than a small step: about a hundred measurements show a run, however long it is.
bool is_measured(u32 step, u32 steps) {
  const u32 stride = steps < 200 ? 1 : steps / 100;
  return (step + 1) % stride == 0 || step + 1 == steps;
}

template <class real>
Recorder make_recorder(const InitialState<real>& state) {
  const Counters nothing_yet = {};
  return Recorder(measure(state.buffers, state.sizes, state.features, state.params, nothing_yet),
                  momentum_is_conserved(state.buffers, state.features),
                  !has(state.features, Feature::contacts) && !has(state.features, Feature::particles) &&
                      joints_conserve_energy(state.buffers, state.params));
}

// A world of a batch that is recorded: it is stepped once more, alone, as `lockstep verify` steps it.
template <class real>
struct RecordedWorld {
  u32 world;  // of this rank
  std::unique_ptr<Simulation<real>> simulation;
  std::unique_ptr<RecordingWriter<real>> recording;

  void step() {
    const auto start = std::chrono::steady_clock::now();
    simulation->step();
    const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start;
    record_step(*recording, *simulation, ms.count());
  }
};

// run.h5 of world 3 is run.3.h5.
std::string path_of_world(const std::string& path, u32 world) {
  const std::filesystem::path whole = path;
  std::filesystem::path of_world = whole;
  of_world.replace_extension("." + std::to_string(world) + whole.extension().string());
  return of_world.string();
}

template <class real>
std::vector<RecordedWorld<real>> record_chosen(std::span<const Scene> worlds, const RunOptions& options) {
  std::vector<RecordedWorld<real>> recorded;
  for (const u32 world : options.record_worlds) {
    Start<real> start;
    start.state = compile<real>(worlds.subspan(world, 1));
    const StepParams<real> params = start.state.params;
    const StepTarget target = target_of(options, start.state.oracle);
    auto stepper = make_stepper(std::as_const(start.state), target);
    auto recording = make_recording(path_of_world(options.record, world), worlds[world], stepper.backend->name(),
                                    options.device_options, start.state, options.record_forces);
    recorded.push_back(
        {world, std::make_unique<Simulation<real>>(std::move(stepper.backend), params, 0), std::move(recording)});
  }
  return recorded;
}

// The bits of a world are those that it has alone.
template <class real>
void expect_same_bits(std::span<RecordedWorld<real>> recorded, const std::vector<WorldHash>& hashes) {
  for (RecordedWorld<real>& one : recorded)
    if (const std::vector<WorldHash> alone = one.simulation->world_hashes();
        state_hash(alone.front()) != state_hash(hashes[one.world]))
      throw Error(Failure::comparison, fmt::format("world {}", one.world),
                  "has other bits in the batch than alone, where it was recorded; please report this");
}

// Who is told what a run does.
template <class real>
struct RunObservers {
  Recorder& recorder;
  Monitor& monitor;
  EventLog& log;
  EventGroups groups;
  Progress& progress;
  RecordingWriter<real>* recording;  // may be null
  std::span<RecordedWorld<real>> recorded;
  std::span<const Scene> worlds;  // whose names errors tell
  const OracleChoice& oracle;
  StageSeconds& first_step;
};

// Steps the simulation until `steps` are done or the program is asked to end, the clock running during the steps alone.
template <class real>
void simulate(Simulation<real>& simulation, u32 steps, RunObservers<real> observers) {
  using Clock = std::chrono::steady_clock;
  Backend<real>& backend = simulation.backend();
  const double dt = double(simulation.params().dt) * simulation.params().substeps;
  const u32 first = simulation.steps_done();
  for (u32 step = first; step < steps && !Interrupt::asked(); ++step) {
    const Clock::time_point start = Clock::now();
    try {
      with_item_names(observers.worlds, [&] { simulation.step(); });
    } catch (const Stopped&) {
      break;
    }
    const std::chrono::duration<double, std::milli> ms = Clock::now() - start;
    for (RecordedWorld<real>& world : observers.recorded) world.step();
    observers.recorder.time(ms.count(), simulation.counters()[COUNTER_CONTACTS]);
    observers.monitor.observe(simulation.counters(), simulation.params(), step);
    if (step == first) observers.first_step = backend.stage_seconds();
    if (has(backend.features(), Feature::tolerance)) observers.recorder.sweeps(simulation.counters()[COUNTER_SWEEPS]);
    if (observers.recording) record_step(*observers.recording, simulation, ms.count());
    if (is_measured(step - first, steps - first) || observers.monitor.is_worse()) {
      const Measures measures = measure(backend, simulation.params(), simulation.counters());
      if (observers.recording) observers.recording->add(measure_row(step + 1, measures));
      observers.monitor.observe(measures, step + 1);
      observers.recorder.observe(step, (step + 1 - first) * dt, measures);
    }
    for (const PairEvent& event : simulation.events(observers.groups)) observers.log.add(event);
    observers.progress.update(step + 1 - first);
  }
}

// The mean of a step without the first one: in each stage that took any time, and in none.
template <class real>
std::vector<std::pair<std::string, double>> mean_step(const Backend<real>& backend, const StageSeconds& first_step,
                                                      const Report& report) {
  if (report.steps < 2) return {};
  const StageSeconds seconds = backend.stage_seconds();
  const double steps = report.steps - 1;
  std::vector<std::pair<std::string, double>> times;
  double rest = (report.ms_total - report.ms_first_step) / steps;
  for (u32 s = 0; s < seconds.size(); ++s) {
    const double ms = 1e3 * (seconds[s] - first_step[s]) / steps;
    if (ms == 0) continue;
    times.emplace_back(s < stage_count ? info(static_cast<Stage>(s)).name : "sub_steps", ms);
    rest -= ms;
  }
  times.emplace_back("outside_of_stages", rest);
  return times;
}

// The recording says how the run ended, whatever ended it.
template <class real>
void simulate_and_close(Simulation<real>& simulation, u32 steps, RunObservers<real> observers) {
  const auto close = [&](const std::string& outcome) {
    if (observers.recording) observers.recording->close(outcome);
    for (RecordedWorld<real>& world : observers.recorded) world.recording->close(outcome);
  };
  try {
    simulate(simulation, steps, observers);
  } catch (const std::exception& failure) {
    try {
      close(failure.what());
    } catch (const Error&) {
      // the disk that is full, or whatever it was, has been told already
    }
    throw;
  }
  close(simulation.steps_done() == steps ? finished(simulation, observers.oracle, observers.monitor.verdict())
                                         : "interrupted");
}

template <class real>
void write_checkpoint(Simulation<real>& simulation, const std::string& scene, const SceneIdentity& identity,
                      const std::string& oracle, const std::string& path) {
  if (path.empty()) return;
  Backend<real>& backend = simulation.backend();
  const CheckpointLabel label = {scene, backend.name(), identity, combined_state_hash(simulation.world_hashes()),
                                 oracle};
  const Buffers<real>& state = backend.download(persistent_buffers(backend.features()));
  replace_file(path, encode_checkpoint(label, state, backend.features()));
}

struct Outcome {
  Report report;
  std::vector<WorldHash> hashes;
};

// The particles of each body, as they were compiled: with the model constraints they are its spheres.
template <class real>
std::vector<std::vector<Vector3>> particles_of(const Buffers<real>& b) {
  std::vector<std::vector<Vector3>> particles(b.body_infos.size());
  const auto add = [&](u32 body, const real* p) {
    particles[body].push_back({double(p[0]), double(p[1]), double(p[2])});
  };
  for (std::size_t i = 0; i < b.particle_bodies.size(); ++i) add(b.particle_bodies[i], &b.particle_offsets[i].x);
  for (std::size_t i = 0; i < b.shapes.size(); ++i)
    if (b.shape_infos[i].kind == SHAPE_SPHERE) add(b.shape_infos[i].body, b.shapes[i].offset);
  return particles;
}

template <class real>
void describe_particles(const Scene& scene, const InitialState<real>& state, Report& report) {
  // spheres that can touch nothing are not compiled
  const bool compiled = has(state.features, Feature::particles) || has(state.features, Feature::contacts);
  const std::vector<std::vector<Vector3>> particles =
      compiled ? particles_of(state.buffers) : particles_of(compile_shapes<real>(scene, Shown::particles));
  double count = 0, center = 0, inertia = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const ParticleFit fit = fit_of(scene.bodies[i], {particles[i]}, scene.particles->radius);
    count += static_cast<double>(fit.count);
    center = std::max(center, fit.center_error);
    inertia = std::max(inertia, fit.inertia_error);
  }
  report.particles = count * report.worlds;
  report.particle_center_error_m = center;
  report.particle_inertia_error = inertia;
}

void name_worst(std::span<const Scene> worlds, Report& report) {
  const auto name = [&](u32 id) { return id == NONE ? std::string() : worlds[report.worst->world].bodies[id].name; };
  report.worst_name_a = name(report.worst->body_a);
  report.worst_name_b = name(report.worst->body_b);
}

template <class real>
Outcome run_scene(std::span<const Scene> worlds, const RunOptions& options, EventLog& log) {
  const Scene& scene = worlds[0];
  Start<real> start = make_start<real>(worlds, options);
  InitialState<real>& state = start.state;
  if (options.is_first) tell_suspicions(scene, start);
  Recorder recorder = make_recorder(state);
  Monitor monitor(verdict_bounds(scene.settings), scene.settings.dt, energy_budget(state.buffers, state.features));

  Report report;
  report.scene = scene.name;
  report.precision = precision_of(scene.settings);
  report.solver = name_of(scene.settings.solver);
  report.joint_solver = name_of(scene.settings.joint_solver);
  report.friction_model = name_of(scene.settings.friction_model);
  report.worlds = state.sizes.worlds;
  report.bodies = state.sizes.bodies;
  report.joints = state.sizes.joints;
  report.first_step = start.steps_done;
  report.steps = scene.settings.steps - start.steps_done;
  report.dt = scene.settings.dt;
  report.substeps = substeps_of(scene.settings);
  report.iterations = iterations_of(scene.settings);
  report.shape_tolerances = shape_tolerances(scene.settings, state.features);
  report.tolerance = tolerance_of(scene.settings);

  if (scene.particles) describe_particles(scene, state, report);
  const StepParams<real> params = state.params;
  const u32 steps = scene.settings.steps;
  const OracleChoice oracle = state.oracle;
  const SceneIdentity identity = options.checkpoint.empty() ? SceneIdentity() : identity_of(state);
  std::unique_ptr<Backend<real>> backend = make_backend(state, options, report);
  Interrupt::defer();  // from here on there is something to keep
  const auto recording = make_recording(worlds.size() == 1 ? options.record : "", scene, report.device,
                                        options.device_options, state, options.record_forces);
  std::vector<RecordedWorld<real>> recorded;
  if (worlds.size() > 1) recorded = record_chosen<real>(worlds, options);
  start.state = {};  // all have what they need of it
  Simulation<real> simulation(std::move(backend), params, start.steps_done);
  StageSeconds first_step = {};
  EventGroups groups;
  if (has(simulation.backend().features(), Feature::events)) groups = EventGroups(worlds);
  {
    Progress progress(report.steps, !options.quiet);
    simulate_and_close(
        simulation, steps,
        {recorder, monitor, log, std::move(groups), progress, recording.get(), recorded, worlds, oracle, first_step});
  }
  report.interrupted = simulation.steps_done() < steps;
  report.steps = simulation.steps_done() - start.steps_done;
  expect_same_bits<real>(recorded, simulation.world_hashes());
  write_checkpoint(simulation, scene.name, identity, oracle.name, options.checkpoint);
  recorder.finish(report);
  if (report.worst) name_worst(worlds, report);
  report.verdict = monitor.verdict();
  report.max_penetration_m = std::max(report.max_penetration_m, monitor.overlap_m());
  if (report.joints > 0) {
    report.joint_drift_max_m = std::max(report.joint_drift_max_m.value_or(0), monitor.separation_m());
    report.joint_angle_max_rad = std::max(report.joint_angle_max_rad.value_or(0), monitor.joint_angle());
  }
  if (has(simulation.backend().features(), Feature::events)) report.events = log.counts();
  report.steps_redone = simulation.redone();
  if (has(simulation.backend().features(), Feature::sleeping)) {
    report.asleep = simulation.counters()[COUNTER_ASLEEP];
    report.islands_asleep = simulation.counters()[COUNTER_ISLANDS];
    report.wakings = simulation.wakings();
  }
  if (options.device_options.profile) report.stage_ms = mean_step(simulation.backend(), first_step, report);
  report.steps_by_plan = simulation.backend().steps_by_plan();
  report.device = simulation.backend().name();
  report.verdict.unsolved = simulation.unsolved();
  report.sensors = sensor_readings(worlds, simulation.backend(), simulation.params(), simulation.counters(),
                                   simulation.has_stepped());
  report.has_tolerance = oracle || has(simulation.backend().features(), Feature::tolerance);
  return {report, simulation.world_hashes()};
}

void expect_recordings_writable(const RunOptions& options) {
  if (options.worlds == 1) expect_writable(options.record, "the recording", recording_signature);
  for (const u32 world : options.record_worlds)
    expect_writable(path_of_world(options.record, world), "the recording", recording_signature);
}

// The worlds of this rank, which may have none. `is_shared`: there are other worlds or ranks.
Outcome run_share(RunOptions& options, const Share& share, bool is_shared) {
  if (share.count == 0) return {};
  expect_recordings_writable(options);
  expect_writable(options.checkpoint, "the checkpoint", checkpoint_signature);
  std::vector<Scene> worlds = read_worlds(options, share);
  Scene& scene = worlds[0];
  if (is_shared && is_oracle(scene.settings.solver))
    throw Error(Failure::input, "--solver",
                "an oracle solves one world; leave out --worlds, and run it without mpirun");
  if (options.record_forces && scene.settings.forces == Forces::automatic) scene.settings.forces = Forces::step;
  scene.settings.events = scene.settings.events || !options.events.empty();
  EventLog log(options.events, scene);
  Outcome outcome;
  try {
    with_precision(scene, [&](auto real) {
      outcome = with_item_names(worlds, [&] { return run_scene<decltype(real)>(worlds, options, log); });
    });
  } catch (const Error& error) {
    if (error.failure() != Failure::comparison || worlds.size() == 1) throw;
    throw Error(error.failure(), "",
                fmt::format("{}; world 0 is that of --seed {}, those after it have the seeds that follow", error.what(),
                            options.seed + share.first));
  }
  return outcome;
}

// What a batch cannot do, and what ranks cannot.
void expect_of_batch(RunOptions& options, const Ranks& ranks) {
  const auto refuse_in = [&](const std::string& what, std::initializer_list<std::pair<const char*, bool>> asked) {
    for (const auto& [name, is_there] : asked)
      if (is_there) throw Error(Failure::input, name, what);
  };
  if (options.worlds > 1 || ranks.size() > 1)
    refuse_in("is of one world: leave out --worlds and run it without mpirun, with --seed K for world K",
              {{"--events", !options.events.empty()}});
  if (ranks.size() > 1)
    refuse_in("is of one process: run it without mpirun", {{"--record", !options.record.empty()},
                                                           {"--checkpoint", !options.checkpoint.empty()},
                                                           {"--resume", !options.resume.empty()}});
  std::vector<u32>& chosen = options.record_worlds;
  if (options.worlds == 1 && !chosen.empty())
    throw Error(Failure::input, "--record-worlds", "is of a batch; leave it out, or ask for --worlds");
  if (options.worlds > 1 && !options.record.empty()) {
    if (chosen.empty())
      throw Error(Failure::input, "--record",
                  "records chosen worlds of a batch; say which by --record-worlds, as in --record-worlds 0,7");
    if (!options.resume.empty())
      throw Error(Failure::input, "--record", "records worlds of a batch from their beginning; leave out --resume");
  }
  std::ranges::sort(chosen);
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  if (!chosen.empty() && chosen.back() >= options.worlds)
    throw Error(Failure::input, "--record-worlds",
                fmt::format("has world {}, the last one is {}", chosen.back(), options.worlds - 1));
}

void run(RunOptions options) {
  expect_separate({{"--report", options.report},
                   {"--events", options.events},
                   {"--record", options.record},
                   {"--checkpoint", options.checkpoint}},
                  {{"the scene", options.scene}});
  // a checkpoint may follow the one that the run goes on from
  expect_separate({{"--report", options.report}, {"--events", options.events}, {"--record", options.record}},
                  {{"--resume", options.resume}});
  const Ranks ranks;
  const bool is_first = ranks.rank() == 0;
  std::optional<ReportFile> file;
  Outcome outcome;
  ranks.together([&] {
    const bool is_shared = options.worlds > 1 || ranks.size() > 1;
    expect_of_batch(options, ranks);
    if (is_first) file.emplace(options.report);
    RunOptions mine = options;
    mine.quiet = options.quiet || !is_first;
    mine.is_first = is_first;
    spread_devices(ranks, mine);
    outcome = run_share(mine, share_of(options.worlds, ranks), is_shared);
  });
  const Report report = merged(ranks, outcome.report, outcome.hashes);
  if (!is_first) return;
  file->write(to_json(report));
  if (!options.quiet) fmt::print("{}", to_table(report));
  expect_all_solved(report.scene, report.solver, report.verdict.unsolved);
  if (!report.verdict.good()) throw Error(Failure::comparison, report.scene, in_words(report.verdict));
}

}  // namespace

void add_run(CLI::App& program) {
  CLI::App* command = program.add_subcommand("run", "Simulate a scene; report speed and error");
  const auto options = std::make_shared<RunOptions>();
  add_scene_options(*command, *options);
  command
      ->add_option(
          "--worlds", options->worlds,
          "Simulate N independent worlds, seeded --seed, --seed + 1, ...; each has the bits of its single run. Under "
          "mpirun, processes share them")
      ->check(CLI::Validator(positive).description(""))
      ->check(CLI::Range(1u, 10000000u))
      ->capture_default_str();
  add_file_option(*command, "--report", options->report, "Write the report to this JSON file");
  add_file_option(*command, "--events", options->events,
                  "Write contact and trigger events to this file, as JSON Lines");
  add_file_option(*command, "--record", options->record, "Record every step in this HDF5 file");
  command
      ->add_option("--record-worlds", options->record_worlds,
                   "Record these of --worlds, counted from 0: world 3 of r.h5 in r.3.h5")
      ->delimiter(',')
      ->type_name("K,...")
      ->allow_extra_args(false)
      ->needs("--record");
  command->add_flag("--record-forces", options->record_forces, "Also record the force of each contact and joint")
      ->needs("--record");
  add_file_option(*command, "--checkpoint", options->checkpoint, "Write the final state to this file, for --resume");
  command->add_flag("--profile", options->device_options.profile, "Time each stage (slower)");
  command->add_flag("--quiet", options->quiet, "Print no progress bar and no table");
  command->footer(oracle_descriptions() +
                  "Example:\n  lockstep run spheres8000 --steps 120 --report out.json\n"
                  "  lockstep run incline --solver auto --tolerance 1e-12");
  command->callback([options] { run(*options); });
}

}  // namespace lockstep::app
