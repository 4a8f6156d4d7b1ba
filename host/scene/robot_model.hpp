// A robot as its file describes it, whatever the format: links, each in a frame of its own, and joints that make a tree
// of them.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/scene/mass_properties.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// All in the frame of the link.
struct RobotLink {
  std::string name, location;              // the location is for messages
  std::optional<MassProperties> inertial;  // none: it has no mass of its own
  std::vector<ShapeDescription> shapes;    // materials and filters as Robot::contacts says
  bool is_kinematic = false;               // goes where it is put, and pushes; below a floating joint
  double gravity_share = 1;                // of its weight that it feels
};

/// As `<mimic>` of URDF: the joint stays where another one, times a multiplier, is, and on by an offset.
struct RobotMimic {
  std::string leader;
  double multiplier = 1, offset = 0;
};

/// `sliding` is prismatic without limits, `continuous` is revolute without.
enum class RobotJointKind { fixed, revolute, continuous, prismatic, sliding, planar, floating, ball, universal };

/// Of a frame in another one.
struct RobotPose {
  Vector3 position = {0, 0, 0};
  Quaternion orientation = {0, 0, 0, 1};

  RobotPose operator*(const RobotPose& inner) const {
    return {exact::add(position, exact::rotate(orientation, inner.position)),
            exact::unit(exact::multiply(orientation, inner.orientation))};
  }
};

inline RobotPose inverse(const RobotPose& pose) {
  const Quaternion& q = pose.orientation;
  const Quaternion back = {-q[0], -q[1], -q[2], q[3]};
  return {exact::scale(-1, exact::rotate(back, pose.position)), back};
}

struct RobotJoint {
  std::string name, location;
  RobotJointKind kind = RobotJointKind::fixed;
  u32 parent = 0, child = 0;     // links
  Vector3 position = {0, 0, 0};  // of the child's frame in the parent's, where the joint is at 0
  Quaternion orientation = {0, 0, 0, 1};
  // in the child's frame; axes need not be unit
  Vector3 anchor = {0, 0, 0}, axis = {1, 0, 0};
  Vector3 second_axis = {0, 1, 0};         // of a universal joint: the one that the child carries
  double low = 0, high = 0;                // rad or m; of revolute and prismatic ones
  double damping = 0, friction = 0;        // N m s/rad and N m, or N s/m and N
  double armature = 0;                     // inertia along its coordinate, kg or kg m^2
  std::optional<JointSpring> spring = {};  // always there
  std::vector<JointSpring> servos = {};    // its actuators', as long as the scene gives no spring
  std::optional<double> locked_at = {};    // the coordinate does not leave this
  double start = 0;                        // its coordinate at load, rad or m
  std::optional<RobotMimic> mimic = {};    // it starts there, too
  bool collide = false;                    // its two bodies may touch
  // of one with several coordinates at load: how far the child's frame has gone from where the joint is at 0, in that
  std::optional<RobotPose> start_pose = {};
};

/// The same where only the coordinate of a joint with one is not 0.
RobotPose moved(const RobotJoint& joint, double by);

/// What drives a joint by a control, in the words of ActuatorDescription.
struct RobotActuator {
  ActuatorDescription drive;  // its joint is that of the robot; of a servo `rest_at_zero` is that of its own spring
  std::optional<u32> servo;   // of the joint's servos; none: a motor, or nothing
};

/// Holds two links of a tree together, so that it has a ring.
struct RobotLoop {
  std::string name, location;
  bool is_ball = false;  // about the anchor, as a ball does; else nothing moves
  u32 a = 0, b = 0;
  Vector3 anchor = {0, 0, 0};  // in the frame of a, with all joints at 0
  // where they are held together otherwise than as they stand: in the frame of a, and in that of b
  std::optional<std::array<RobotPose, 2>> sides = {};
};

/// Of joints with a coordinate: what CouplingDescription says, of joints of the robot.
struct RobotCoupling {
  std::string name;
  CouplingDescription law = {};  // its joints are indices into those of the robot
  bool is_equality = false;      // not of a tendon
};

/// How shapes touch, where the file says it: their materials are indices into these, and their categories and masks
/// have a bit for each of the classes.
struct RobotContacts {
  std::vector<Material> materials;
  std::vector<MaterialPairRule> pairs;
  u32 classes = 1;
};

struct Robot {
  std::string name;
  std::vector<RobotLink> links;
  std::vector<RobotJoint> joints;  // a parent before its children
  u32 root = 0;                    // the link that is no child
  bool root_is_fixed = false;      // it does not move, whatever a scene says
  std::vector<RobotActuator> actuators;
  std::vector<RobotLoop> loops;
  std::vector<RobotCoupling> couplings;
  std::vector<std::array<u32, 2>> passing;  // links that pass through each other
  std::optional<RobotContacts> contacts;    // none: as the scene says
  std::vector<std::string> notes;           // what was left out or replaced, a line each
  // where a robot is a scene of its own
  std::optional<Vector3> gravity;
  std::optional<double> dt;
};

}  // namespace lockstep
