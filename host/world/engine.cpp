#include "host/world/engine.hpp"

#include <algorithm>
#include <chrono>
#include <functional>

#include "host/backends/first_contacts.hpp"
#include "host/record/checkpoint.hpp"
#include "host/record/current_state.hpp"
#include "host/record/inputs.hpp"
#include "host/record/record_step.hpp"
#include "host/report/joints.hpp"
#include "host/report/measures.hpp"
#include "host/report/monitor.hpp"
#include "host/report/report.hpp"
#include "host/scene/verdict_bounds.hpp"
#include "host/simulation.hpp"
#include "host/sleepers.hpp"
#include "host/steppers/measure_backend.hpp"
#include "host/steppers/reported_contacts.hpp"
#include "host/steppers/sensors.hpp"
#include "host/steppers/stepper.hpp"
#include "host/world/angular_velocity.hpp"
#include "host/world/migrate_state.hpp"

namespace lockstep {

namespace {

template <class real>
Vector3 vector(const real* p) {
  return {double(p[0]), double(p[1]), double(p[2])};
}

Vector3 vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

template <class real>
Quaternion quaternion(const Vec4<real>& q) {
  return {double(q.x), double(q.y), double(q.z), double(q.w)};
}

template <class real>
void store(const Vector3& from, real* to) {
  for (unsigned k = 0; k < 3; ++k) to[k] = static_cast<real>(from[k]);
}

template <class real>
class EngineOf final : public Engine {
 public:
  EngineOf(const Scene& scene, const WorldOptions& options, EngineOf* before, const IndexMap& index_map,
           bool waits_for_kernels)
      : constants_(compile<real>(scene)), dt_(scene.settings.dt) {
    if (before) {
      Backend<real>& backend = before->simulation_->backend();
      const std::vector<Buffer> wanted = persistent_buffers(backend.features());
      migrate_state(before->constants_, backend.download(wanted), index_map, constants_);
    }
    support_ = constants_.buffers.loads;
    DeviceOptions device_options;
    device_options.threads = options.threads;
    device_options.waits_for_kernels = waits_for_kernels;
    if (!options.quiet) device_options.tell_building = tell_on_terminal;
    if (has(constants_.features, Feature::contacts)) described_ = DescribedShapes({&scene, 1});
    if (has(constants_.features, Feature::events)) groups_ = EventGroups({&scene, 1});
    Stepper<real> stepper = make_stepper(constants_, target_of(options.device, device_options, constants_.oracle));
    canary_ = std::move(stepper.canary);
    simulation_ = std::make_unique<Simulation<real>>(std::move(stepper.backend), constants_.params,
                                                     constants_.buffers.step_index.front());
    monitor_ = std::make_unique<Monitor>(verdict_bounds(scene.settings), scene.settings.dt,
                                         energy_budget(constants_.buffers, constants_.features));
    if (!before) return;
    changed_step_ = before->changed_step_;
    starts_cold_ = before->starts_cold_;
    const auto weighs_another = [&](u32 body) {
      const u32 index = index_map.bodies[body];
      return index != NONE &&
             constants_.buffers.masses[index].inverse_mass != before->constants_.buffers.masses[body].inverse_mass;
    };
    if (std::ranges::any_of(index_map.changed_bodies, weighs_another)) note_change();
  }

  WorldDevice device() const override {
    const CanaryVerdict verdict = canary_();
    return {simulation_->backend().name(), verdict.bit_exact(), describe(verdict)};
  }

  void step(const ItemNamer& name) override;
  u32 steps_done() const override { return simulation_->steps_done(); }
  std::uint64_t state_hash() override { return combined_state_hash(simulation_->world_hashes()); }
  Unsolved unsolved() const override { return simulation_->unsolved(); }
  void expect_not_failed() const override { simulation_->expect_not_failed(); }

