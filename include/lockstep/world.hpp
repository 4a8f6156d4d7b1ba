// Lockstep as a library: a world of rigid bodies that a program builds, steps, looks at and acts upon
// (docs/tutorials/library.md). SI units, z up, quaternions x y z w. Everything is deterministic: the same calls in the
// same order give the same bits on every device, and by an oracle (docs/theory/oracles.md) in one build on one machine.
// Whatever goes wrong is an Error with one line that says where and what would cure it.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "error.hpp"
#include "readings.hpp"
#include "scene.hpp"
#include "settings.hpp"
#include "types.hpp"
#include "verdict.hpp"

namespace lockstep {

/// A body of a World. A handle stays good until its body is removed and is never given to another one.
struct BodyHandle {
  u32 id = NONE;
  u32 world = 0;  // which World of this process gave it; 0, where it is made of a number: the one that is asked
  bool operator==(const BodyHandle& other) const {
    return id == other.id && (world == other.world || world == 0 || other.world == 0);
  }
};

/// A joint of a World, as a BodyHandle is a body.
struct JointHandle {
  u32 id = NONE;
  u32 world = 0;
  bool operator==(const JointHandle& other) const {
    return id == other.id && (world == other.world || world == 0 || other.world == 0);
  }
};

struct Pose {
  Vector3 position = {0, 0, 0};  // of the centre of mass, m
  Quaternion orientation = {0, 0, 0, 1};
};

/// Velocity of the centre of mass, m/s, and angular velocity, rad/s; world frame.
struct Twist {
  Vector3 linear = {0, 0, 0}, angular = {0, 0, 0};
};

/// What acts on a body: a force through its centre of mass, N, and a torque, N m; world frame.
struct Wrench {
  Vector3 force = {0, 0, 0}, torque = {0, 0, 0};
};

/// A point at which two bodies touched, or could have, in the last step. Its impulse is the sum of its sub-steps, of
/// bodies that sleep that many times what they last carried in one; with the setting `forces` "substep" it is that of
/// the last sub-step (docs/reference/forces.md).
struct BodyContact {
  BodyHandle a, b;
  u32 shape_a, shape_b;                                 // by their indices in the bodies' descriptions
  Vector3 point;                                        // on the surface of a at the end of the step, world frame, m
  Vector3 normal;                                       // from b to a, unit
  Vector3 impulse;                                      // on a, N s
  std::optional<u32> triangle_a = {}, triangle_b = {};  // of shapes that are surfaces
  double gap = 0;                                       // at the end of the step, m; negative where they overlap
};

/// Two bodies began or ceased to touch in the last step, came together fast, or entered or left a trigger (then a has
/// the trigger). What is removed or teleported ceases to touch what it touched, in the next step; the handle of a body
/// that was removed names nobody any more.
struct BodyEvent {
  EventKind kind;
  BodyHandle a, b;
  u32 shape_a, shape_b;  // by their indices in the bodies' descriptions; of several the first
  std::optional<u32> triangle_a = {}, triangle_b = {};  // of surfaces, with the setting `event_pairs` "triangles"
  std::optional<Impact> impact = {};                    // of EVENT_IMPACT, for which the setting `impact_speed` asks
};

inline constexpr EventKind EVENT_SENSOR_ENTER [[deprecated("is called EVENT_TRIGGER_ENTER")]] = EVENT_TRIGGER_ENTER;
inline constexpr EventKind EVENT_SENSOR_LEAVE [[deprecated("is called EVENT_TRIGGER_LEAVE")]] = EVENT_TRIGGER_LEAVE;

/// A question: what does a ray meet first?
struct BodyRay {
  Vector3 origin = {0, 0, 0}, direction = {1, 0, 0};  // the direction need not be unit
  double length = 1e6;                                // how far to look, m
  u32 mask = 0xffffffffu;                             // of categories of shapes: World::category_mask()
};

/// The nearest surface on a ray.
struct BodyHit {
  BodyHandle body;
  u32 shape = 0;        // by its index in the body's description
  double distance = 0;  // from the origin, m
  Vector3 point, normal;
  std::optional<u32> triangle = {};  // of a shape that is a surface
};

/// How a joint stands, and what it does. World frame; forces are the mean of the last step, 0 before the first. Those
/// of the last sub-step are told with the setting `forces` "substep", of joints that sleep, and where bodies or joints
/// have come, gone or changed since the step (docs/reference/forces.md).
struct JointState {
  // angle of a hinge, planar, universal (first arm) or screw joint, with its revolutions, rad; travel of a slider or
  // cylindrical joint or length of a distance joint, m; of others 0
  double coordinate = 0;
  double speed = 0;  // its rate, rad/s, m/s
  double drive = 0;  // by motor, friction, limits, spring and armature, along the coordinate; N m, N
  // of the joint, but for `drive`, on its second body at that one's anchor; on the first it is the opposite; N, N m
  Vector3 force = {0, 0, 0}, torque = {0, 0, 0};
  double separation = 0, angle = 0;  // by how much it is open where it should not be, m, rad
};

/// How good the last step was, in double and outside of it; docs/reference/error_measures.md has the formulas.
struct StepErrors {
  double kinetic = 0, potential = 0;                    // J, of the dynamic bodies; -m g . x, and of joints' springs
  Vector3 momentum = {0, 0, 0};                         // kg m/s
  Vector3 angular_momentum = {0, 0, 0};                 // about the centre of mass of all, kg m^2/s
  u32 contacts = 0;                                     // points, of which some only could have touched
  double max_penetration = 0, mean_penetration = 0;     // m
  std::optional<double> residual, defect_velocity;      // of the contact problem; m/s; none without one
  std::optional<double> joint_separation, joint_angle;  // how far joints are open at most, m, rad; none without joints
};

struct WorldOptions {
  std::string device = "auto";  // as `--device`
  std::string precision = {};   // "float" or "double"; empty: what the scene says
  u32 threads = 0;              // of a CPU device; 0: all
  std::string solver = {};      // as `--solver`, with the settings that it brings; empty: what the scene says
  bool quiet = false;  // no line on stderr, where that is a terminal, when building kernels takes more than a second
};

/// What a world is going to be asked, for World::warm_up().
struct Expected {
  bool forces = true;                        // apply_force(), apply(), set_load()
  bool questions = true;                     // cast_ray(), overlapping_sphere() and their like
  std::vector<BodyDescription> bodies = {};  // such as are going to be added
};

/// What a world computes on.
struct WorldDevice {
  std::string name;  // as `lockstep devices` has it, or "reference"
  bool bit_exact =
      true;  // its bits are those of every other device, by what the canary found (docs/theory/bit_exactness.md)
  std::string canary = "bit-exact";  // the same in words, with the first thing that differs
};

/// A load that follows a table: rows of (time, s; load) with rising times, straight lines between them, the first and
/// the last value before and after. For World::set_load. Throws Error where it is empty or times do not rise.
std::function<Wrench(double)> load_table(std::vector<std::pair<double, Wrench>> rows);

/// A World as it was at some time, in memory, on the device where it is (World::save()). A copy is the same snapshot.
/// It may be kept as long as one likes, and its world may go before it.
class Snapshot {
 public:
  /// Of nothing yet.
  Snapshot() = default;
  explicit operator bool() const { return data_ != nullptr; }
  /// Of the world, when it was made; 0 of nothing.
  u32 steps_done() const;
  double time() const;  // s
  /// What World::set_load() had set, by the ids of bodies.
  const std::map<u32, std::function<Wrench(double time)>>& loads() const;

