// Bodies and joints that come and go, time, and what acts.
#include <cmath>

#include "host/scene/couplings.hpp"
#include "host/scene/planar_bodies.hpp"
#include "host/scene/read.hpp"
#include "host/scene/sensors.hpp"
#include "host/scene/setting_table.hpp"
#include "host/world/impl.hpp"

namespace lockstep {

namespace {

// The handle of what has this name.
template <class Item, class Handle>
std::optional<Handle> find_named(const std::vector<Item>& items, const Handles<Handle>& handles,
                                 const std::string& name) {
  const auto found = std::ranges::find(items, name, &Item::name);
  if (found == items.end()) return std::nullopt;
  return handles[static_cast<std::size_t>(found - items.begin())];
}

}  // namespace

std::function<Wrench(double)> load_table(std::vector<std::pair<double, Wrench>> rows) {
  if (rows.empty()) throw Error(Failure::input, "load table", "has no rows");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    expect_finite(rows[i].second);
    if (!std::isfinite(rows[i].first) || (i > 0 && !(rows[i].first > rows[i - 1].first)))
      throw Error(Failure::input, "load table, row " + std::to_string(i), "times must rise");
  }
  return [rows = std::move(rows)](double time) -> Wrench {
    const auto next = std::ranges::upper_bound(rows, time, {}, &std::pair<double, Wrench>::first);
    if (next == rows.begin()) return rows.front().second;
    if (next == rows.end()) return rows.back().second;
    const auto& [t0, load0] = *(next - 1);
    const auto& [t1, load1] = *next;
    const double s = (time - t0) / (t1 - t0);
    const auto between = [s](const Vector3& a, const Vector3& b) {
      return exact::add(exact::scale(1 - s, a), exact::scale(s, b));
    };
    return {between(load0.force, load1.force), between(load0.torque, load1.torque)};
  };
}

World::World(Scene scene, const WorldOptions& options) : impl_(std::make_unique<Impl>()) {
  Impl& p = *impl_;
  p.options = options;
  std::vector<BodyDescription> bodies;
  std::swap(bodies, scene.bodies);
  p.scene = std::move(scene);
  if (!options.solver.empty()) {
    const std::optional<Solver> solver = find_solver(options.solver);
    if (!solver) {
      std::vector<std::string> names;
      for (const SolverInfo& each : solver_infos) names.emplace_back(each.name);
      throw Error(Failure::input, "solver",
                  "unknown solver " + quote(options.solver) + "; " + suggestion(options.solver, names));
    }
    if (*solver != p.scene.settings.solver) replace_solver(p.scene.settings, *solver);
  }
  if (!options.precision.empty()) p.scene.settings.precision = options.precision;
  if (p.scene.settings.forces == Forces::automatic) p.scene.settings.forces = Forces::step;
  expect_in_bounds(p.scene.settings);
  for (const BodyDescription& body : bodies) {
    validate(body, p.scene);
    p.add(body);
  }
  for (std::size_t j = 0; j < p.scene.joints.size(); ++j) p.joints.add();
  p.reset_index_map();
  validate_couplings(p.scene);
  validate_sensors(p.scene);
  if (!bodies.empty()) p.ready();
}

World World::load(const std::string& path_or_name, const WorldOptions& options) {
  return World(read_scene(path_or_name), options);
}

World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;
World::~World() = default;

BodyHandle World::add(const BodyDescription& body) {
  validate(body, impl_->scene);
  const BodyHandle handle = impl_->add(body);
  if (auto joint = planar_joint_of(body, impl_->bodies.index(handle))) impl_->add(std::move(*joint));
  return handle;
}

