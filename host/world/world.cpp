#include "include/lockstep/world.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

#include "host/record/recording_writer.hpp"
#include "host/record/whole_file.hpp"
#include "host/scene/read.hpp"
#include "host/world/engine.hpp"
#include "host/world/handles.hpp"
#include "host/world/sense.hpp"

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

Wrench sum(const Wrench& a, const Wrench& b) { return {exact::add(a.force, b.force), exact::add(a.torque, b.torque)}; }

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

struct World::Parts {
  Scene scene;  // of the bodies as they are now; poses and velocities as they came
  WorldOptions options;
  Handles<BodyHandle> bodies{"body"};    // of the scene's bodies
  Handles<JointHandle> joints{"joint"};  // of its joints

  std::unique_ptr<Engine> engine;
  Renaming renaming;  // from the engine's bodies and joints to the scene's
  bool changed = true;
  std::vector<BodyHandle> stepped;  // whom the engine's last step was about

  std::map<u32, std::function<Wrench(double)>> loads;  // by id
  std::map<u32, Wrench> forces;                        // by id, for the next step
  std::map<u32, Pose> targets;                         // by id, of kinematic bodies, for the next step
  std::set<u32> arrived;                               // ids that stand still from the next step on
  bool motors_set = false;                             // some joint may be driven otherwise than the engine knows

  // what the engine holds now, read at most once between two steps, and velocities that it does not have yet
  std::vector<Pose> poses;
  std::vector<Twist> velocities;
  std::map<u32, Twist> new_velocities;  // by index
  std::vector<BodyContact> contacts;
  std::vector<BodyEvent> events;
  bool kept = true;  // the contacts and events of the last step are here; else the engine has them

  std::string recording;       // the path of its first file; empty: nothing is recorded
  u32 recording_files = 0;     // so far
  bool recording_due = false;  // with the next step another one begins

  // Nothing has become anything else.
  void reset_renaming() {
    renaming.bodies.resize(scene.bodies.size());
    renaming.joints.resize(scene.joints.size());
    for (u32 i = 0; i < renaming.bodies.size(); ++i) renaming.bodies[i] = i;
    for (u32 j = 0; j < renaming.joints.size(); ++j) renaming.joints[j] = j;
  }

  // The engine, made anew where bodies have come or gone.
  Engine& ready() {
    if (changed) {
      if (scene.bodies.empty()) throw Error(Failure::input, "world", "has no bodies; add one");
      keep_contacts_and_events();
      hand_over_velocities();
      forget_state();
      if (engine) engine->end_recording();
      engine = make_engine(scene, options, engine.get(), renaming);
      reset_renaming();
      changed = false;
      recording_due = !recording.empty();
    }
    return *engine;
  }

  // A file is of the same bodies throughout.
  void begin_recording() {
    if (!std::exchange(recording_due, false)) return;
    std::filesystem::path path = recording;
    if (++recording_files > 1) {
      const std::string number = "." + std::to_string(recording_files), kind = path.extension().string();
      path.replace_extension(number + kind);
      expect_writable(path.string(), "the recording", recording_signature);
    }
    engine->record(path.string(), scene);
  }

  void forget_state() {
    poses.clear();
    velocities.clear();
  }

  // Their indices are those of the bodies that the engine has, whatever has come or gone since.
  void hand_over_velocities() {
    if (engine) engine->set_velocities(new_velocities);
    new_velocities.clear();
  }

  const std::vector<Pose>& poses_now() {
    Engine& now = ready();
    if (poses.empty()) poses = now.poses();
    return poses;
  }

  const std::vector<Twist>& velocities_now() {
    Engine& now = ready();
    if (velocities.empty()) velocities = now.velocities();
    return velocities;
  }

  void set_velocity(u32 index, const Twist& velocity) {
    velocities_now();
    velocities[index] = new_velocities[index] = engine->rounded(velocity);
  }

  void keep_contacts_and_events() {
    if (std::exchange(kept, true)) return;
    contacts.clear();
    for (const EngineContact& contact : engine->contacts())
      contacts.push_back(
          {stepped[contact.body_a], stepped[contact.body_b], contact.point, contact.normal, contact.impulse});
    events.clear();
    for (const EngineEvent& event : engine->events())
      events.push_back({event.kind, stepped[event.body_a], stepped[event.body_b]});
  }

  u32 index_of_kind(BodyHandle body, std::initializer_list<BodyKind> kinds, const char* rule) const {
    const u32 i = bodies.index(body);
    if (std::ranges::find(kinds, scene.bodies[i].kind) == kinds.end())
      throw Error(Failure::input, "body " + std::to_string(body.id), rule);
    return i;
  }
  u32 index_of_dynamic(BodyHandle body) const {
    return index_of_kind(body, {BODY_DYNAMIC}, "is not dynamic, nothing from outside moves it; give it a velocity");
  }

  BodyHandle add(const BodyDescription& body) {
    scene.bodies.push_back(body);
    changed = true;
    return bodies.add();
  }