 private:
  friend class World;
  struct Data;
  std::shared_ptr<Data> data_;
};

/// What a recording has of each step: poses and velocities, and on request the force of each contact and of each joint,
/// N and N m, world frame, which makes the file larger by 96 B a contact and 56 B a joint before it is packed.
enum class RecordedData { motion, motion_and_forces };

class World {
 public:
  /// A scene made in code or by read_scene(). Throws Error (input) for one that makes no sense, Error (device) where
  /// the device cannot be used.
  explicit World(Scene scene, const WorldOptions& options = {});
  /// A scene file, or a built-in scene by its name.
  static World load(const std::string& path_or_name, const WorldOptions& options = {});
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;
  ~World();

  /// Runs the canary when first asked, a small kernel, once in a process. Throws Error (device) where it cannot run.
  WorldDevice device();

  // ---- bodies

  /// Adds a body; takes effect with the next step or question. What others do to each other is not disturbed. Adding
  /// and removing cost time in proportion to the whole scene, once for all changes between two steps. Throws Error
  /// (input) for one that makes no sense. make_solid() gives a body the mass of its shapes.
  BodyHandle add(const BodyDescription& body);
  /// Removes a body and the joints that hold it. Events of the next step tell what it ceases to touch.
  void remove(BodyHandle body);
  /// Sets the pose of a body, of any kind but on a pivot: as though it were removed and added again, with this
  /// velocity, but that its handle, its joints and its load stay. Costs as adding does. Joints that then stand open
  /// are pulled together: teleport all that hang together.
  void teleport(BodyHandle body, const Pose& pose, const Twist& velocity = {});
  [[deprecated("is called teleport()")]] void place(BodyHandle body, const Pose& pose, const Twist& velocity = {}) {
    teleport(body, pose, velocity);
  }
  /// Describes a body anew: its kind, mass and moments, shapes with their materials and filters, its name. Where it
  /// stands and how it moves stays as it is, whatever the description says; but what is static stands still. Shapes
  /// are known by their index: what touches one of the same kind goes on to, with the impulse that it had. Joints
  /// and, of a dynamic body, the load stay. Takes effect, and costs, as adding a body does. Wakes its island and those
  /// that touch it, and all of them where it is static or kinematic. Throws Error (input) for a body that makes no
  /// sense, for one that is to come onto a pivot or off it, for one that joints hold to nothing
  /// dynamic, and for a name that another body has.
  void change(BodyHandle body, const BodyDescription& description);
  bool contains(BodyHandle body) const;
  /// By its name in the scene; nothing where there is none.
  std::optional<BodyHandle> find(const std::string& name) const;
  /// All of them, oldest first: the order of poses() and velocities().
  std::span<const BodyHandle> bodies() const;
  const BodyDescription& description(BodyHandle body) const;