void World::remove(BodyHandle body) {
  Impl& p = *impl_;
  const u32 gone = p.bodies.index(body);
  for (u32 j = static_cast<u32>(p.scene.joints.size()); j-- > 0;) {
    JointDescription& joint = p.scene.joints[j];
    if (joint.body_a == gone || joint.body_b == gone) {
      p.remove_joint(j);
      continue;
    }
    for (u32* side : {&joint.body_a, &joint.body_b})
      if (*side != NONE && *side > gone) --*side;
  }
  p.remove_from_sensors(&SensorDescription::body, gone, p.called(body));
  p.bodies.remove(gone, p.scene.bodies[gone].name);
  p.scene.bodies.erase(p.scene.bodies.begin() + gone);
  rename_without(p.index_map.bodies, gone);
  std::erase_if(p.scene.passing, [gone](const auto& pair) { return pair[0] == gone || pair[1] == gone; });
  for (auto& pair : p.scene.passing)
    for (u32& side : pair) side -= side > gone;
  p.loads.erase(body.id);
  p.forces.erase(body.id);
  p.targets.erase(body.id);
  p.arrived.erase(body.id);
  p.change();
}

void World::teleport(BodyHandle body, const Pose& pose, const Twist& velocity) {
  Impl& p = *impl_;
  const u32 index = p.bodies.index(body);
  const std::string where = p.called(body);
  expect_unit(pose.orientation);
  for (const Vector3& vector : {pose.position, velocity.linear, velocity.angular})
    expect_fits(p.scene.settings, vector, where);
  const BodyDescription& described = p.scene.bodies[index];
  if (described.pivoted) throw Error(Failure::input, where, "is fixed to its pivot and has no other position");
  const bool moves = velocity.linear != Vector3{0, 0, 0} || velocity.angular != Vector3{0, 0, 0};
  if (described.kind == BODY_STATIC && moves) throw Error(Failure::input, where, "is static and does not move");
  p.targets.erase(body.id);
  p.arrived.erase(body.id);
  p.teleport(index, pose, velocity);
}

bool World::contains(BodyHandle body) const { return impl_->bodies.contains(body); }

std::optional<BodyHandle> World::find(const std::string& name) const {
  return find_named(impl_->scene.bodies, impl_->bodies, name);
}

std::span<const BodyHandle> World::bodies() const { return impl_->bodies.all(); }

const BodyDescription& World::description(BodyHandle body) const {
  return impl_->scene.bodies[impl_->bodies.index(body)];
}

JointHandle World::add(const JointDescription& joint, BodyHandle a, BodyHandle b) {
  JointDescription named = joint;
  named.body_a = impl_->bodies.index(a);
  named.body_b = impl_->bodies.index(b);
  return impl_->add(std::move(named));
}

JointHandle World::add(const JointDescription& joint, BodyHandle a) {
  JointDescription named = joint;
  named.body_a = impl_->bodies.index(a);
  named.body_b = NONE;
  return impl_->add(std::move(named));
}

void World::remove(JointHandle joint) { impl_->remove_joint(impl_->joints.index(joint)); }

bool World::contains(JointHandle joint) const { return impl_->joints.contains(joint); }

std::optional<JointHandle> World::find_joint(const std::string& name) const {
  const std::vector<JointDescription>& joints = impl_->scene.joints;
  if (const auto named = find_named(joints, impl_->joints, name)) return named;
  const auto& bodies = impl_->scene.bodies;
  const auto body = std::ranges::find(bodies, name, &BodyDescription::name);
  const u32 body_b = static_cast<u32>(body - bodies.begin());
  if (body == bodies.end() || std::ranges::count(joints, body_b, &JointDescription::body_b) != 1) return std::nullopt;
  return impl_
      ->joints[static_cast<std::size_t>(std::ranges::find(joints, body_b, &JointDescription::body_b) - joints.begin())];
}

std::span<const JointHandle> World::joints() const { return impl_->joints.all(); }

const JointDescription& World::description(JointHandle joint) const {
  return impl_->scene.joints[impl_->joints.index(joint)];
}

void World::step(u32 count) {
  for (u32 i = 0; i < count; ++i) {
    impl_->act();
    impl_->ended_in_step = std::exchange(impl_->ended, {});
    try {
      impl_->engine->step(impl_->namer());
    } catch (...) {
      impl_->forget_step();
      throw;
    }
    impl_->forget_state();
    impl_->kept = false;
  }
  if (count > 0) impl_->stepped = impl_->bodies.all();
}