  Verdict verdict() override {
    Monitor so_far = *monitor_;  // who asks changes nothing
    so_far.observe(measures(), simulation_->steps_done());
    Verdict verdict = so_far.verdict();
    verdict.unsolved = simulation_->unsolved();
    return verdict;
  }
  std::vector<FirstContact> first_contacts(const Scene& scene) const override {
    InitialState<real> copy = constants_;
    return lockstep::first_contacts(scene, copy);
  }

  std::vector<Pose> poses() override {
    const Buffers<real>& b = download({Buffer::positions, Buffer::orientations});
    std::vector<Pose> poses(b.positions.size());
    for (std::size_t i = 0; i < poses.size(); ++i)
      poses[i] = {vector(&b.positions[i].x), quaternion(b.orientations[i])};
    return poses;
  }

  std::vector<Twist> velocities() override {
    const Buffers<real>& b = download({Buffer::motions});
    std::vector<Twist> velocities(constants_.sizes.bodies);
    for (std::size_t i = 0; i < velocities.size(); ++i)
      velocities[i] = {vector(b.motions[i].v), vector(b.motions[i].w)};
    return velocities;
  }

  std::vector<bool> asleep() override {
    std::vector<bool> asleep(constants_.sizes.bodies, false);
    if (!has(constants_.features, Feature::sleeping)) return asleep;
    const Buffers<real>& b = download({Buffer::sleepers});
    for (std::size_t i = 0; i < asleep.size(); ++i) asleep[i] = is_asleep(b.sleepers[i]);
    return asleep;
  }

  std::vector<ReportedContact> contacts() override {
    return reported_contacts<real>(simulation_->backend(), simulation_->params(), simulation_->counters(),
                                   constants_.buffers.shape_infos, described_);
  }

  std::vector<EngineEvent> events() override { return without_worlds(simulation_->events(groups_)); }

  std::vector<EngineEvent> ends(const IndexMap& index_map, const Engine& next) override {
    if (!has(constants_.features, Feature::events)) return {};
    const std::vector<Pair> touching = simulation_->touching();
    const InitialState<real>& current = static_cast<const EngineOf&>(next).constants_;
    return without_worlds(groups_.ends(touching, pairs_gone<real>(constants_, touching, index_map, current)));
  }

  std::vector<std::optional<EngineHit>> cast_rays(std::span<const RayQuery> rays) override {
    std::vector<std::optional<EngineHit>> hits;
    for (const RayHit& hit : simulation_->cast_rays(rays)) {
      hits.emplace_back();
      if (hit.hit) hits.back() = {described_[hit.shape], hit.distance, hit.point, hit.normal};
    }
    return hits;
  }

  std::vector<u32> bodies_in(const VolumeQuery& volume) override {
    std::vector<u32> bodies;
    for (const Overlap& overlap : simulation_->find_overlaps({&volume, 1}))
      if (bodies.empty() || bodies.back() != overlap.body) bodies.push_back(overlap.body);
    return bodies;
  }

  JointState joint_state(u32 joint) override;
  SensorReading joint_reading(const SensorDescription& sensor) override {
    return lockstep::joint_reading(sensor,
                                   JointSources(simulation_->backend(), simulation_->has_stepped()).of(sensor.joint),
                                   simulation_->params());
  }
  StepErrors errors() override;

  void set_velocities(const std::map<u32, Twist>& velocities) override {
    std::vector<InputRow> inputs;
    for (const auto& [body, velocity] : velocities)
      inputs.push_back(input(body, InputKind::velocity, velocity.linear, velocity.angular));
    act_and_record(inputs);
  }

  void set_loads(const std::map<u32, Wrench>& loads) override {
    std::vector<InputRow> inputs;
    for (u32 body = 0; body < constants_.buffers.loads.size(); ++body) {
      const auto load = loads.find(body);
      Wrench wanted = load == loads.end() ? Wrench{} : load->second;
      wanted.force = exact::add(wanted.force, vector(support_[body].force));
      const InputRow row = input(body, InputKind::load, wanted.force, wanted.torque);
      const Load<real>& acts = constants_.buffers.loads[body];
      if (!std::equal(row.linear, row.linear + 3, acts.force) || !std::equal(row.angular, row.angular + 3, acts.torque))
        inputs.push_back(row);
    }
    act_and_record(inputs);
  }

