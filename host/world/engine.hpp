// What a World runs on: a simulation of its bodies as they are now, in the precision of the run. Bodies are named by
// their place in the scene; numbers are in double.
#pragma once

#include <functional>
#include <map>
#include <memory>

#include "host/item_error.hpp"
#include "host/scene/event_groups.hpp"
#include "host/scene/reported_contact.hpp"
#include "host/scene/suspicions.hpp"
#include "host/simulation.hpp"
#include "host/world/migrate_state.hpp"
#include "include/lockstep/world.hpp"

namespace lockstep {

struct EngineEvent {
  EventKind kind;
  EventSide a, b;
  std::optional<Impact> impact;
};
struct EngineHit {
  DescribedShape of;
  double distance;
  Vector3 point, normal;
};

/// What errors call a body or joint, by its place in the scene.
using ItemNamer = std::function<std::string(Item item, u32 index)>;

/// What an engine was, for Engine::restore().
class SavedEngine {
 public:
  virtual ~SavedEngine() = default;
};

class Engine {
 public:
  virtual ~Engine() = default;

  virtual WorldDevice device() const = 0;

  /// Throws what Simulation::step() does, with the names of bodies and joints.
  virtual void step(const ItemNamer& name) = 0;
  virtual u32 steps_done() const = 0;
  virtual std::uint64_t state_hash() = 0;
  /// Of its own steps.
  virtual Unsolved unsolved() const = 0;
  /// The same, the state as it is among them.
  virtual Verdict verdict() = 0;
  /// Throws Error (comparison) where a step has failed.
  virtual void expect_not_failed() const = 0;
  /// Who touches whom where its steps start, of the scene that it was made of.
  virtual std::vector<FirstContact> first_contacts(const Scene& scene) const = 0;

  virtual std::vector<Pose> poses() = 0;
  virtual std::vector<Twist> velocities() = 0;
  /// Of each body, whether it sleeps.
  virtual std::vector<bool> asleep() = 0;
  virtual std::vector<ReportedContact> contacts() = 0;
  virtual std::vector<EngineEvent> events() = 0;
  /// Of the touches that end because `next`, which was made after it, knows them no more.
  virtual std::vector<EngineEvent> ends(const IndexMap& index_map, const Engine& next) = 0;
  virtual std::vector<std::optional<EngineHit>> cast_rays(std::span<const RayQuery> rays) = 0;
  /// In order, each once.
  virtual std::vector<u32> bodies_in(const VolumeQuery& volume) = 0;
  virtual JointState joint_state(u32 joint) = 0;
  virtual SensorReading joint_reading(const SensorDescription& sensor) = 0;
  virtual StepErrors errors() = 0;

  /// Overwrites those of some bodies.
  virtual void set_velocities(const std::map<u32, Twist>& velocities) = 0;
  /// As the precision of the run holds it.
  virtual Twist rounded(const Twist& velocity) const = 0;
  /// What acts from now on; on bodies that are not named, nothing. Only where the scene's settings ask for loads.
  virtual void set_loads(const std::map<u32, Wrench>& loads) = 0;
  /// What drives the joints from now on: the motors of the scene's joints, which are those of the engine.
  virtual void drive_joints(std::span<const JointDescription> joints) = 0;
  /// What pulls from now on, m/s^2.
  virtual void set_gravity(const Vector3& gravity) = 0;
  /// Records the steps from now on, with what is done to bodies, and on request with forces
  /// (docs/how_to/record_and_verify.md). Throws Error (device) where the file cannot be written.
  virtual void record(const std::string& path, const Scene& scene, bool forces) = 0;
  /// Closes the recording, if there is one.
  virtual void end_recording() = 0;

  /// All that its steps, contacts(), events() and verdict() depend on, where it is. Throws Error (comparison) where a
  /// step has failed.
  virtual std::unique_ptr<SavedEngine> save() = 0;
  /// Goes back, or forth, to what it was. Returns whether the recording goes on and has been told, as one that
  /// was under way then; another one is closed.
  virtual bool restore(SavedEngine& saved) = 0;

  /// Whether it has kernels that are built when they are first needed.
  virtual bool has_kernels() const = 0;

  /// The velocity that a dynamic body of this pose and velocity has after an impulse at a point: v + J / m and
  /// w + I^-1 (arm x J), about its centre of mass or its pivot.
  virtual Twist after_impulse(u32 body, const Pose& pose, const Twist& velocity, const Vector3& impulse,
                              const Vector3& point) const = 0;
  /// The velocity that moves a body evenly from one pose to another in a step.
  virtual Twist velocity_between(const Pose& current, const Pose& target) const = 0;
};

/// A new one; what `before` knows of the bodies that stay lives on (host/world/migrate_state.hpp). One that waits for
/// kernels never begins on the reference while a device builds its own.
std::unique_ptr<Engine> make_engine(const Scene& scene, const WorldOptions& options, Engine* before,
                                    const IndexMap& index_map, bool waits_for_kernels = false);

}  // namespace lockstep