  // ---- joints

  /// Holds two bodies together as they stand now, or one to the world: anchors and axis of the description are in the
  /// world frame of this moment, a rod is as long as it is now, the angle of a hinge and the travel of a slider count
  /// from here; which bodies it names does not matter. Takes effect, and costs, as adding a body does. Throws Error
  /// (input) for a joint that makes no sense.
  JointHandle add(const JointDescription& joint, BodyHandle a, BodyHandle b);
  JointHandle add(const JointDescription& joint, BodyHandle a);
  /// Drives the free angle, travel or distance of a joint (docs/reference/scene_format.md) from now on: `speed` of b
  /// against a, rad/s or m/s, by a torque or force of at most `force`, N m or N; 0: not at all. Takes effect with the
  /// next step. Throws Error (input) for a joint that has nothing to drive or has friction, and for a motor that makes
  /// no sense.
  void set_motor(JointHandle joint, double speed, double force);
  /// Moves where the spring of a joint rests, m or rad from where its coordinate is 0: the target of a servo. Takes
  /// effect with the next step, and wakes what the joint holds. Throws Error (input) for a joint without a spring.
  void set_rest(JointHandle joint, double rest);
  /// The actuators of the scene's robots, in the order of their files, with what each wants.
  std::span<const ActuatorDescription> actuators() const;
  /// The number of the one of this name, ROBOT/ACTUATOR; throws Error (input) where there is none.
  u32 actuator(const std::string& name) const;
  /// What an actuator wants from now on, in its units; its range bounds it. Takes effect with the next step, costs
  /// little, and wakes what its joint holds. Throws Error (input) for one that is not simulated, saying why.
  void set_control(u32 actuator, double control);
  /// Describes a joint anew: limits, spring, armature, motor or friction, how soft it is, whether its bodies collide,
  /// its name. Its bodies, anchors and axes stay, whatever the description says, and coordinates count from where they
  /// did. Takes effect, and costs, as adding one does, and wakes what it holds. Throws Error (input) for a joint that
  /// makes no sense, and for another kind, pitch or radius.
  void change(JointHandle joint, const JointDescription& description);
  void remove(JointHandle joint);
  bool contains(JointHandle joint) const;
  /// By its name, else by that of its body b, where no other joint has that one as b; nothing where there is none.
  std::optional<JointHandle> find_joint(const std::string& name) const;
  /// All of them, oldest first.
  std::span<const JointHandle> joints() const;
  const JointDescription& description(JointHandle joint) const;
  JointState state(JointHandle joint);

  // ---- what else can change; with the next step