  void drive_joints(std::span<const JointDescription> joints) override {
    std::vector<InputRow> inputs;
    for (u32 j = 0; j < joints.size(); ++j) {
      const JointDrive drive = drive_of(joints[j]);
      const InputRow row = input(j, InputKind::motor, {drive.speed, drive.force, 0}, {0, 0, 0});
      const Joint<real>& driven = constants_.buffers.joints[j];
      if (row.linear[0] != driven.motor_speed || row.linear[1] != driven.motor_force) inputs.push_back(row);
      if (!joints[j].spring) continue;
      const InputRow rest = input(j, InputKind::rest, {joints[j].spring->rest, 0, 0}, {0, 0, 0});
      if (rest.linear[0] != spring_rest(driven)) inputs.push_back(rest);
    }
    act_and_record(inputs);
  }

  void set_gravity(const Vector3& gravity) override {
    const InputRow row = input(0, InputKind::gravity, gravity, {0, 0, 0});
    const Vec4<real>& pulls = constants_.buffers.gravities[0];
    if (row.linear[0] != pulls.x || row.linear[1] != pulls.y || row.linear[2] != pulls.z) act_and_record({row});
  }

  void record(const std::string& path, const Scene& scene, bool forces) override {
    end_recording();
    const RecordingLabel label = {scene.name, simulation_->backend().name(), "{}", scene.text, scene.source, dt_};
    ++recordings_;
    recording_ = std::make_unique<RecordingWriter<real>>(path, label, current_state(constants_, *simulation_),
                                                         Recorded{.inputs = true, .forces = forces});
  }

  void end_recording() override {
    if (const auto recording = std::move(recording_))
      recording->close(finished(*simulation_, constants_.oracle, verdict()));
  }

  std::unique_ptr<SavedEngine> save() override {
    auto saved = std::make_unique<Saved>();
    saved->simulation = simulation_->save();
    saved->driven = driven_by_inputs(constants_.buffers);
    saved->monitor = *monitor_;
    saved->changed_step = changed_step_;
    saved->starts_cold = starts_cold_;
    saved->recording = recording_ ? recordings_ : 0;
    if (recording_) saved->position = recording_->position();
    return saved;
  }

  bool restore(SavedEngine& of) override {
    auto& saved = static_cast<Saved&>(of);
    const bool is_noted = recording_ && saved.recording == recordings_;
    if (!is_noted) end_recording();
    simulation_->restore(saved.simulation);
    constants_.buffers.loads = saved.driven.loads;
    constants_.buffers.joints = saved.driven.joints;
    constants_.buffers.gravities = saved.driven.gravities;
    *monitor_ = *saved.monitor;
    changed_step_ = saved.changed_step;
    starts_cold_ = saved.starts_cold;
    if (!is_noted) return false;
    InputRow row = {.step = steps_done() + 1, .body = saved.position.rows, .kind = InputKind::restore};
    row.linear[0] = saved.position.inputs;
    recording_->add(row);
    return true;
  }

  bool has_kernels() const override { return simulation_->backend().name() != "reference"; }

  Twist rounded(const Twist& velocity) const override {
    real v[3], w[3];
    store(velocity.linear, v);
    store(velocity.angular, w);
    return {vector(v), vector(w)};
  }

  Twist after_impulse(u32 body, const Pose& pose, const Twist& velocity, const Vector3& impulse,
                      const Vector3& point) const override;
  Twist velocity_between(const Pose& current, const Pose& target) const override;

