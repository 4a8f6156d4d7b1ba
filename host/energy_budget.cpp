#include "host/energy_budget.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/stages.hpp"

namespace lockstep {

namespace {

template <class real>
double length(const real* v) {
  return std::hypot(double(v[0]), double(v[1]), double(v[2]));
}

// Radius of gyration, squared: of the mean moment.
template <class real>
double gyration_2(const Mass<real>& mass) {
  const double mean = (double(mass.inertia[0]) + double(mass.inertia[1]) + double(mass.inertia[2])) / 3;
  return std::isfinite(mean) && mass.mass > 0 ? mean / double(mass.mass) : 0;
}

template <class real>
bool moves(const Motion<real>& motion) {
  return length(motion.v) > 0 || length(motion.w) > 0;
}

template <class real>
EnergySource source_of(const Buffers<real>& b, Features features) {
  if (has(features, Feature::particles)) return EnergySource::particles;
  const auto acts = [](const Load<real>& load) { return length(load.force) > 0 || length(load.torque) > 0; };
  if (has(features, Feature::loads) && std::ranges::any_of(b.loads, acts)) return EnergySource::loads;
  for (std::size_t i = 0; i < b.body_infos.size(); ++i)
    if (b.body_infos[i].kind == BODY_KINEMATIC && moves(b.motions[i])) return EnergySource::kinematic_bodies;
  const auto drives = [](const Joint<real>& joint) {
    return joint.motor_speed != 0 && double(joint.motor_force) >= double(JOINT_UNBOUNDED);
  };
  if (has(features, Feature::joints) && std::ranges::any_of(b.joints, drives)) return EnergySource::unbounded_motors;
  const auto is_servo = [](const Joint<real>& joint) { return joint.motor_force < 0; };
  if (has(features, Feature::joints) && std::ranges::any_of(b.joints, is_servo)) return EnergySource::servos;
  const auto is_soft = [](const Joint<real>& joint) { return joint.spring != 0; };
  if (has(features, Feature::joints) && std::ranges::any_of(b.joints, is_soft)) return EnergySource::soft_joints;
  return EnergySource::none;
}

}  // namespace

std::vector<Buffer> energy_buffers(Features features) {
  std::vector<Buffer> buffers = {Buffer::body_infos, Buffer::gravities, Buffer::masses, Buffer::positions,
                                 Buffer::motions};
  if (has(features, Feature::joints)) {
    buffers.push_back(Buffer::joint_infos);
    buffers.push_back(Buffer::joints);
  }
  if (has(features, Feature::loads)) buffers.push_back(Buffer::loads);
  return buffers;
}

template <class real>
double motor_power(const std::vector<Joint<real>>& joints) {
  double power = 0;
  for (const Joint<real>& joint : joints)
    if (joint.motor_force > 0) power += std::abs(double(joint.motor_speed)) * double(joint.motor_force);
  return power;
}

template <class real>
EnergyBudget energy_budget(const Buffers<real>& b, Features features) {
  EnergyBudget budget;
  budget.source = source_of(b, features);
  if (has(features, Feature::joints)) budget.power = motor_power(b.joints);
  budget.has_springs = has(features, Feature::joint_springs);
  for (std::size_t i = 0; i < b.body_infos.size(); ++i) {
    if (b.body_infos[i].kind != BODY_DYNAMIC) continue;
    const double mass = double(b.masses[i].mass), k_2 = gyration_2(b.masses[i]);
    const double rounding = 64 * double(std::numeric_limits<real>::epsilon()) * length(&b.positions[i].x);
    budget.negligible += mass * length(&b.gravities[b.body_infos[i].world].x) * (std::sqrt(k_2) + rounding);
    budget.negligible += 0.5 * mass * 1e-4 * k_2;
  }
  return budget;
}

template <class real>
real units_per_joule(const Buffers<real>& b, const StepParams<real>& params) {
  double all = 0;
  for (std::size_t i = 0; i < b.body_infos.size(); ++i) {
    if (b.body_infos[i].kind != BODY_DYNAMIC) continue;
    const double mass = double(b.masses[i].mass), k = std::sqrt(gyration_2(b.masses[i]));
    const double v = length(b.motions[i].v), w = length(b.motions[i].w), slow = 0.01 * k / double(params.dt);
    all += 0.5 * mass * (v * v + k * k * w * w + slow * slow);
    all += mass * length(&b.gravities[b.body_infos[i].world].x) * (length(&b.positions[i].x) + k);
  }
  for (const Joint<real>& joint : b.joints) {
    const auto add_spring = [&](real rate, real compliance, real at) {
      if (!(compliance > 0)) return;
      const double stiffness = double(rate) / (double(compliance) * double(params.dt));
      const double a = length(joint.anchor_a), c = length(joint.anchor_b), rest = double(at);
      all += stiffness * (a * a + c * c + rest * rest);
    };
    add_spring(joint.rate, joint.spring_compliance, joint.low);
    add_spring(joint.side_rate, joint.side_compliance, joint.side_rest);
  }
  for (std::size_t i = 0; i < b.joints.size(); ++i) {
    const auto speed_2 = [&](u32 body) {
      const Motion<real>& motion = b.motions[body];
      const double v = length(motion.v), w = length(motion.w), slow = 0.01 / double(params.dt);
      const double arm = std::max(length(b.joints[i].anchor_a), length(b.joints[i].anchor_b));
      return b.joint_infos[i].free == FREE_ANGLE ? w * w + slow * slow : v * v + arm * arm * (w * w + slow * slow);
    };
    if (b.joints[i].armature > 0)
      all += double(b.joints[i].armature) * (speed_2(b.joint_infos[i].body_a) + speed_2(b.joint_infos[i].body_b));
  }
  if (!(all > 0) || !std::isfinite(all)) return 1;
  return static_cast<real>(std::ldexp(1.0, std::clamp(32 - std::ilogb(all), -100, 100)));
}

#define INSTANTIATE(real)                                              \
  template double motor_power(const std::vector<Joint<real>>&);        \
  template EnergyBudget energy_budget(const Buffers<real>&, Features); \
  template real units_per_joule(const Buffers<real>&, const StepParams<real>&);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep
