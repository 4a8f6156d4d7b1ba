// A joint between two bodies: what it leaves free, by coordinates, and what it locks, by rows. Velocities are those of
// b against a, taken at b's anchor, and wrenches act on b there and their opposite on a. The frame of a joint is fixed
// in both bodies and is one where all coordinates are 0; its axis is z.
//   hinge        angle                      Rz(angle)
//   slider       travel                     along z
//   cylindrical  travel, angle              along z, Rz(angle)
//   planar       x, y, angle                along x and y of a, Rz(angle)
//   ball         a rotation                 rates are the angular velocity along the axes of the frame in a
//   universal    two angles                 Rz(first) Rx(second): z is an arm of the cross in a, x the other in b
//   screw        angle, of whole turns too  Rz(angle), lead angle along z
#pragma once

#include <cstddef>

#include "cpu_reference/oracle/articulated/spatial.hpp"

namespace lockstep::oracle::articulated {

/// `distance` leaves everything free; its coordinate is the length from anchor to anchor.
enum class JointType { fixed, hinge, slider, cylindrical, planar, ball, universal, screw, distance };

/// The body that stands for the world: pose and twist are 0.
inline constexpr std::size_t world = ~std::size_t{0};

struct Pose {
  Vector3d x = Vector3d::Zero();  // centre of mass, m
  Quaterniond q = Quaterniond::Identity();
};

struct Joint {
  std::size_t body_a = world, body_b = world;
  JointType type = JointType::fixed;
  Vector3d anchor_a = Vector3d::Zero(), anchor_b = Vector3d::Zero();  // from the centres of mass, body frames, m
  Quaterniond frame_a = Quaterniond::Identity(), frame_b = Quaterniond::Identity();  // joint to body
  double lead = 0;                                                                   // of a screw, m a radian
};

struct Coordinates {
  Vector3d value = Vector3d::Zero();               // in the order of the table above, m and rad
  Quaterniond rotation = Quaterniond::Identity();  // of a ball, from the frame in b to the frame in a
};

/// The rotation about an axis by an angle, rad: the length of their product `angles`.
Quaterniond rotation_by_vector(const Vector3d& angles);

/// How many coordinates a joint has; a distance joint is in no tree and has none.
Index freedoms(JointType type);

/// A joint at the poses of its bodies.
struct JointGeometry {
  Matrix3d axes;         // columns: x, y, z of the frame in a, of a universal joint those of its cross; world
  Vector3d point;        // b's anchor, world
  Vector3d offset;       // of b's anchor from a's, in the frame in a
  Quaterniond rotation;  // from the frame in b to the frame in a, w >= 0
  Vector3d second;       // x of the frame in b, world
};
JointGeometry joint_geometry(const Joint& joint, const Pose& a, const Pose& b);

/// The coordinates nearest to a joint geometry; what the joint locks is not looked at. Angles are -pi .. pi, but for a
/// screw's, whose whole turns its travel tells.
Coordinates measured(const Joint& joint, const JointGeometry& at);

/// The pose of one body from that of the other: the joint is closed.
Pose pose_of_b(const Joint& joint, const Pose& a, const Coordinates& coordinates);
Pose pose_of_a(const Joint& joint, const Pose& b, const Coordinates& coordinates);

/// Coordinates after `dt` at these rates: exact for constant rates.
Coordinates moved(const Joint& joint, const Coordinates& from, const Eigen::Ref<const VectorXd>& rates, double dt);

/// Twists of b against a at the point, for unit rates.
Columns motion_axes(const Joint& joint, const JointGeometry& at);

/// By how much the twist of the child differs, per second and with rates that stay, from what the acceleration of the
/// parent makes of it: the derivative of V_child = X V_parent + S rates at constant rates is X A_parent + this, about
/// the child's centre of mass. A free root (no joint) has none.
Vector6 velocity_product(const Joint& joint, const JointGeometry& at, const Pose& a, const Vector6& twist_a,
                         const Pose& b, const Vector6& twist_b, const Eigen::Ref<const VectorXd>& rates,
                         bool child_is_b);

/// The rows that a joint locks: linear x, y, z and angular x, y, z along its axes; of a screw z is u_z - lead w_z.
struct LockedRows {
  unsigned mask = 0;                 // bit of each locked row
  Matrix6 wrench = Matrix6::Zero();  // column k: what a unit impulse of row k is, about the point
  Vector6 error = Vector6::Zero();   // m; rad, or the sine of what an axis is off
};
LockedRows locked_rows(const Joint& joint, const JointGeometry& at);

/// Whether the acting coordinate is an angle of which a pose does not tell the revolutions.
bool counts_revolutions(JointType type);

/// The coordinate that limits, motors, springs and dry friction act on: the angle of a hinge, a planar joint, a screw
/// or about the first arm of a universal joint; the travel of a slider or cylindrical joint; a length. Of an angle that
/// counts revolutions that nearest to `expected`. And the wrench about the point whose power at a twist of b against a
/// is the rate of that coordinate.
double acting_coordinate(const Joint& joint, const JointGeometry& at, double expected);
Vector6 acting_axis(const Joint& joint, const JointGeometry& at);

}  // namespace lockstep::oracle::articulated