 private:
  struct Saved final : SavedEngine {
    SavedSimulation simulation;
    Buffers<real> driven;
    std::optional<Monitor> monitor;
    u32 recording = 0;  // which was under way; 0: none
    RecordingPosition position;
    u32 changed_step = 0;
    bool starts_cold = false;
  };

  const Buffers<real>& download(std::initializer_list<Buffer> wanted) {
    return simulation_->backend().download(std::span(wanted.begin(), wanted.size()));
  }

  static std::vector<EngineEvent> without_worlds(const std::vector<PairEvent>& events) {
    std::vector<EngineEvent> all;
    for (const PairEvent& event : events) all.push_back({event.kind, event.a, event.b, event.impact});
    return all;
  }

  InputRow input(u32 body, InputKind kind, const Vector3& linear, const Vector3& angular) const {
    InputRow row = {.step = simulation_->steps_done() + 1, .body = body, .kind = kind};
    for (unsigned k = 0; k < 3; ++k) {
      row.linear[k] = static_cast<real>(linear[k]);
      row.angular[k] = static_cast<real>(angular[k]);
    }
    return row;
  }

  void act_and_record(const std::vector<InputRow>& inputs) {
    if (inputs.empty()) return;
    act(std::span<const InputRow>(inputs), *simulation_, constants_.buffers);
    note_change(inputs);
    tell_monitor(inputs);
    if (!recording_) return;
    for (const InputRow& row : inputs) recording_->add(row);
  }

  // The next step starts cold where what acts has changed, and had not before the step before: what changes with each
  // step is a scene that runs.
  void note_change(const std::vector<InputRow>& inputs) {
    const auto changes = [](const InputRow& row) {
      return row.kind == InputKind::load || row.kind == InputKind::motor || row.kind == InputKind::gravity;
    };
    if (std::ranges::any_of(inputs, changes)) note_change();
  }

  void note_change() {
    const u32 next = steps_done() + 1;
    starts_cold_ = starts_cold_ || changed_step_ + 1 < next;
    changed_step_ = next;
  }

  // What was done from outside is no gain of energy.
  void tell_monitor(const std::vector<InputRow>& inputs) {
    const Buffers<real>& b = constants_.buffers;
    monitor_->restart(motor_power(b.joints));
    for (const InputRow& row : inputs) {
      if (row.kind == InputKind::gravity) monitor_->set_negligible(energy_budget(b, constants_.features).negligible);
      if (row.kind == InputKind::load) monitor_->add_source(EnergySource::loads);
      if (row.kind == InputKind::velocity && b.body_infos[row.body].kind == BODY_KINEMATIC)
        monitor_->add_source(EnergySource::kinematic_bodies);
      if (row.kind == InputKind::rest) monitor_->add_source(EnergySource::servos);
      if (row.kind == InputKind::motor && row.linear[0] != 0 && row.linear[1] >= double(JOINT_UNBOUNDED))
        monitor_->add_source(EnergySource::unbounded_motors);
    }
  }

  Measures measures() {
    return measure(simulation_->backend(), simulation_->params(), simulation_->measured_counters());
  }