  // Where a body of the scene stands, without making the engine anew for those that it does not have yet.
  Pose standing(u32 index) {
    if (index == NONE) return {};
    if (!changed) return poses_now()[index];
    const auto had = std::ranges::find(renaming.bodies, index);
    if (had == renaming.bodies.end()) return {scene.bodies[index].position, scene.bodies[index].orientation};
    return engine->poses()[static_cast<std::size_t>(had - renaming.bodies.begin())];
  }

  JointHandle add(JointDescription joint) {
    expect_sense(joint, scene);
    joint.stand.reset();
    if (engine && engine->steps_done() > 0) {
      const Pose a = standing(joint.body_a), b = standing(joint.body_b);
      joint.stand = {a.position, b.position, a.orientation, b.orientation};
    }
    scene.joints.push_back(std::move(joint));
    changed = true;
    return joints.add();
  }

  void remove_joint(u32 gone) {
    scene.joints.erase(scene.joints.begin() + gone);
    joints.remove(gone);
    rename_without(renaming.joints, gone);
    changed = true;
  }

  u32 index_of(u32 id) const { return bodies.index({id}); }

  // Kernels for forces are only built where there are any.
  void ask_for_loads() {
    if (std::exchange(scene.settings.loads, true)) return;
    changed = true;
  }

  void act() {
    Engine& now = ready();
    begin_recording();
    for (const u32 id : arrived) set_velocity(index_of(id), {});
    arrived.clear();
    for (const auto& [id, pose] : targets) {
      set_velocity(index_of(id), now.velocity_between(poses_now()[index_of(id)], pose));
      arrived.insert(id);
    }
    targets.clear();
    hand_over_velocities();
    if (std::exchange(motors_set, false)) now.set_motors(scene.joints);
    if (!scene.settings.loads) return;
    std::map<u32, Wrench> acting;
    const double middle = (now.steps_done() + 0.5) * scene.settings.dt;
    for (const auto& [id, load] : loads) {
      acting[index_of(id)] = load(middle);
      expect_finite(acting[index_of(id)]);
    }
    for (const auto& [id, force] : forces) acting[index_of(id)] = sum(acting[index_of(id)], force);
    forces.clear();
    now.set_loads(acting);
  }
};

World::World(Scene scene, const WorldOptions& options) : parts_(std::make_unique<Parts>()) {
  Parts& p = *parts_;
  p.options = options;
  std::vector<BodyDescription> bodies;
  std::swap(bodies, scene.bodies);
  p.scene = std::move(scene);
  if (!options.precision.empty()) p.scene.settings.precision = options.precision;
  if (p.scene.settings.precision != "float" && p.scene.settings.precision != "double")
    throw Error(Failure::input, "precision", "must be float or double, is " + p.scene.settings.precision);
  for (const BodyDescription& body : bodies) add(body);
  for (std::size_t j = 0; j < p.scene.joints.size(); ++j) p.joints.add();
  p.reset_renaming();
  if (!bodies.empty()) p.ready();
}

World World::load(const std::string& path_or_name, const WorldOptions& options) {
  return World(read_scene(path_or_name), options);
}

World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;
World::~World() = default;

BodyHandle World::add(const BodyDescription& body) {
  expect_sense(body, parts_->scene);
  return parts_->add(body);
}

void World::remove(BodyHandle body) {
  Parts& p = *parts_;
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
  p.scene.bodies.erase(p.scene.bodies.begin() + gone);
  p.bodies.remove(gone);
  rename_without(p.renaming.bodies, gone);
  p.loads.erase(body.id);
  p.forces.erase(body.id);
  p.targets.erase(body.id);
  p.arrived.erase(body.id);
  p.changed = true;
}

bool World::contains(BodyHandle body) const { return parts_->bodies.contains(body); }

std::optional<BodyHandle> World::find(const std::string& name) const {
  return find_named(parts_->scene.bodies, parts_->bodies, name);
}

std::span<const BodyHandle> World::bodies() const { return parts_->bodies.all(); }

const BodyDescription& World::description(BodyHandle body) const {
  return parts_->scene.bodies[parts_->bodies.index(body)];
}

JointHandle World::add(const JointDescription& joint, BodyHandle a, BodyHandle b) {
  JointDescription named = joint;
  named.body_a = parts_->bodies.index(a);
  named.body_b = parts_->bodies.index(b);
  return parts_->add(std::move(named));
}

JointHandle World::add(const JointDescription& joint, BodyHandle a) {
  JointDescription named = joint;
  named.body_a = parts_->bodies.index(a);
  named.body_b = NONE;
  return parts_->add(std::move(named));
}

void World::remove(JointHandle joint) { parts_->remove_joint(parts_->joints.index(joint)); }

void World::set_motor(JointHandle joint, double speed, double force) {
  Parts& p = *parts_;
  const u32 index = p.joints.index(joint);
  JointDescription driven = p.scene.joints[index];
  driven.motor_speed = speed;
  driven.motor_force = force;
  expect_sense(driven, p.scene);
  constexpr double most = std::numeric_limits<float>::max();
  if (p.scene.settings.precision == "float" && (std::abs(speed) > most || force > most))
    throw Error(Failure::input, "joint " + std::to_string(joint.id), "has a motor that float numbers cannot hold");
  p.scene.joints[index] = std::move(driven);
  p.motors_set = true;
}

