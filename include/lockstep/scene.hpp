// A scene as a file describes it (docs/reference/scene_format.md), in double and SI units; z up.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "settings.hpp"
#include "types.hpp"

namespace lockstep {

/// What bodies of particles push with: springs and dampers (Harada 2008), or the contacts of the solvers.
enum class ParticleModel { penalty, constraints };

/// Where the particles of a body are: on its surface, or all through it.
enum class Sampling { surface, solid };

/// Bodies as particles (docs/theory/particles.md). All lie within the shapes that they stand for, and touch their
/// surfaces.
struct ParticleSettings {
  double radius = 0;  // m
  ParticleModel model = ParticleModel::penalty;
  Sampling sampling = Sampling::surface;
  // of the penalty model
  double stiffness = 0;      // N/m, of two particles that overlap
  double restitution = 0.5;  // of two particles that are bodies of their own
  double friction = 0.5;
  double shear_stiffness = 0;  // N/m, of what remembers how far two were sheared; 0: nothing does
};

/// What a material, or a rule for a pair of them, may say of friction beside mu.
struct FurtherFriction {
  std::optional<double> static_friction = {};  // mu at rest, >= that of what slides
  std::optional<double> stick_speed = {};      // m/s: what slides slower than this has static friction
  std::optional<double> torsional_friction =
      {};  // m: rotation about the normal is resisted by this times the normal force
  std::optional<double> rolling_friction = {};  // m: the same of rolling
  std::optional<double> friction_across = {};   // mu across the x axis of shapes; mu is that along it
};

struct Material {
  std::string name = {};
  double friction = 0.5, restitution = 0;
  std::optional<ImpactLaw> impact_law = {};           // none: that of the other material, or Newton's
  std::optional<double> tangential_restitution = {};  // -1 .. 1, of Chatterjee and Ruina's law
  FurtherFriction further = {};
};

/// Overrides what the two materials combine to (friction: geometric mean; restitution: the larger; the law of impact
/// that either names).
struct MaterialPairRule {
  u32 material_a, material_b;
  double friction, restitution;
  std::optional<ImpactLaw> impact_law = {};
  std::optional<double> tangential_restitution = {};
  FurtherFriction further = {};
};

/// Triangles are counter-clockwise seen from outside; m, in the frame of the shape.
struct TriangleMesh {
  std::vector<Vector3> vertices;
  std::vector<std::array<u32, 3>> triangles;
};

struct Surface;  // made by make_surface()

struct ShapeDescription {
  ShapeKind kind = SHAPE_SPHERE;
  Vector3 offset = {0, 0, 0};  // in the body frame, m
  Quaternion rotation = {0, 0, 0, 1};
  double radius = 0;                              // sphere, capsule, cylinder
  double half_length = 0;                         // capsule: of the core segment; cylinder: of the axis; along z
  Vector3 half_extents = {0, 0, 0};               // box
  std::vector<Vector3> points = {};               // hull: the corners, in the shape's frame
  std::shared_ptr<const TriangleMesh> mesh = {};  // mesh: closed, and the same for all copies of the shape
  std::shared_ptr<const Surface> surface = {};    // facet: all those of a surface, in this frame
  u32 material = 0;                               // index into Scene::materials
  u32 category = 1, mask = 0xffffffffu;           // collision filter
  bool trigger = false;                           // tells what overlaps it and pushes nothing; has no mass
};

struct BodyDescription {
  std::string name = {};  // may be empty
  BodyKind kind = BODY_DYNAMIC;
  double mass = 0;               // kg; 0 for static and kinematic bodies
  Vector3 inertia = {0, 0, 0};   // principal moments about the centre of mass, kg m^2
  Vector3 position = {0, 0, 0};  // of the centre of mass
  Quaternion orientation = {0, 0, 0, 1};
  Vector3 velocity = {0, 0, 0};
  Vector3 angular_velocity = {0, 0, 0};  // world frame
  double gravity_share = 1;              // of its weight that it feels: a load holds the rest
  bool pivoted = false;
  Vector3 com_offset = {0, 0, 0};  // from the pivot to the centre of mass, body frame; the pivot follows from the pose
  bool continuous = false;         // its impacts are looked for within the step
  Vector3 plane_normal = {0, 0, 0};  // of the plane that it moves in, world frame, in a file and in World::add, which
                                     // make a planar joint of it; 0: it moves in all directions
  std::vector<ShapeDescription> shapes = {};
};

/// Where the two bodies of a joint stand when its anchors and its axis are given; that of the world does not matter.
struct ReferencePoses {
  Vector3 position_a = {0, 0, 0}, position_b = {0, 0, 0};
  Quaternion orientation_a = {0, 0, 0, 1}, orientation_b = {0, 0, 0, 1};
};

/// Of what pushes as much as it must.
inline constexpr std::array<double, 2> any_force = {-std::numeric_limits<double>::infinity(),
                                                    std::numeric_limits<double>::infinity()};

/// Pushes the free coordinate x of a joint by -stiffness (x - rest) - damping x', as far as its forces allow.
struct JointSpring {
  double stiffness = 0;                      // N/m, N m/rad
  double damping = 0;                        // N s/m, N m s/rad
  double rest = 0;                           // m, rad
  std::array<double, 2> forces = any_force;  // the least and the most, N or N m
};

using JointStand [[deprecated("is called ReferencePoses")]] = ReferencePoses;

struct JointDescription {
  std::string name = {};  // may be empty
  JointKind kind = JOINT_BALL;
  u32 body_a = NONE, body_b = NONE;  // indices into Scene::bodies; NONE is the world
  Vector3 anchor_a = {0, 0, 0};      // world frame; the same point but for a distance joint
  Vector3 anchor_b = {0, 0, 0};
  Vector3 axis = {0, 0, 1};         // world frame; need not be unit. Of a universal joint the one that a carries
  Vector3 second_axis = {1, 0, 0};  // of a universal joint, perpendicular to the first: the one that b carries
  double pitch = 0;                 // of a screw, m a turn; left-handed below 0
  double radius = 0;                // of what rolls, m
  double start = 0;  // of an angle that counts revolutions, rad: of all that the poses at load allow it has the nearest
  bool limited = false;
  double low = 0, high = 0;                            // m or rad
  double motor_speed = 0, motor_force = 0;             // m/s and N, rad/s and N m; a force of 0 is no motor
  double friction = 0;                                 // N or N m, dry, instead of a motor
  std::optional<JointSpring> spring = {};              // beside limits too
  double armature = 0;                                 // inertia along the free coordinate, kg or kg m^2
  bool collide = false;                                // the two bodies may collide with each other
  double frequency = 0;                                // Hz, of a joint that is soft as a whole; 0 where it is rigid
  double damping = 1;                                  // of that, in parts of the critical one
  std::optional<ReferencePoses> reference_poses = {};  // none: anchors and axis are given for the poses at load
};

struct CoupledCoordinate {
  u32 joint = NONE;  // index into Scene::joints
  double ratio = 1;  // not 0
};

/// Ties the free coordinates x of joints to each other: what is said of their sum, each times its ratio, m or rad.
struct CouplingDescription {
  std::string name = {};  // may be empty
  std::vector<CoupledCoordinate> joints = {};
  bool limited = false;
  double low = 0, high = 0;                // equal ones lock it
  std::optional<JointSpring> spring = {};  // of any force; beside limits too
};

/// Drives a joint by a control: a servo, whose spring rests where the control says, or a motor, whose force it is.
struct ActuatorDescription {
  std::string name = {};  // may be empty
  u32 joint = NONE;       // index into Scene::joints
  double control = 0;     // in units of its own: often rad, m or N m
  std::array<double, 2> range = {-std::numeric_limits<double>::infinity(),
                                 std::numeric_limits<double>::infinity()};  // within which the control acts
  // of a servo: what its joint's spring rests at with the controls of all its servos 0, rad or m, and for a unit of
  // this control so much more
  double rest_at_zero = 0, rest = 0;
  // of a motor: its force with a control of 0, N or N m, for a unit of it so much more, and its bounds
  double force_at_zero = 0, force = 0;
  std::array<double, 2> forces = {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::string refusal = {};  // why its control cannot be another; empty: it can
};

/// Of the contacts of a body or a shape, or of a joint; touch is of contacts alone.
enum class SensorKind { force, torque, touch };

/// What measures the forces of a joint, of a body's contacts, or of those of one of its shapes
/// (docs/reference/forces.md).
struct SensorDescription {
  std::string name = {};  // not empty; no two of a scene have the same
  SensorKind kind = SensorKind::force;
  u32 body = NONE, joint = NONE;  // index into Scene::bodies or Scene::joints; the other is NONE
  std::optional<u32> shape = {};  // index into the body's shapes; none: all of them
};

/// Where pictures are taken from; no part of what is simulated.
struct CameraDescription {
  Vector3 position, target;
  double fov_deg = 35;  // of the height of a picture
};

struct Scene {
  std::string name, source;        // the file's stem and path
  std::string description;         // one line: what a viewer should see
  std::string text;                // of the file, as it was read
  std::vector<std::string> notes;  // what the file should say otherwise, a line each: keys by their old names
  bool seeded = false;             // some of it was drawn from the seed that it was read with
  Vector3 gravity = {0, 0, -9.81};
  Settings settings;
  std::vector<Material> materials;
  std::vector<MaterialPairRule> material_pairs;
  std::vector<std::string> categories;  // of shapes by name, in the order of their bits; empty: "default" alone
  std::vector<BodyDescription> bodies;
  std::vector<JointDescription> joints;
  std::vector<ActuatorDescription> actuators;  // of robots, in the order of their files
  std::vector<CouplingDescription> couplings;
  std::vector<SensorDescription> sensors;
  // bodies that pass through each other, as those of a joint do; goes with joints
  std::vector<std::array<u32, 2>> passing;
  std::optional<ParticleSettings> particles;  // none: bodies collide by their shapes
  std::optional<CameraDescription> camera;    // none: framed automatically
};

// ---- bodies made of shapes

/// Gives a dynamic body the mass and the moments of its shapes, kg/m^3, and moves its frame, whose origin and axes may
/// be any, to the centre of mass and the principal axes; the shapes stay where they are in the world. Shapes that
/// overlap count twice where they do. The body must have solid shapes, all of them bounded.
void make_solid(BodyDescription& body, double density);

/// The same with the density that makes it so heavy, kg.
void make_solid_of_mass(BodyDescription& body, double mass);

/// The same where mass, centre (m) and inertia matrix about it (xx, yy, zz, xy, xz, yz; kg m^2) are given, in the frame
/// of the shapes.
void make_solid_of(BodyDescription& body, double mass, const Vector3& center, const std::array<double, 6>& inertia);

// ---- surfaces that bodies collide with triangle by triangle

/// The surface of a mesh, which may have an edge; vertices at one position are made one. Where it is none (no
/// triangles, too many, one without area, more than two at an edge or two turned against each other) `flaw` says why,
/// with a place, and what to do. All vertices must be finite.
std::shared_ptr<const Surface> make_surface(TriangleMesh mesh, std::string& flaw);

/// Heights of a grid, row by row along y and along x within a row, `spacing` m apart, about the middle of the grid.
/// Each cell is two triangles that meet at the diagonal from its corner of least x and y. At least two rows of two, all
/// of one length.
TriangleMesh height_field(const std::vector<std::vector<double>>& rows, double spacing);

}  // namespace lockstep
