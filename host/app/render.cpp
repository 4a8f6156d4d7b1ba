#include <fmt/format.h>

#include <algorithm>

#include "host/app/commands.hpp"
#include "host/app/frames.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/progress.hpp"
#include "host/app/recorded_model.hpp"
#include "host/app/render_options.hpp"
#include "host/app/start.hpp"
#include "host/contact_geometry.hpp"
#include "host/error.hpp"
#include "host/record/recording_reader.hpp"
#include "host/report/monitor.hpp"
#include "host/report/report.hpp"
#include "host/scene/item_names.hpp"
#include "host/scene/read.hpp"
#include "host/scene/verdict_bounds.hpp"
#include "host/simulation.hpp"
#include "host/stop_request.hpp"
#include "host/world_hash.hpp"

namespace lockstep::app {

namespace {

Camera camera_of(const CameraDescription& description) {
  const auto vector = [](const Vector3& v) { return Eigen::Vector3d(v[0], v[1], v[2]); };
  return {vector(description.position), vector(description.target), description.fov_deg};
}

// Names of pictures begin with that of the scene, which may be anything.
std::string file_name(std::string scene) {
  std::replace(scene.begin(), scene.end(), '/', '_');
  return scene;
}

FrameOptions frame_options(const RenderOptions& options, const std::optional<CameraDescription>& of_scene, double dt) {
  FrameOptions frames = options.frames;
  frames.film_rate = film_rate(options.shown, dt);
  frames.camera = options.camera;
  if (!frames.camera && of_scene) frames.camera = camera_of(*of_scene);
  return frames;
}

void say_what_was_made(const Frames& frames, const RenderOptions& options) {
  if (options.quiet) return;
  const u32 count = frames.count();
  const std::string what = options.frames.film.empty()
                               ? fmt::format("{} picture{} in {}/", count, count == 1 ? "" : "s", options.frames.folder)
                               : fmt::format("{}, {} pictures", options.frames.film, count);
  fmt::print("{}, {}x{}, {}: {:.1f} ms a picture to draw, {:.1f} ms to write\n", what, options.frames.width,
             options.frames.height, frames.driver(), frames.draw_ms() / std::max(count, 1u),
             frames.write_ms() / std::max(count, 1u));
}

// What a picture needs of the state after a step.
template <class real>
ShownState shown_state_of(Simulation<real>& simulation, const Buffers<real>& constants, const FrameOptions& options) {
  Backend<real>& backend = simulation.backend();
  const Features features = backend.features();
  std::vector<Buffer> wanted = value_buffers(options.color_by, features);
  wanted.insert(wanted.end(), {Buffer::positions, Buffer::orientations});
  const bool touching = has(features, Feature::contacts) && (options.contacts || options.forces);
  if (touching) std::ranges::copy(contact_mark_buffers(features), std::back_inserter(wanted));
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  const Buffers<real>& current = backend.download(wanted);
  ShownState shown_state;
  shown_state.step = simulation.steps_done();
  shown_state.poses = poses_of(current.positions, current.orientations);
  shown_state.values = body_values(options.color_by, current, backend.sizes().bodies, features, simulation.counters());
  if (touching)
    shown_state.contacts =
        contact_marks(current, simulation.counters()[COUNTER_CONTACTS], impulse_time(simulation.params(), features));
  if (options.joints) shown_state.joints = joint_marks(constants, current.positions, current.orientations);
  return shown_state;
}

// Simulates up to the last step that is shown.
template <class real>
void simulate(Simulation<real>& simulation, const std::vector<u32>& shown, const Buffers<real>& constants,
              const RenderOptions& options, Monitor& monitor, Frames& frames) {
  const u32 first = simulation.steps_done();
  Progress progress(shown.back() - first, !options.quiet);
  for (auto next = shown.begin(); next != shown.end() && !Interrupt::asked();) {
    while (simulation.steps_done() < *next && !Interrupt::asked()) {
      try {
        simulation.step();
      } catch (const Stopped&) {
        return;
      }
      monitor.observe(simulation.counters(), simulation.params(), simulation.steps_done() - 1);
      progress.update(simulation.steps_done() - first);
    }
    if (simulation.steps_done() < *next) break;
    frames.add(shown_state_of(simulation, constants, options.frames));
    ++next;
  }
}

template <class real>
void render_scene(const Scene& scene, const RenderOptions& options) {
  Start<real> start = make_start<real>(scene, options);
  tell_suspicions(scene, start);
  const double dt = scene.settings.dt;
  const std::vector<u32> shown =
      shown_steps(options.shown, start.steps_done, scene.settings.steps, dt, !options.frames.film.empty());
  const Buffers<real> constants = start.state.buffers;
  if (options.frames.color_by == ColorBy::color && has(start.state.features, Feature::jacobi))
    throw Error(Failure::input, "--color-by color", "this solver solves all contacts at once: there are no colours");
  if (options.frames.color_by == ColorBy::color && has(start.state.features, Feature::partitions))
    throw Error(Failure::input, "--color-by color", "this solver solves contacts by cells: there are no colours");
  expect_pictures_writable(options, file_name(scene.name), shown.front());
  Frames frames(frame_options(options, scene.camera, dt), SceneModel(compile_shapes<real>(scene, options.frames.shown)),
                file_name(scene.name), dt);
  Monitor monitor(verdict_bounds(scene.settings), scene.settings.dt,
                  energy_budget(start.state.buffers, start.state.features));
  Simulation<real> simulation = with_item_names({&scene, 1}, [&] { return lockstep::app::simulate(start, options); });
  Interrupt::defer();
  try {
    with_item_names({&scene, 1}, [&] { simulate(simulation, shown, constants, options, monitor, frames); });
  } catch (const Error&) {
    frames.finish();  // what there is shows how it went bad
    throw;
  }
  frames.finish();
  say_what_was_made(frames, options);
  if (!options.quiet) fmt::print("state hash {}\n", hash_text(combined_state_hash(simulation.world_hashes())));
  tell_if_bad(scene.name, monitor.verdict());
  expect_all_solved(scene.name, name_of(scene.settings.solver), simulation.unsolved());
}

template <class real>
ShownState shown_state_of(const RecordingReader& recording, const InitialState<real>& start, u32 step,
                          const FrameOptions& options) {
  const u32 bodies = start.sizes.bodies, before = start.buffers.step_index.front();
  Buffers<real> current;
  current.positions = start.buffers.positions;
  current.orientations = start.buffers.orientations;
  current.motions = start.buffers.motions;
  if (step > before) {
    const u32 row = step - before - 1;
    const std::vector<real> x = recording.bodies<real>(0, row), q = recording.bodies<real>(1, row);
    const std::vector<real> v = recording.bodies<real>(2, row);
    for (u32 i = 0; i < bodies; ++i) {
      current.positions[i] = {x[3 * i], x[3 * i + 1], x[3 * i + 2], 0};
      current.orientations[i] = {q[4 * i], q[4 * i + 1], q[4 * i + 2], q[4 * i + 3]};
      std::copy_n(&v[3 * i], 3, current.motions[i].v);
    }
  }
  ShownState shown_state;
  shown_state.step = step;
  shown_state.poses = poses_of(current.positions, current.orientations);
  shown_state.values = body_values(options.color_by, current, bodies, 0, Counters());
  if (options.joints) shown_state.joints = joint_marks(start.buffers, current.positions, current.orientations);
  return shown_state;
}

template <class real>
void render_recording(const RecordingReader& recording, const RenderOptions& options) {
  const InitialState<real> start = recording.start<real>();
  const RecordingLabel& label = recording.label();
  const double dt = recording.dt(start.params);
  const u32 first = start.buffers.step_index.front();
  const std::vector<u32> shown =
      shown_steps(options.shown, first, first + recording.steps(), dt, !options.frames.film.empty());
  expect_pictures_writable(options, file_name(label.scene), shown.front());
  // a world that was made in code has no text
  const std::string& source = label.source.empty() ? options.scene : label.source;
  const auto camera = label.scene_text.empty() ? std::nullopt : parse_camera(label.scene_text, source);
  const FrameOptions frame = frame_options(options, camera, dt);
  Frames frames(frame, recorded_model(start, label, options.frames.shown), file_name(label.scene), dt);
  Interrupt::defer();
  {
    Progress progress(static_cast<u32>(shown.size()), !options.quiet);
    for (u32 i = 0; i < shown.size() && !Interrupt::asked(); ++i) {
      frames.add(shown_state_of(recording, start, shown[i], frame));
      progress.update(i + 1);
    }
  }
  frames.finish();
  say_what_was_made(frames, options);
}

void render(const CLI::App& command, RenderOptions& options) {
  finish_render_options(command, options);
  if (is_recording(options.scene)) {
    expect_recording_suffices(command, options);
    const RecordingReader recording(options.scene);
    if (recording.precision() == "double")
      render_recording<double>(recording, options);
    else
      render_recording<float>(recording, options);
    return;
  }
  Scene scene = read_scene_with(options);
  if (options.frames.forces && scene.settings.forces == Forces::automatic) scene.settings.forces = Forces::step;
  with_precision(scene, [&](auto real) { render_scene<decltype(real)>(scene, options); });
}

}  // namespace

void add_render(CLI::App& program) {
  CLI::App* command = program.add_subcommand("render", "Draw pictures or a film of a scene or a recording");
  const auto options = std::make_shared<RenderOptions>();
  add_render_options(*command, *options);
  command->footer(
      "Example:\n  lockstep render pyramid20 --at 300\n"
      "  lockstep render heap.h5 --video heap.mp4 --color-by speed");
  command->callback([command, options] { render(*command, *options); });
}

}  // namespace lockstep::app
