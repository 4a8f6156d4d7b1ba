// The inside of a World: a scene that says which bodies and joints there are, the engine that simulates it, made anew
// where some have come or gone, and what is to be done with the next step.
#pragma once

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "host/record/recording_writer.hpp"
#include "host/record/whole_file.hpp"
#include "host/scene/touching.hpp"
#include "host/world/engine.hpp"
#include "host/world/handles.hpp"
#include "host/world/validate.hpp"

namespace lockstep {

inline Wrench sum(const Wrench& a, const Wrench& b) {
  return {exact::add(a.force, b.force), exact::add(a.torque, b.torque)};
}

/// Bodies, joints and settings of a world at some time, shared by the snapshots between two changes of them.
struct Population {
  Scene scene;
  Handles<BodyHandle> bodies;
  Handles<JointHandle> joints;
};

// Worlds of this process, counted from 1.
inline u32 next_world_number() {
  static std::atomic<u32> worlds = 0;
  return ++worlds;
}

struct World::Impl {
  Scene scene;  // of the bodies as they are now; poses and velocities as they came
  WorldOptions options;
  const u32 world_number = next_world_number();
  Handles<BodyHandle> bodies{"body", world_number};    // of the scene's bodies
  Handles<JointHandle> joints{"joint", world_number};  // of its joints

  std::shared_ptr<Engine> engine;  // snapshots keep theirs
  IndexMap index_map;              // from the engine's bodies and joints to the scene's
  bool changed = true;
  Verdict verdict;                  // of the engines before this one
  std::vector<BodyHandle> stepped;  // whom the engine's last step was about
  std::vector<BodyHandle> made_of;  // whom the engine was made of
  // touches of bodies that have gone or been put elsewhere: since the last step, and before it
  std::vector<BodyEvent> ended, ended_in_step;

  std::map<u32, std::function<Wrench(double)>> loads;  // by id
  std::map<u32, Wrench> forces;                        // by id, for the next step
  std::map<u32, Pose> targets;                         // by id, of kinematic bodies, for the next step
  std::set<u32> arrived;                               // ids that stand still from the next step on
  std::map<std::string, std::string> sensors_gone;     // by name, with what each measured, as errors call that
  bool drives_set = false;                             // some joint may be driven otherwise than the engine knows
  bool gravity_set = false;                            // and what pulls may be otherwise

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
  RecordedData recorded = RecordedData::motion;

  // snapshots: where they belong, what the next one shares with the last one, and whether joints have ever been driven
  // otherwise
  std::shared_ptr<const int> self = std::make_shared<const int>();
  std::shared_ptr<const Population> population;  // null where something has changed since
  bool drives_were_set = false;

  // The engine is to be made anew before it is asked anything.
  void change() {
    changed = true;
    population.reset();
  }

  // Nothing has become anything else.
  void reset_index_map() {
    index_map = {};
    index_map.bodies.resize(scene.bodies.size());
    index_map.joints.resize(scene.joints.size());
    index_map.couplings.resize(scene.couplings.size());
    for (u32 i = 0; i < index_map.bodies.size(); ++i) index_map.bodies[i] = i;
    for (u32 j = 0; j < index_map.joints.size(); ++j) index_map.joints[j] = j;
    for (u32 k = 0; k < index_map.couplings.size(); ++k) index_map.couplings[k] = k;
  }