bool World::is_ready() const { return impl_->engine && !impl_->changed; }
u32 World::steps_done() const { return impl_->engine ? impl_->engine->steps_done() : 0; }
Unsolved World::unsolved() const {
  Unsolved all = impl_->verdict.unsolved;
  if (impl_->engine) all.add(impl_->engine->unsolved());
  return all;
}
Verdict World::verdict() {
  Verdict all = impl_->verdict;
  if (impl_->engine) all.add(impl_->engine->verdict());
  return all;
}
std::vector<std::string> World::suspicions() {
  if (steps_done() > 0 || impl_->scene.bodies.empty()) return {};
  return suspicions_of(impl_->scene, impl_->ready().first_contacts(impl_->scene));
}
double World::time() const { return steps_done() * time_step(); }
double World::time_step() const { return impl_->scene.settings.dt; }
u32 World::substeps() const { return substeps_of(impl_->scene.settings); }
double World::substep_length() const { return time_step() / substeps(); }

void World::record(const std::string& path, RecordedData data) {
  if (path.empty()) throw Error(Failure::input, "recording", "must have a path");
  expect_writable(path, "the recording", recording_signature);
  end_recording();
  impl_->recording = path;
  impl_->recording_files = 0;
  impl_->recording_due = true;
  impl_->recorded = data;
}

void World::end_recording() {
  impl_->recording.clear();
  impl_->recording_due = false;
  if (impl_->engine) impl_->engine->end_recording();
}

void World::apply_impulse(BodyHandle body, const Vector3& impulse, const Vector3& point) {
  const u32 index = impl_->index_of_dynamic(body);
  for (const Vector3& vector : {impulse, point}) expect_fits(impl_->scene.settings, vector, impl_->called(body));
  Engine& engine = impl_->ready();
  const Pose& pose = impl_->current_poses()[index];
  const Twist& velocity = impl_->current_velocities()[index];
  impl_->set_velocity(index, engine.after_impulse(index, pose, velocity, impulse, point));
}

void World::apply_impulse(BodyHandle body, const Vector3& impulse) {
  apply_impulse(body, impulse, pose(body).position);
}

void World::apply_force(BodyHandle body, const Vector3& force, const Vector3& point) {
  for (const Vector3& vector : {force, point}) expect_fits(impl_->scene.settings, vector, impl_->called(body));
  const Vector3 arm = exact::subtract(point, pose(body).position);
  apply(body, {force, exact::cross(arm, force)});
}

void World::apply(BodyHandle body, const Wrench& wrench) {
  impl_->index_of_dynamic(body);
  for (const Vector3& vector : {wrench.force, wrench.torque})
    expect_fits(impl_->scene.settings, vector, impl_->called(body));
  impl_->ask_for_loads();
  Wrench& current = impl_->forces[body.id];
  current = sum(current, wrench);
}

void World::set_load(BodyHandle body, std::function<Wrench(double time)> load) {
  impl_->index_of_dynamic(body);
  if (!load) {
    impl_->loads.erase(body.id);
    return;
  }
  impl_->ask_for_loads();
  impl_->loads[body.id] = std::move(load);
}

const std::map<u32, std::function<Wrench(double)>>& World::loads() const { return impl_->loads; }

void World::clear_loads() { const auto gone = std::exchange(impl_->loads, {}); }

void World::set_velocity(BodyHandle body, const Twist& velocity) {
  const u32 index = impl_->index_of_kind(body, {BODY_DYNAMIC, BODY_KINEMATIC}, "is static and does not move");
  impl_->arrived.erase(body.id);
  impl_->set_velocity(index, velocity);
}

void World::wake(BodyHandle body) {
  const u32 index = impl_->index_of_dynamic(body);
  // whose velocity is set wakes, be it to what it was
  impl_->set_velocity(index, impl_->current_velocities()[index]);
}

void World::set_kinematic_target(BodyHandle body, const Pose& target) {
  impl_->index_of_kind(body, {BODY_KINEMATIC}, "is not kinematic; only such bodies go where they are told");
  expect_fits(impl_->scene.settings, target.position, impl_->called(body));
  expect_unit(target.orientation);
  impl_->targets[body.id] = target;
}

}  // namespace lockstep