bool World::contains(JointHandle joint) const { return parts_->joints.contains(joint); }

std::optional<JointHandle> World::find_joint(const std::string& name) const {
  return find_named(parts_->scene.joints, parts_->joints, name);
}

std::span<const JointHandle> World::joints() const { return parts_->joints.all(); }

const JointDescription& World::description(JointHandle joint) const {
  return parts_->scene.joints[parts_->joints.index(joint)];
}

void World::step(u32 count) {
  for (u32 i = 0; i < count; ++i) {
    parts_->act();
    parts_->engine->step();
    parts_->forget_state();
    parts_->kept = false;
  }
  if (count > 0) parts_->stepped = parts_->bodies.all();
}

u32 World::steps_done() const { return parts_->engine ? parts_->engine->steps_done() : 0; }
double World::time() const { return steps_done() * parts_->scene.settings.dt; }

std::span<const Pose> World::poses() { return parts_->poses_now(); }
std::span<const Twist> World::velocities() { return parts_->velocities_now(); }

Pose World::pose(BodyHandle body) {
  const u32 index = parts_->bodies.index(body);
  return poses()[index];
}

Twist World::velocity(BodyHandle body) {
  const u32 index = parts_->bodies.index(body);
  return velocities()[index];
}

std::span<const BodyContact> World::contacts() {
  parts_->keep_contacts_and_events();
  return parts_->contacts;
}

std::span<const BodyEvent> World::events() {
  parts_->keep_contacts_and_events();
  return parts_->events;
}

std::optional<BodyHit> World::cast_ray(const Vector3& origin, const Vector3& direction, double length, u32 mask) {
  RayQuery ray;
  ray.origin = origin;
  ray.direction = direction;
  ray.length = length;
  ray.mask = mask;
  const std::optional<EngineHit> hit = parts_->ready().cast_ray(ray);
  if (!hit) return std::nullopt;
  return BodyHit{parts_->bodies[hit->body], hit->distance, hit->point, hit->normal};
}

WorldDevice World::device() { return parts_->ready().device(); }

std::uint64_t World::state_hash() {
  Engine& engine = parts_->ready();
  parts_->hand_over_velocities();
  return engine.state_hash();
}

void World::record(const std::string& path) {
  if (path.empty()) throw Error(Failure::input, "recording", "must have a path");
  expect_writable(path, "the recording", recording_signature);
  end_recording();
  parts_->recording = path;
  parts_->recording_files = 0;
  parts_->recording_due = true;
}

void World::end_recording() {
  parts_->recording.clear();
  parts_->recording_due = false;
  if (parts_->engine) parts_->engine->end_recording();
}

void World::apply_impulse(BodyHandle body, const Vector3& impulse, const Vector3& point) {
  const u32 index = parts_->index_of_dynamic(body);
  expect_finite(impulse, "impulse");
  expect_finite(point, "point");
  Engine& engine = parts_->ready();
  const Pose& pose = parts_->poses_now()[index];
  const Twist& velocity = parts_->velocities_now()[index];
  parts_->set_velocity(index, engine.after_impulse(index, pose, velocity, impulse, point));
}

void World::apply_impulse(BodyHandle body, const Vector3& impulse) {
  apply_impulse(body, impulse, pose(body).position);
}

void World::apply_force(BodyHandle body, const Vector3& force, const Vector3& point) {
  expect_finite(point, "point");
  const Vector3 arm = exact::subtract(point, pose(body).position);
  apply(body, {force, exact::cross(arm, force)});
}

void World::apply(BodyHandle body, const Wrench& wrench) {
  parts_->index_of_dynamic(body);
  expect_finite(wrench);
  parts_->ask_for_loads();
  Wrench& now = parts_->forces[body.id];
  now = sum(now, wrench);
}

void World::set_load(BodyHandle body, std::function<Wrench(double time)> load) {
  parts_->index_of_dynamic(body);
  if (!load) {
    parts_->loads.erase(body.id);
    return;
  }
  parts_->ask_for_loads();
  parts_->loads[body.id] = std::move(load);
}

void World::set_velocity(BodyHandle body, const Twist& velocity) {
  const u32 index = parts_->index_of_kind(body, {BODY_DYNAMIC, BODY_KINEMATIC}, "is static and does not move");
  expect_finite(velocity);
  parts_->arrived.erase(body.id);
  parts_->set_velocity(index, velocity);
}

void World::set_kinematic_target(BodyHandle body, const Pose& target) {
  parts_->index_of_kind(body, {BODY_KINEMATIC}, "is not kinematic; only such bodies go where they are told");
  expect_finite(target.position, "target");
  expect_unit(target.orientation);
  parts_->targets[body.id] = target;
}

}  // namespace lockstep