  Vector3 gravity() const;  // m/s^2
  /// Costs little, and wakes all. Throws Error (input) where it is not finite.
  void set_gravity(const Vector3& gravity);
  /// The materials of the scene by index; none is one that has no name.
  std::span<const Material> materials() const;
  /// The index of a material by its name. Throws Error (input) where there is none.
  u32 material(const std::string& name) const;
  /// Friction, restitution and what else it has of the material of that index; it keeps its name. Costs as adding a
  /// body does, and wakes those that rest on it. Throws Error (input) for values that make no sense.
  void set_material(u32 material, const Material& values);
  /// The same of a rule for a pair of materials, the one that there is or a new one.
  void set_material_pair(const MaterialPairRule& rule);
  double speed_limit() const;  // m/s
  /// Bodies that are faster end the run (docs/reference/scene_format.md). Costs as adding a body does. Throws Error
  /// (input) where it is not above 0.
  void set_speed_limit(double speed);

  // ---- time

  /// Builds the kernels that the next step, and what is expected, are going to need, which takes seconds where they
  /// were never built before: afterwards the first force or the first cylinder takes no longer than another. Changes
  /// nothing of the world. Throws Error (input) for bodies that make no sense, and in a world without bodies that
  /// expects none.
  void warm_up(const Expected& expected = {});
  /// So many time steps of the scene's `dt`. Throws Error naming body, stage and step where a velocity goes bad.
  void step(u32 count = 1);
  /// Whether the next step begins at once: nothing has come, gone or changed since what computes it was made.
  bool is_ready() const;
  u32 steps_done() const;
  double time() const;            // s: steps_done() times the step, without what adding steps up would round
  double time_step() const;       // the scene's `dt`, s
  u32 substeps() const;           // of each step
  double substep_length() const;  // s: the step over its sub-steps

  // ---- what is; spans hold until the next call that is not const

  std::span<const Pose> poses();
  std::span<const Twist> velocities();
  Pose pose(BodyHandle body);
  Twist velocity(BodyHandle body);
  /// Whether a dynamic body sleeps (docs/how_to/let_bodies_sleep.md); never where the scene's settings do not ask for
  /// sleeping. What is done to a body, and what is done to those that touch it, wakes it with the next step.
  bool is_asleep(BodyHandle body);
  /// Of the last step, ordered by the bodies' shapes; of bodies that sleep those that they fell asleep with.
  std::span<const BodyContact> contacts();
  /// What contacts() push a body with, N, world frame: the sum of their impulses on it, over the step, or over the
  /// sub-step with the setting `forces` "substep"; of one of its shapes, by its index in the body's description. Throws
  /// Error (input) for a shape that it does not have.
  Vector3 contact_force(BodyHandle body, std::optional<u32> shape = {});
  /// contacts(), in their order, with the impulses of least norm that do the same: where several points carry a body,
  /// mechanics does not say how they share the load, and what contacts() tells depends on the solver. Of all r_i in the
  /// cones of friction with sum_i G_i r_i = sum_i G_i r_i(reported), G_i being force and moment on each dynamic body,
  /// that with the least sum_i |r_i|^2, to 1e-9: unique, and as symmetric as the contacts are. The formula, and what
  /// counts as a contact that can carry: docs/reference/forces.md. Computed on the host in double; changes nothing.
  std::vector<BodyContact> least_norm_contacts();
  /// What the sensors of the scene read of the last step, in their order. Those of bodies and joints that were removed
  /// are gone with them.
  std::vector<SensorReading> sensors();
  /// One of them by its name. Throws Error (input) where there is none, or its body or joint was removed.
  SensorReading sensor(const std::string& name);
  /// Of the last step; asked for by the scene's settings `events` and `impact_speed` or by a trigger
  /// (docs/reference/events.md).
  std::span<const BodyEvent> events();
  /// The bits of categories of shapes, by their names in the scene, for the masks of questions. They are those of
  /// Scene::categories, from the lowest on. Throws Error (input) for a name that is not among them.
  u32 category_mask(const std::vector<std::string>& names) const;
  /// What a ray from `origin` meets first, of the shapes in the categories of `mask`; nothing within `length` is
  /// nothing. Refused, an Error (input), where bodies push each other by particles, or runge_kutta moves them.
  std::optional<BodyHit> cast_ray(const Vector3& origin, const Vector3& direction, double length = 1e6,
                                  u32 mask = 0xffffffffu);
  /// The same for many rays, in their order: one launch, where as many calls would be one each.
  std::vector<std::optional<BodyHit>> cast_rays(std::span<const BodyRay> rays);
  /// Bodies with a shape, of the categories of `mask`, that overlaps a sphere, or a box; oldest first. Triggers are not
  /// met. Refused where cast_ray() is.
  std::vector<BodyHandle> overlapping_sphere(const Vector3& center, double radius, u32 mask = 0xffffffffu);
  std::vector<BodyHandle> overlapping_box(const Pose& pose, const Vector3& half_extents, u32 mask = 0xffffffffu);
  /// Of the state as it is and the contacts of the last step; of none where bodies have come or gone since.
  StepErrors errors();
  /// What has been left unsolved so far, by an oracle (docs/theory/oracles.md) or by sweeps that a tolerance did not
  /// end: step() does not throw for that. A solver that is to make so many sweeps leaves nothing unsolved. A step that
  /// failed counts once, as bad.
  Unsolved unsolved() const;
  /// Of all steps so far and the state as it is, by the bounds of the scene's settings
  /// (docs/reference/error_measures.md). Energy that bodies have by what is done to them between steps is no gain; once
  /// loads act, kinematic bodies are moved or motors of unbounded force run it is not judged.
  Verdict verdict();
  /// What looks like a mistake in the world as it starts, a line each with its cure
  /// (docs/how_to/when_it_looks_wrong.md): sizes in millimetres, bodies inside each other, a quaternion with w first.
  /// Nothing once it has been stepped.
  std::vector<std::string> suspicions();
  /// Of everything that lives on between steps; equal where every bit is.
  std::uint64_t state_hash();

