// The constraint system of the last sub-step as the report sees it: one cone per contact point and one block per
// joint, everything in double; contacts are in the world frame, so that no tangent frame is needed.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "host/buffers.hpp"

namespace lockstep {

struct SystemBody {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();                // of the centre of mass at the end of the solve, m/s
  Eigen::Vector3d w = Eigen::Vector3d::Zero();                // rad/s
  double inverse_mass = 0;                                    // 1/kg, 0 for immovable bodies
  Eigen::Matrix3d inverse_inertia = Eigen::Matrix3d::Zero();  // world frame, 1/(kg m^2)
};

struct SystemContact {
  u32 body_a = 0, body_b = 0;                       // into ContactSystem::bodies
  Eigen::Vector3d normal;                           // from b to a, unit
  Eigen::Vector3d arm_a, arm_b;                     // from the centre of mass to the contact point, m
  double bias = 0;                                  // m/s: u_n + bias >= 0
  Eigen::Vector3d slide = Eigen::Vector3d::Zero();  // m/s, added to u in the tangent plane: of a law of impact
  double friction = 0;                              // mu
  Eigen::Vector3d impulse;                          // on a, N s
  u32 contact = 0;                                  // index into the contact list it came from
};

/// The angular friction of a contact (cpu_reference/solve_angular_friction.hpp).
struct SystemAngularFriction {
  double torsion_radius = 0;                              // m; 0: it rotates freely
  double rolling_coefficient = 0;                         // m; 0: it rolls freely
  Eigen::Matrix3d stretch = Eigen::Matrix3d::Identity();  // E: the cone of E^-1 r is round, its velocity E u
  double torsion = 0;                              // N s: the moment about the normal, on a, at the torsion radius
  Eigen::Vector3d roll = Eigen::Vector3d::Zero();  // the rest of the moment, on a, N m s
};

/// What the contacts of a pair share where they share one friction patch; their own impulses are spread of it.
struct SystemPatch {
  u32 first = 0, count = 0;                         // contacts of the pair, into ContactSystem::contacts
  Eigen::Vector3d normal;                           // from b to a, unit
  Eigen::Vector3d arm_a, arm_b;                     // from the centre of mass to the centre of pressure, m
  double friction = 0;                              // mu
  Eigen::Vector3d impulse;                          // on a, in the tangent plane, N s
  double twist = 0;                                 // on a, about the normal, N m s
  std::array<double, MANIFOLD_POINTS> distances{};  // m
};

using Rows = Eigen::Matrix<double, JOINT_ROWS, 1>;

struct SystemJoint {
  u32 body_a = 0, body_b = 0;
  Eigen::Matrix3d axes;          // columns: x, y, z of the joint's frame
  double lead = 0;               // of a screw, m a radian: its row of z is u_z - lead w_z
  Eigen::Vector3d arm_a, arm_b;  // from the centre of mass to the point where the impulses act, m
  u32 locked = 0;                // bit of each locked row
  Rows bias;                     // u + bias + softness K r = 0 in the locked rows, b against a
  double softness = 0;
  Rows impulse;             // on b, N s and N m s
  u32 free = FREE_NOTHING;  // JointFree
  Eigen::Vector3d free_axis;
  double free_impulse = 0;
  double motor_speed = 0, motor_impulse = 0;
  double slowest = 0, fastest = 0;  // bounds of the free velocity
  double bound_softness = 0;        // their softness, in parts of the mobility
  double spring_compliance = 0;     // of its spring, which both bounds are the rest of; 0 where there is none
  // of armature and what is beside it: u - impedance_speed + impedance_compliance impulse = 0; 0 where there is none
  double impedance_compliance = 0, impedance_speed = 0, impedance_impulse = 0;
  double effective_mobility = 0;  // of the free row while the locked rows and the impedance answer
  u32 joint = 0;                  // index into the joints it came from
};

/// The linear and the angular part of the rows of a joint together, b against a: what an impulse `rows` pushes with at
/// the ends of the arms, and the moment that it has there.
inline Eigen::Vector3d push_of(const SystemJoint& joint, const Rows& rows) { return joint.axes * rows.head<3>(); }
inline Eigen::Vector3d moment_of(const SystemJoint& joint, const Rows& rows) {
  return joint.axes * rows.tail<3>() - joint.lead * rows[2] * joint.axes.col(2);
}

/// All that the free row pushes with.
inline double whole_free_impulse(const SystemJoint& joint) { return joint.free_impulse + joint.impedance_impulse; }

/// Whether dry friction acts on the free row, or a motor that wants it to stand still.
inline bool has_friction(const SystemJoint& joint) {
  return joint.free != FREE_NOTHING && joint.motor_impulse > 0 && joint.motor_speed == 0;
}

/// The same for the free row, along or about its axis.
inline Eigen::Vector3d free_push_of(const SystemJoint& joint, double impulse) {
  return joint.free == FREE_NOTHING || joint.free == FREE_ANGLE ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                                                                : Eigen::Vector3d(impulse * joint.free_axis);
}
inline Eigen::Vector3d free_moment_of(const SystemJoint& joint, double impulse) {
  return joint.free == FREE_ANGLE ? Eigen::Vector3d(impulse * joint.free_axis)
                                  : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

struct ContactSystem {
  std::vector<SystemBody> bodies;
  std::vector<SystemContact> contacts;
  std::vector<SystemAngularFriction> angular_friction;  // one for each contact, or none where none has angular friction
  std::vector<SystemPatch> patches;  // where the scene's friction model is `patches`: each contact belongs to one
  std::vector<SystemJoint> joints;
  bool convex = false;  // solved in the convex relaxation, u_n + bias >= mu |u_t| (solvers along a gradient)
};

/// [a] with [a] b = a x b.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

/// The tangents that the solver recomputes from a unit normal (kernels/frame.h), as columns.
Eigen::Matrix<double, 3, 2> solver_tangents(const Eigen::Vector3d& normal);

/// The system that the last sub-step solved, from the buffers `contact_system_buffers` of the step's end. The features
/// say whether it was relaxed once bodies had moved.
template <class real>
ContactSystem contact_system(const Buffers<real>& buffers, std::span<const u32> counters, Features features = {});

}  // namespace lockstep
