#include "host/steppers/multibody.hpp"

#include <Eigen/Geometry>
#include <string>

#include "host/item_error.hpp"

namespace lockstep {

namespace {

using Eigen::Vector3d;
namespace models = oracle::models;

[[noreturn]] void refuse(const std::string& where, const std::string& what) {
  throw Error(Failure::input, where, what);
}
[[noreturn]] void refuse(const SystemJoint& joint, const std::string& what) {
  throw ItemError(Failure::input, "", Item::joint, 0, joint.joint, what);
}

void check(const ContactSystem& system) {
  if (!system.patches.empty())
    refuse("contacts", "form friction patches; the models of the oracles have a cone at each contact");
  if (!system.angular_friction.empty())
    refuse("contacts", "have angular friction; the models of the oracles have a cone at each contact");
  for (const SystemJoint& j : system.joints) {
    const bool bounded = j.slowest > -double(JOINT_UNBOUNDED) || j.fastest < double(JOINT_UNBOUNDED);
    if (j.impedance_compliance > 0)
      refuse(j, "has armature, or a spring beside limits; the models of the oracles have free joints, or dry friction");
    if (j.softness > 0) refuse(j, "is a spring; the models of the oracles have rigid joints");
    if (j.free != FREE_NOTHING && (bounded || (j.motor_impulse > 0 && j.motor_speed != 0)))
      refuse(j, "has a motor, a limit or a spring; the models of the oracles have free joints, or dry friction");
  }
}

void push(models::Body& body, const Vector3d& arm, const Vector3d& impulse, const Vector3d& moment) {
  body.v += body.inverse_mass * impulse;
  body.w += body.inverse_inertia * (arm.cross(impulse) + moment);
}

// A row of a joint, b against a, by what a unit of its impulse pushes with. The oracles' rows are a against b: so b is
// first.
models::Row joint_row(const SystemJoint& j, const Vector3d& push, const Vector3d& moment) {
  models::Row row;
  row.body_a = j.body_b;
  row.body_b = j.body_a;
  row.linear = push;
  row.angular_a = j.arm_b.cross(push) + moment;
  row.angular_b = -j.arm_a.cross(push) - moment;
  return row;
}

}  // namespace

models::Multibody multibody(const ContactSystem& system) {
  check(system);
  models::Multibody result;
  for (const SystemBody& b : system.bodies) result.bodies.push_back({b.inverse_mass, b.inverse_inertia, b.v, b.w});
  for (const SystemContact& c : system.contacts) {
    result.contacts.push_back({c.body_a, c.body_b, c.normal, c.arm_a, c.arm_b, c.bias, c.friction, c.slide});
    push(result.bodies[c.body_a], c.arm_a, -c.impulse, Vector3d::Zero());
    push(result.bodies[c.body_b], c.arm_b, c.impulse, Vector3d::Zero());
  }
  for (const SystemJoint& j : system.joints) {
    const Vector3d impulse = push_of(j, j.impulse) + free_push_of(j, j.free_impulse);
    const Vector3d moment = moment_of(j, j.impulse) + free_moment_of(j, j.free_impulse);
    push(result.bodies[j.body_a], j.arm_a, impulse, moment);
    push(result.bodies[j.body_b], j.arm_b, -impulse, -moment);
    for (u32 i = 0; i < JOINT_ROWS; ++i) {
      const Rows unit = Rows::Unit(i);
      if ((j.locked >> i & 1) != 0)
        result.joint_rows.push_back({joint_row(j, push_of(j, unit), moment_of(j, unit)), j.bias[i]});
    }
    if (has_friction(j))
      result.dry_rows.push_back({joint_row(j, free_push_of(j, 1), free_moment_of(j, 1)), j.motor_impulse});
  }
  return result;
}

}  // namespace lockstep
