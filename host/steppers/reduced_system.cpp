#include "host/steppers/reduced_system.hpp"

#include <limits>

#include "host/error.hpp"
#include "host/in_double.hpp"
#include "host/item_error.hpp"
#include "host/scene/joint_angles.hpp"
#include "host/scene/joint_kinds.hpp"

namespace lockstep {

namespace {

using namespace oracle::articulated;

constexpr JointType types[] = {
#define JOINT_KIND(name, NAME, linear, angular, free, keys, level, reduced, noun, leaves) JointType::reduced,
#include "kernels/joint_kinds.def"
#undef JOINT_KIND
};

Vector6 load_on(const Buffers<double>& b, u32 i) {
  Vector6 load = Vector6::Zero();
  if (!b.loads.empty()) load += spatial(vector3(b.loads[i].force), vector3(b.loads[i].torque));
  if (!b.particle_loads.empty())
    load += spatial(vector3(b.particle_loads[i].force), vector3(b.particle_loads[i].torque));
  return load;
}

}  // namespace

System articulated_system(const Buffers<double>& b) {
  System system;
  for (std::size_t i = 0; i < b.body_infos.size(); ++i) {
    const bool dynamic = b.body_infos[i].kind == BODY_DYNAMIC;
    system.bodies.push_back({dynamic ? b.masses[i].mass : 0, vector3(b.masses[i].inertia), false});
  }
  system.bodies.push_back({});
  for (std::size_t j = 0; j < b.joints.size(); ++j) {
    const JointInfo& info = b.joint_infos[j];
    const lockstep::Joint<double>& from = b.joints[j];
    if (from.spring > 0)
      throw ItemError(Failure::input, "", Item::joint, info.world, info.id,
                      "has a \"frequency\": in reduced coordinates joints are rigid; take it away");
    if (is_non_holonomic(static_cast<JointKind>(info.kind)))
      throw ItemError(
          Failure::input, "", Item::joint, info.world, info.id,
          "holds velocities that no coordinates stand for; take a solver that is not in reduced coordinates");
    oracle::articulated::Joint joint;
    for (const u32 body : {info.body_a, info.body_b}) {
      if (system.bodies[body].mass > 0) system.bodies[body].is_link = true;
    }
    joint.body_a = info.body_a;
    joint.body_b = info.body_b;
    joint.type = types[info.kind];
    joint.anchor_a = vector3(from.anchor_a);
    joint.anchor_b = vector3(from.anchor_b);
    joint.frame_a = rotation(from.frame_a);
    joint.frame_b = rotation(from.frame_b);
    joint.lead = b.screw_leads.empty() ? 0 : b.screw_leads[j];
    system.joints.push_back(joint);
  }
  return system;
}

Laws laws_of(const Buffers<double>& b, const Tree& tree) {
  Laws laws;
  std::vector<bool> closes(b.joints.size(), false);
  for (const std::size_t joint : tree.closures())
    closes[joint] = tree.system().joints[joint].type != JointType::distance;
  for (std::size_t j = 0; j < b.joints.size(); ++j) {
    const lockstep::Joint<double>& joint = b.joints[j];
    const bool bounded = b.joint_infos[j].free != FREE_NOTHING && joint.limited != 0,
               sprung = joint.spring_compliance > 0;
    const bool fixed = bounded && !sprung && joint.low == joint.high;
    if (closes[j] || fixed) laws.closures.push_back({j, closes[j], fixed, joint.low});
    if (bounded && sprung) laws.springs.push_back({j, joint.rate, joint.low, joint.spring_compliance});
    if (joint.side_compliance > 0 && !fixed)
      laws.springs.push_back({j, joint.side_rate, joint.side_rest, joint.side_compliance});
    if (joint.armature > 0 && !fixed) laws.armatures.push_back({j, joint.armature});
    if (bounded && !sprung && !fixed) laws.limits.push_back({j, joint.low, joint.high});
  }
  return laws;
}

StepStart step_start(const Buffers<double>& b, const StepParams<double>& params, const Tree& tree) {
  StepStart start;
  const std::size_t bodies = b.body_infos.size() + 1;
  start.poses.resize(bodies);
  start.twists.assign(bodies, Vector6::Zero());
  start.wrenches.assign(bodies, Vector6::Zero());
  start.lone.resize(bodies);
  start.dt = params.dt;
  start.theta = params.theta;
  start.gyroscopic = params.gyroscopic != 0;
  if (!b.joint_angles.empty()) {
    start.angles = angles_of_substep(b, params.dt);
    for (std::size_t j = 0; j < start.angles.size(); ++j) start.angles[j] += b.joint_angles[j];
  }
  for (u32 i = 0; i + 1 < bodies; ++i) {
    const Motion<double>& motion = b.motions[i];
    start.poses[i] = {vector3(b.positions[i]), rotation(b.orientations[i])};
    if (tree.link_of(i) != no_link) {
      start.twists[i] = spatial(vector3(b.previous_velocities[i].v), vector3(b.previous_velocities[i].w));
      start.wrenches[i] = load_on(b, i);
      start.wrenches[i].head<3>() += b.masses[i].mass * vector3(b.gravities[b.body_infos[i].world]);
      continue;
    }
    start.twists[i] = spatial(vector3(motion.v), vector3(motion.w));
    LoneBody& lone = start.lone[i];
    lone.inverse_mass = motion.inverse_mass;
    lone.inverse_inertia << motion.inertia_xx, motion.inertia_xy, motion.inertia_xz, motion.inertia_xy,
        motion.inertia_yy, motion.inertia_yz, motion.inertia_xz, motion.inertia_yz, motion.inertia_zz;
  }
  return start;
}

Demand demand_of(const ContactSystem& system, const Buffers<double>& b, const Laws& laws, const Step& step) {
  Demand demand;
  for (const SystemContact& c : system.contacts)
    demand.contacts.push_back({c.body_a, c.body_b, c.normal, c.arm_a, c.arm_b, c.bias, c.friction, c.slide});
  const double infinite = std::numeric_limits<double>::infinity(), dt = step.given().dt;
  for (const Limit& limit : laws.limits) {
    const double x = step.coordinate_from(limit.joint);
    RateBound bound = {limit.joint, -std::max(x - limit.low, 0.0) / dt, std::max(limit.high - x, 0.0) / dt};
    if (limit.low <= -double(JOINT_UNBOUNDED)) bound.slowest = -infinite;
    if (limit.high >= double(JOINT_UNBOUNDED)) bound.fastest = infinite;
    demand.bounds.push_back(bound);
  }
  for (std::size_t j = 0; j < b.joints.size(); ++j) {
    const lockstep::Joint<double>& joint = b.joints[j];
    if (joint.motor_force < 0)
      throw Error(Failure::input, "joint", "has a spring of bounded force, which this solver has no rows for");
    if (b.joint_infos[j].free != FREE_NOTHING && joint.motor_force > 0)
      demand.drives.push_back({j, joint.motor_speed, joint.motor_force * dt});
  }
  return demand;
}

std::vector<JointPush> joint_pushes(const Step& step, const Laws& laws, const Demand& demand,
                                    const ReducedProblem& problem, const VectorXd& impulses) {
  const Tree& tree = step.tree();
  const auto& joints = tree.system().joints;
  std::vector<JointPush> pushes(joints.size());
  const LinkVectors carried = step.carried();
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const Link& link = tree.link(i);
    if (link.joint == no_link) continue;
    const auto& joint = joints[link.joint];
    const JointGeometry s = joint_geometry(joint, step.at());
    const Vector6 on_b =
        (link.child_is_b ? 1.0 : -1.0) * wrench_from(carried[i], step.at().poses[link.body].x - s.point);
    const unsigned mask = locked_rows(joint, s).mask;
    for (int k = 0; k < 6; ++k) {
      const Vector3d component = k < 3 ? on_b.head<3>() : on_b.tail<3>();
      if ((mask >> k & 1) != 0) pushes[link.joint].locked[k] = s.axes.col(k % 3).dot(component);
    }
  }
  Index next = 0;
  for (const Closure& closure : laws.closures) {
    const auto& joint = joints[closure.joint];
    const JointGeometry s = joint_geometry(joint, step.at());
    const unsigned mask = closure.locked ? locked_rows(joint, s).mask : 0;
    for (int k = 0; k < 6; ++k) {
      if ((mask >> k & 1) != 0) pushes[closure.joint].locked[k] = step.bilateral_impulses()[next++];
    }
    if (closure.fixed) pushes[closure.joint].free += step.bilateral_impulses()[next++];
  }
  for (const Spring& spring : laws.springs) pushes[spring.joint].free += step.bilateral_impulses()[next++];
  for (const oracle::articulated::Armature& armature : laws.armatures)
    pushes[armature.joint].impedance += step.bilateral_impulses()[next++];
  for (Index i = 0; i < problem.bounds(); ++i) {
    const RateBound& bound = demand.bounds[problem.bound_of[std::size_t(i)]];
    const bool second = i > 0 && problem.bound_of[std::size_t(i)] == problem.bound_of[std::size_t(i - 1)];
    const double sign = second || bound.slowest == -std::numeric_limits<double>::infinity() ? -1 : 1;
    pushes[bound.joint].free += sign * impulses[problem.first_bound() + i];
  }
  for (Index i = 0; i < problem.drives(); ++i)
    pushes[demand.drives[std::size_t(i)].joint].free += impulses[problem.first_drive() + i];
  return pushes;
}

}  // namespace lockstep