  InitialState<real> constants_;  // and the state that the simulation started from; what inputs drive is that of now
  std::unique_ptr<Simulation<real>> simulation_;
  DescribedShapes described_;
  EventGroups groups_;
  decltype(Buffers<real>::loads) support_;  // what holds the weight of bodies, beside what is asked for
  std::unique_ptr<Monitor> monitor_;
  std::function<CanaryVerdict()> canary_;  // of the device that computes
  double dt_;                              // of a step
  std::unique_ptr<RecordingWriter<real>> recording_;
  u32 recordings_ = 0;        // so far
  u32 changed_step_ = 0;      // the last one before which what acts or a mass was changed
  bool starts_cold_ = false;  // the next step
};

template <class real>
void EngineOf<real>::step(const ItemNamer& name) {
  const auto begin = std::chrono::steady_clock::now();
  try {
    try {
      const bool has_springs = simulation_->params().softness > 0;
      if (std::exchange(starts_cold_, false) && !has_springs) act_and_record({input(0, InputKind::cold_start, {}, {})});
      simulation_->step();
    } catch (const ItemError& error) {
      throw error.named(name(error.item(), error.id()));
    }
    monitor_->observe(simulation_->counters(), simulation_->params(), simulation_->steps_done() - 1);
  } catch (const Error& error) {
    if (const auto recording = std::move(recording_)) recording->close(error.what());
    throw;
  }
  const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - begin;
  if (recording_) record_step(*recording_, *simulation_, ms.count());
}

template <class real>
JointState EngineOf<real>::joint_state(u32 joint) {
  const JointSource<real> source = JointSources(simulation_->backend(), simulation_->has_stepped()).of(joint);
  const JointMeasures of = measure_joint(source.buffers, simulation_->params(), joint, source.impulses);
  return {of.coordinate, of.speed, of.drive, vector(of.force), vector(of.torque), of.drift.separation, of.drift.angle};
}

template <class real>
StepErrors EngineOf<real>::errors() {
  const Measures of = measures();
  const WorldMeasures& world = of.worlds[0];
  StepErrors errors;
  errors.kinetic = world.kinetic;
  errors.potential = world.potential;
  errors.momentum = vector(world.momentum);
  errors.angular_momentum = vector(world.angular_momentum);
  errors.contacts = of.contacts;
  errors.max_penetration = of.penetration.max;
  errors.mean_penetration = of.penetration.mean;
  if (of.residual) {
    errors.residual = of.residual->relative;
    errors.defect_velocity = of.residual->defect_max;
  }
  if (of.joint_drift) {
    errors.joint_separation = of.joint_drift->separation;
    errors.joint_angle = of.joint_drift->angle;
  }
  return errors;
}

template <class real>
Twist EngineOf<real>::after_impulse(u32 body, const Pose& pose, const Twist& velocity, const Vector3& impulse,
                                    const Vector3& point) const {
  const Mass<real>& mass = constants_.buffers.masses[body];
  const Quaternion &q = pose.orientation, back = {-q[0], -q[1], -q[2], q[3]};
  const bool pivoted = has(constants_.features, Feature::pivots) && constants_.buffers.pivots[body].pivoted != real(0);
  const Vector3 about = pivoted ? vector(constants_.buffers.pivots[body].point_world) : pose.position;
  const Vector3 moment = exact::rotate(back, exact::cross(exact::subtract(point, about), impulse));
  const Vector3 inverse = vector(mass.inverse_inertia);
  const Vector3 delta_w = exact::rotate(q, {inverse[0] * moment[0], inverse[1] * moment[1], inverse[2] * moment[2]});
  Twist after = {velocity.linear, exact::add(velocity.angular, delta_w)};
  after.linear = pivoted ? exact::cross(after.angular, exact::subtract(pose.position, about))
                         : exact::add(after.linear, exact::scale(double(mass.inverse_mass), impulse));
  return after;
}

template <class real>
Twist EngineOf<real>::velocity_between(const Pose& current, const Pose& target) const {
  return {exact::scale(1 / dt_, exact::subtract(target.position, current.position)),
          angular_velocity_between(current.orientation, target.orientation, dt_)};
}

}  // namespace

std::unique_ptr<Engine> make_engine(const Scene& scene, const WorldOptions& options, Engine* before,
                                    const IndexMap& index_map, bool waits_for_kernels) {
  if (precision_of(scene.settings) == "double")
    return std::make_unique<EngineOf<double>>(scene, options, static_cast<EngineOf<double>*>(before), index_map,
                                              waits_for_kernels);
  return std::make_unique<EngineOf<float>>(scene, options, static_cast<EngineOf<float>*>(before), index_map,
                                           waits_for_kernels);
}

}  // namespace lockstep
