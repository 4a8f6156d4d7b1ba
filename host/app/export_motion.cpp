#include "host/app/export_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "host/app/interrupt.hpp"
#include "host/app/motion_file.hpp"
#include "host/app/progress.hpp"
#include "host/app/recorded_model.hpp"
#include "host/app/render_options.hpp"
#include "host/app/start.hpp"
#include "host/error.hpp"
#include "host/record/recording_reader.hpp"
#include "host/report/monitor.hpp"
#include "host/scene/item_names.hpp"
#include "host/scene/read.hpp"
#include "host/scene/verdict_bounds.hpp"
#include "host/simulation.hpp"
#include "host/stop_request.hpp"

namespace lockstep::app {

namespace {

constexpr double usual_rate = 60;  // keyframes a second
constexpr const char* signature = "glTF";
constexpr Buffer pose_buffers[] = {Buffer::positions, Buffer::orientations};

// What does not change over a motion.
struct Still {
  std::string name;
  std::vector<BodyInfo> bodies;
  std::vector<std::string> body_names;  // empty where they are not known
  std::vector<RenderPose> start;
  std::vector<u32> steps;  // of the keyframes
  double dt = 0;           // s
};

// Evenly spread by the rate, at most one a step; the first and the last among them.
std::vector<u32> keyframe_steps(double rate, u32 first, u32 last, double dt) {
  const double stride = std::max(1.0, 1 / (rate * dt));
  std::vector<u32> steps;
  for (u32 i = 0;; ++i) {
    const double at = std::round(first + i * stride);
    if (at >= last) break;
    steps.push_back(static_cast<u32>(at));
  }
  steps.push_back(last);
  return steps;
}

std::vector<std::string> names_of(const Scene& scene) {
  std::vector<std::string> names;
  for (const BodyDescription& body : scene.bodies) names.push_back(body.name);
  return names;
}

// A world that was made in code has no text, and a mesh of a scene may be somewhere else by now: no names then.
std::vector<std::string> recorded_names(const RecordingLabel& label) {
  try {
    return names_of(parse_scene(label.scene_text, label.source));
  } catch (const Error&) {
    return {};
  }
}

MotionGltf gltf_of(const Still& still, const SceneModel& model, const Region& region) {
  std::vector<MotionBody> bodies(model.bodies());
  const bool named = still.body_names.size() == bodies.size();
  for (u32 i = 0; i < bodies.size(); ++i) {
    bodies[i].name = named ? still.body_names[i] : "";
    if (bodies[i].name.empty()) bodies[i].name = fmt::format("body {}", i);
    bodies[i].moves = still.bodies[i].kind != BODY_STATIC;
    bodies[i].start = still.start[i];
  }
  std::vector<float> seconds;
  for (const u32 step : still.steps) seconds.push_back(static_cast<float>((step - still.steps[0]) * still.dt));
  return MotionGltf(model, bodies, region, seconds, still.name);
}

// `poses_at(step)`: called once for each keyframe, in order.
template <class PosesAt>
void write_motion(const MotionOptions& options, const Still& still, const SceneModel& model, const Region& region,
                  PosesAt&& poses_at) {
  const u32 keyframes = static_cast<u32>(still.steps.size());
  Interrupt::defer();  // the file has another name until it is whole, and is to go
  MotionFile file(options.output, gltf_of(still, model, region), keyframes);
  {
    Progress progress(keyframes, !options.quiet);
    for (u32 i = 0; i < keyframes; ++i) {
      file.add(poses_at(still.steps[i]));
      progress.update(i + 1);
      if (Interrupt::asked()) throw Error(Failure::device, options.output, "interrupted, and not written");
    }
  }
  file.close();
  if (options.quiet) return;
  std::error_code error;
  fmt::print("{}: {} bodies, {} keyframes over {:.4g} s, {:.1f} MB\n", options.output, model.bodies(), keyframes,
             (still.steps.back() - still.steps[0]) * still.dt,
             static_cast<double>(std::filesystem::file_size(options.output, error)) * 1e-6);
}

template <class real>
std::vector<RenderPose> recorded_poses(const RecordingReader& recording, const InitialState<real>& start, u32 step) {
  const u32 before = start.buffers.step_index.front();
  if (step == before) return poses_of(start.buffers.positions, start.buffers.orientations);
  const std::vector<real> x = recording.bodies<real>(0, step - before - 1);
  const std::vector<real> q = recording.bodies<real>(1, step - before - 1);
  if (x.size() != 3 * std::size_t{start.sizes.bodies} || q.size() != 4 * std::size_t{start.sizes.bodies})
    throw Error(Failure::input, recording.label().scene, "has tables of another number of bodies in its recording");
  std::vector<RenderPose> poses(start.sizes.bodies);
  for (u32 i = 0; i < poses.size(); ++i) {
    const auto in_float = [](real value) { return static_cast<float>(value); };
    poses[i].position = {in_float(x[3 * i]), in_float(x[3 * i + 1]), in_float(x[3 * i + 2])};
    poses[i].rotation =
        Eigen::Quaternionf(in_float(q[4 * i + 3]), in_float(q[4 * i]), in_float(q[4 * i + 1]), in_float(q[4 * i + 2]));
  }
  return poses;
}

template <class real>
void export_recording(const RecordingReader& recording, const MotionOptions& options) {
  const InitialState<real> start = recording.start<real>();
  const RecordingLabel& label = recording.label();
  Still still = {label.scene, start.buffers.body_infos, recorded_names(label), {}, {}, 0};
  still.start = poses_of(start.buffers.positions, start.buffers.orientations);
  still.dt = recording.dt(start.params);
  const u32 first = start.buffers.step_index.front();
  still.steps = keyframe_steps(options.fps.value_or(usual_rate), first, first + recording.steps(), still.dt);
  const SceneModel model = recorded_model(start, label);
  Region region;
  for (const std::size_t at : {std::size_t{0}, still.steps.size() / 2, still.steps.size() - 1})
    region.extend(region_of(model.extents(recorded_poses(recording, start, still.steps[at]))));
  write_motion(options, still, model, region, [&](u32 step) { return recorded_poses(recording, start, step); });
}

template <class real>
void export_scene(const Scene& scene, const MotionOptions& options) {
  Start<real> start = make_start<real>(scene, options);
  tell_suspicions(scene, start);
  Still still = {scene.name, start.state.buffers.body_infos, names_of(scene), {}, {}, 0};
  still.start = poses_of(start.state.buffers.positions, start.state.buffers.orientations);
  still.dt = scene.settings.dt;
  still.steps = keyframe_steps(options.fps.value_or(usual_rate), start.steps_done, scene.settings.steps, still.dt);
  const SceneModel model(compile_shapes<real>(scene));
  Monitor monitor(verdict_bounds(scene.settings), scene.settings.dt,
                  energy_budget(start.state.buffers, start.state.features));
  Simulation<real> simulation = with_item_names({&scene, 1}, [&] { return simulate(start, options); });
  write_motion(options, still, model, region_of(model.extents(still.start)), [&](u32 step) {
    try {
      while (simulation.steps_done() < step && !Interrupt::asked()) {
        with_item_names({&scene, 1}, [&] { simulation.step(); });
        monitor.observe(simulation.counters(), simulation.params(), simulation.steps_done() - 1);
      }
    } catch (const Stopped&) {
    }
    const Buffers<real>& current = simulation.backend().download(pose_buffers);
    return poses_of(current.positions, current.orientations);
  });
  tell_if_bad(scene.name, monitor.verdict());
  expect_all_solved(scene.name, name_of(scene.settings.solver), simulation.unsolved());
}

}  // namespace

bool is_motion(const std::string& output) {
  const auto extension = std::filesystem::path(output).extension();
  if (extension == ".gltf")
    throw Error(Failure::input, output, "would be several files; a motion is written as one, let its name end in .glb");
  return extension == ".glb";
}

void export_motion(const CLI::App& command, const MotionOptions& options) {
  for (const char* name : {"--at", "--local", "--sizes"}) {
    if (command.count(name) > 0)
      throw Error(Failure::input, name, "is for the constraint system of a step, and a .glb file holds a motion");
  }
  expect_writable(options.output, "the motion", signature);
  if (is_recording(options.scene)) {
    expect_nothing_simulated(command, options.scene, {"scene", "output", "fps", "quiet", "help"});
    const RecordingReader recording(options.scene);
    if (recording.precision() == "double")
      export_recording<double>(recording, options);
    else
      export_recording<float>(recording, options);
    return;
  }
  const Scene scene = read_scene_with(options);
  with_precision(scene, [&](auto real) { export_scene<decltype(real)>(scene, options); });
}

}  // namespace lockstep::app