  // ---- what is kept

  /// The world as it is: all that a checkpoint has, bodies and joints, what acts on them and what is to be done with
  /// the next step. Memory of the size of the state, and while one of them is kept, of what computes the bodies of its
  /// time; copied where the state is, without waiting for it. Throws Error (comparison) where a step has failed.
  Snapshot save();
  /// Goes back, or forth, to it: bodies and joints that have come or gone are as they were, handles of then good again,
  /// and the same calls give the same bits. Handles of what has come since are good for nobody, and never given again.
  /// contacts(), events() and verdict() are those of then; errors() are of no contacts until the next step. Files are
  /// left alone: a recording goes on, and notes it (docs/how_to/record_and_verify.md). Also after a step has failed.
  /// Throws Error (input) for a snapshot of another world or of nothing.
  void restore(const Snapshot& snapshot);

  /// Records every step from now on, with what is done to bodies, motors and gravity, into a file of HDF5 that
  /// `lockstep verify` replays on any device and `lockstep render` draws (docs/how_to/record_and_verify.md). A file is
  /// of the same bodies and joints throughout: after some have come, gone or changed, and from the first force on,
  /// run.h5 goes on in run.2.h5, ... Replaces recordings of these names, and ends the one that goes on. Throws Error
  /// (input) where a file of another kind is in the way; where the disk does not take it, step() throws Error (device).
  void record(const std::string& path, RecordedData data = RecordedData::motion);
  /// Closes the recording, as the end of the world does. Throws Error (device) where that fails.
  void end_recording();

  // ---- what acts; on dynamic bodies, but for set_velocity and set_kinematic_target

  /// At once. `point` is where it acts, world frame.
  void apply_impulse(BodyHandle body, const Vector3& impulse, const Vector3& point);
  void apply_impulse(BodyHandle body, const Vector3& impulse);
  /// During the next step, spread over its sub-steps; several add up.
  void apply_force(BodyHandle body, const Vector3& force, const Vector3& point);
  void apply(BodyHandle body, const Wrench& wrench);
  /// Until it is replaced or taken away (an empty function): a function of time, taken in the middle of each step.
  void set_load(BodyHandle body, std::function<Wrench(double time)> load);
  /// All that set_load() has set, by the ids of bodies.
  const std::map<u32, std::function<Wrench(double time)>>& loads() const;
  /// Takes all of it away.
  void clear_loads();
  /// Of a dynamic or kinematic body.
  void set_velocity(BodyHandle body, const Twist& velocity);
  /// Wakes the island that a dynamic body sleeps in, with the next step.
  void wake(BodyHandle body);
  /// A kinematic body moves evenly so that it is there at the end of the next step, to rounding, and then stands still.
  void set_kinematic_target(BodyHandle body, const Pose& target);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lockstep