  // The engine, made anew where bodies or joints have come, gone or changed.
  Engine& ready() {
    if (changed) {
      if (scene.bodies.empty()) throw Error(Failure::input, "world", "has no bodies; add one");
      if (engine) engine->expect_not_failed();  // others would start from a state that was cut short
      keep_contacts_and_events();
      hand_over_velocities();
      forget_state();
      const std::shared_ptr<Engine> before = engine;
      try {
        engine = make_engine(scene, options, before.get(), index_map);
      } catch (const ItemError& error) {
        throw error.named(namer()(error.item(), error.id()));
      }
      if (before) {
        for (const EngineEvent& event : before->ends(index_map, *engine)) ended.push_back(named(event, made_of));
        verdict.add(before->verdict());
        before->end_recording();
      }
      made_of = bodies.all();
      reset_index_map();
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
    engine->record(path.string(), scene, recorded == RecordedData::motion_and_forces);
  }

  void forget_state() {
    poses.clear();
    velocities.clear();
  }

  // Of a step that failed there are neither contacts nor events.
  void forget_step() {
    forget_state();
    contacts.clear();
    events.clear();
    ended_in_step.clear();
    kept = true;
  }

  // Their indices are those of the bodies that the engine has, whatever has come or gone since.
  void hand_over_velocities() {
    if (engine) engine->set_velocities(new_velocities);
    new_velocities.clear();
  }

  const std::vector<Pose>& current_poses() {
    Engine& current = ready();
    if (poses.empty()) poses = current.poses();
    return poses;
  }

  const std::vector<Twist>& current_velocities() {
    Engine& current = ready();
    if (velocities.empty()) velocities = current.velocities();
    return velocities;
  }

  void set_velocity(u32 index, const Twist& velocity) {
    for (const Vector3& vector : {velocity.linear, velocity.angular})
      expect_fits(scene.settings, vector, called(bodies[index]));
    current_velocities();
    velocities[index] = new_velocities[index] = engine->rounded(velocity);
  }

  void keep_contacts_and_events() {
    if (std::exchange(kept, true)) return;
    contacts.clear();
    for (const ReportedContact& contact : engine->contacts())
      contacts.push_back({stepped[contact.a.body], stepped[contact.b.body], contact.a.shape, contact.b.shape,
                          contact.point, contact.normal, contact.impulse, triangle_of(contact.a),
                          triangle_of(contact.b), contact.gap});
    events = std::exchange(ended_in_step, {});
    for (const EngineEvent& event : engine->events()) events.push_back(named(event, stepped));
  }

  static BodyEvent named(const EngineEvent& event, const std::vector<BodyHandle>& handles) {
    return {event.kind,    handles[event.a.body], handles[event.b.body], event.a.shape,
            event.b.shape, triangle_of(event.a),  triangle_of(event.b),  event.impact};
  }

  static std::optional<u32> triangle_of(const DescribedShape& shape) {
    return shape.triangle == NONE ? std::nullopt : std::optional(shape.triangle);
  }

  u32 index_of_kind(BodyHandle body, std::initializer_list<BodyKind> kinds, const char* rule) const {
    const u32 i = bodies.index(body);
    if (std::ranges::find(kinds, scene.bodies[i].kind) == kinds.end()) throw Error(Failure::input, called(body), rule);
    return i;
  }
  u32 index_of_dynamic(BodyHandle body) const {
    return index_of_kind(body, {BODY_DYNAMIC}, "is not dynamic, nothing from outside moves it; give it a velocity");
  }

  // What errors call them.
  std::string called(BodyHandle body) const { return bodies.called(scene.bodies[bodies.index(body)].name, body); }
  std::string called(JointHandle joint) const { return joints.called(scene.joints[joints.index(joint)].name, joint); }
  ItemNamer namer() const {
    return [this](Item item, u32 index) { return item == Item::body ? called(bodies[index]) : called(joints[index]); };
  }

  BodyHandle add(const BodyDescription& body) {
    scene.bodies.push_back(body);
    change();
    return bodies.add();
  }

  // Where a body of the scene stands, without making the engine anew for those that it does not have yet.
  Pose current_pose(u32 index) {
    if (index == NONE) return {};
    if (!changed) return current_poses()[index];
    const auto had = std::ranges::find(index_map.bodies, index);
    if (had == index_map.bodies.end()) return {scene.bodies[index].position, scene.bodies[index].orientation};
    return engine->poses()[static_cast<std::size_t>(had - index_map.bodies.begin())];
  }

  JointHandle add(JointDescription joint) {
    validate(joint, scene);
    joint.reference_poses.reset();
    if (engine && engine->steps_done() > 0) {
      const Pose a = current_pose(joint.body_a), b = current_pose(joint.body_b);
      joint.reference_poses = {a.position, b.position, a.orientation, b.orientation};
    }
    scene.joints.push_back(std::move(joint));
    change();
    return joints.add();
  }

  void remove_joint(u32 gone) {
    remove_from_sensors(&SensorDescription::joint, gone, called(joints[gone]));
    remove_from_actuators(gone);
    remove_from_couplings(gone);
    joints.remove(gone, scene.joints[gone].name);
    scene.joints.erase(scene.joints.begin() + gone);
    rename_without(index_map.joints, gone);
    change();
  }

  void remove_from_actuators(u32 joint);
  // Couplings go with any of their joints.
  void remove_from_couplings(u32 joint) {
    for (u32 k = static_cast<u32>(scene.couplings.size()); k-- > 0;) {
      std::vector<CoupledCoordinate>& coupled = scene.couplings[k].joints;
      if (std::ranges::find(coupled, joint, &CoupledCoordinate::joint) != coupled.end()) {
        scene.couplings.erase(scene.couplings.begin() + k);
        rename_without(index_map.couplings, k);
        continue;
      }
      for (CoupledCoordinate& each : coupled)
        if (each.joint > joint) --each.joint;
    }
  }

  void remove_from_sensors(u32 SensorDescription::*measured, u32 gone, const std::string& name);
  SensorReading reading(const SensorDescription& sensor);

  // Its joints keep the frames that they have: where bodies stand at load tells those no longer.
  void teleport(u32 index, const Pose& pose, const Twist& velocity) {
    const auto pose_at_load = [&](u32 i) {
      return i == NONE ? Pose{} : Pose{scene.bodies[i].position, scene.bodies[i].orientation};
    };
    for (JointDescription& joint : scene.joints) {
      if (joint.reference_poses || (joint.body_a != index && joint.body_b != index)) continue;
      const Pose a = pose_at_load(joint.body_a), b = pose_at_load(joint.body_b);
      joint.reference_poses = {a.position, b.position, a.orientation, b.orientation};
    }
    BodyDescription& body = scene.bodies[index];
    body.position = pose.position;
    body.orientation = pose.orientation;
    body.velocity = velocity.linear;
    body.angular_velocity = velocity.angular;
    std::ranges::replace(index_map.bodies, index, NONE);
    change();
  }

  void change(u32 index, BodyDescription body);
  void change_joint(u32 index, JointDescription joint);
  void drive(u32 index, JointDescription driven);
  void set_materials(std::vector<Material> materials, std::vector<MaterialPairRule> pairs,
                     const std::array<u32, 2>& pair);

  std::vector<BodyHandle> bodies_in(const VolumeQuery& volume) {
    ask_for_shapes();
    std::vector<BodyHandle> found;
    for (const u32 index : ready().bodies_in(volume)) found.push_back(bodies[index]);
    return found;
  }

  u32 index_of(u32 id) const { return bodies.index({id}); }

  // Kernels for forces are only built where there are any.
  void ask_for_loads() {
    if (std::exchange(scene.settings.loads, true)) return;
    change();
  }

  // Where no two shapes can touch they are only kept for those who ask for them, and never where runge_kutta moves them
  // or their particles touch in their place.
  static bool can_keep_shapes(const Scene& scene) {
    return !scene.particles && scene.settings.integrator != Integrator::runge_kutta;
  }
  void ask_for_shapes() {
    if (!can_keep_shapes(scene) || scene.settings.keeps_shapes || shapes_can_touch(scene)) return;
    scene.settings.keeps_shapes = true;
    change();
  }

  void warm_up(const Expected& expected);
  void warm_up(const Scene& like, bool questions);
  std::shared_ptr<Snapshot::Data> save();
  void restore(const Snapshot::Data& saved);

  void act() {
    Engine& current = ready();
    begin_recording();
    for (const u32 id : arrived) set_velocity(index_of(id), {});
    arrived.clear();
    for (const auto& [id, pose] : targets) {
      set_velocity(index_of(id), current.velocity_between(current_poses()[index_of(id)], pose));
      arrived.insert(id);
    }
    targets.clear();
    hand_over_velocities();
    if (std::exchange(drives_set, false)) current.drive_joints(scene.joints);
    if (std::exchange(gravity_set, false)) current.set_gravity(scene.gravity);
    if (!scene.settings.loads) return;
    std::map<u32, Wrench> acting;
    const double middle = (current.steps_done() + 0.5) * scene.settings.dt;
    for (const auto& [id, load] : loads) {
      const Wrench wanted = acting[index_of(id)] = load(middle);
      for (const Vector3& vector : {wanted.force, wanted.torque})
        expect_fits(scene.settings, vector, called(bodies[index_of(id)]) + ": its load");
    }
    for (const auto& [id, force] : forces) acting[index_of(id)] = sum(acting[index_of(id)], force);
    forces.clear();
    current.set_loads(acting);
  }
};

}  // namespace lockstep
