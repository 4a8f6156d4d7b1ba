#include "host/report/contact_system.hpp"

#include <algorithm>

#include "host/sleepers.hpp"

namespace lockstep {

namespace {

template <class real>
SystemBody system_body(const Motion<real>& motion) {
  SystemBody body;
  body.v = {double(motion.v[0]), double(motion.v[1]), double(motion.v[2])};
  body.w = {double(motion.w[0]), double(motion.w[1]), double(motion.w[2])};
  body.inverse_mass = double(motion.inverse_mass);
  const double xx = double(motion.inertia_xx), yy = double(motion.inertia_yy), zz = double(motion.inertia_zz);
  const double xy = double(motion.inertia_xy), xz = double(motion.inertia_xz), yz = double(motion.inertia_yz);
  body.inverse_inertia << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  return body;
}

// What the last sweep of a sub-step asked for: soft contacts are relaxed by then.
template <class real>
double relaxed_bias(const Buffers<real>& buffers, u32 row, u32 lane) {
  const bool soft = !buffers.softness_blocks.empty() && buffers.softness_blocks[row].softness[lane] > 0;
  return soft ? 0 : double(buffers.contact_blocks[row].bias[lane]);
}

template <class real>
Eigen::Vector3d vector_at(const real (*field)[PACK], u32 lane) {
  return {double(field[0][lane]), double(field[1][lane]), double(field[2][lane])};
}

template <class real>
SystemAngularFriction system_angular_friction(const AngularFrictionBlock<real>& block, const Vec4<real>& stored,
                                              const Eigen::Vector3d& normal, u32 lane) {
  const Eigen::Vector3d moment(double(stored.x), double(stored.y), double(stored.z));
  SystemAngularFriction angular;
  angular.torsion_radius = double(block.torsion_radius[lane]);
  angular.rolling_coefficient = double(block.rolling_coefficient[lane]);
  const double about = moment.dot(normal);
  angular.torsion = angular.torsion_radius > 0 ? about / angular.torsion_radius : 0;
  angular.roll = moment - about * normal;
  return angular;
}

template <class real>
Eigen::Matrix3d stretch_of(const EllipseBlock<real>& block, const Eigen::Vector3d& normal, u32 lane) {
  const Eigen::Matrix<double, 3, 2> t = solver_tangents(normal);
  Eigen::Matrix2d s;
  s << double(block.s_11[lane]), double(block.s_12[lane]), double(block.s_12[lane]), double(block.s_22[lane]);
  if (block.degenerate[lane] != real(0)) {  // a projection, to the rounding of double
    const Eigen::Vector2d along = (s(0, 0) > s(1, 1) ? s.col(0) : s.col(1)).normalized();
    s = along * along.transpose();
  }
  return normal * normal.transpose() + t * s * t.transpose();
}

template <class real>
SystemPatch system_patch(const Buffers<real>& buffers, u32 block, u32 lane) {
  const PatchBlock<real>& data = buffers.patch_blocks[block];
  const PatchImpulse<real>& impulses = buffers.patch_impulses[block];
  SystemPatch p;
  p.first = buffers.block_bodies[block].contact[lane];
  p.count = buffers.block_bodies[block].count[lane];
  p.normal = Eigen::Vector3d(data.normal_x[lane], data.normal_y[lane], data.normal_z[lane]).normalized();
  p.arm_a = {double(data.arm_a_x[lane]), double(data.arm_a_y[lane]), double(data.arm_a_z[lane])};
  p.arm_b = {double(data.arm_b_x[lane]), double(data.arm_b_y[lane]), double(data.arm_b_z[lane])};
  p.friction = double(data.friction[lane]);
  p.impulse = solver_tangents(p.normal) * Eigen::Vector2d(impulses.tangent_1[lane], impulses.tangent_2[lane]);
  p.twist = double(impulses.twist[lane]);
  for (u32 k = 0; k < p.count; ++k) p.distances[k] = double(data.distance[k][lane]);
  return p;
}

// What the last sweep asked for: a soft joint that is no spring is hard by then, and corrects nothing.
template <class real>
SystemJoint system_joint(const Buffers<real>& buffers, u32 block, u32 lane) {
  const JointBlock<real>& data = buffers.joint_blocks[block];
  const JointImpulseBlock<real>& impulses = buffers.joint_impulses[block];
  SystemJoint j;
  j.joint = buffers.joint_lanes[block].joint[lane];
  const JointInfo& info = buffers.joint_infos[j.joint];
  j.body_a = info.body_a;
  j.body_b = info.body_b;
  j.locked = info.locked;
  j.free = info.free;
  for (int i = 0; i < 3; ++i) j.axes.col(i) = vector_at(data.axes + 3 * i, lane).normalized();
  j.lead = double(data.lead[lane]);
  j.arm_a = vector_at(data.arm_a, lane);
  j.arm_b = vector_at(data.arm_b, lane);
  j.free_axis = vector_at(data.free_axis, lane);
  const bool relaxed = data.softness[lane] > 0 && data.spring[lane] == 0;
  j.softness = relaxed ? 0 : double(data.softness[lane]);
  for (u32 i = 0; i < JOINT_ROWS; ++i) {
    j.bias[i] = double(data.velocity_product[i][lane]) + (relaxed ? 0 : double(data.bias[i][lane]));
    j.impulse[i] = double(impulses.locked[i][lane]);
  }
  j.effective_mobility = double(data.free_mobility[lane]) - double(data.coupled_mobility[lane]) / (1 + j.softness);
  j.impedance_compliance = double(data.impedance_compliance[lane]);
  j.impedance_speed = double(data.impedance_speed[lane]);
  j.impedance_impulse = j.impedance_compliance > 0 ? double(impulses.impedance[lane]) : 0;
  if (j.impedance_compliance > 0)
    j.effective_mobility *= j.impedance_compliance / (j.effective_mobility + j.impedance_compliance);
  j.free_impulse = double(impulses.free[lane]);
  j.motor_speed = double(data.motor_speed[lane]);
  j.motor_impulse = double(data.motor_impulse[lane]);
  j.slowest = double(data.slowest[lane]);
  j.fastest = double(data.fastest[lane]);
  j.bound_softness = double(data.bound_softness[lane]);
  j.spring_compliance = double(data.spring_compliance[lane]);
  if (!relaxed || j.spring_compliance > 0) return j;
  const double still = -double(data.velocity_product[JOINT_ROWS][lane]);
  const bool equal = j.slowest == j.fastest;
  j.slowest = equal ? still : std::min(j.slowest, 0.0);
  j.fastest = equal ? still : std::max(j.fastest, 0.0);
  j.bound_softness = 0;
  return j;
}

// Joints of sleepers are not solved.
template <class real>
bool is_solved(const Buffers<real>& buffers, u32 joint) {
  if (joint == NONE) return false;
  const JointInfo& info = buffers.joint_infos[joint];
  const auto sleeps = [&](u32 body) { return body < buffers.sleepers.size() && is_asleep(buffers.sleepers[body]); };
  return !sleeps(info.body_a) && !sleeps(info.body_b);
}

// Angular velocities as they were solved for: since then they have changed with the gyroscopic moment, and rotated.
template <class real>
void take_solved_rotations(const Buffers<real>& buffers, ContactSystem& system) {
  for (std::size_t i = 0; i < buffers.free_rotations.size(); ++i) {
    const FreeRotation<real>& solved = buffers.free_rotations[i];
    if (solved.slack < real(0)) system.bodies[i].w = {double(solved.w[0]), double(solved.w[1]), double(solved.w[2])};
  }
}

}  // namespace

Eigen::Matrix<double, 3, 2> solver_tangents(const Eigen::Vector3d& n) {
  const double sign = n.z() < 0 ? -1 : 1, a = -1 / (sign + n.z()), b = n.x() * n.y() * a;
  Eigen::Matrix<double, 3, 2> t;
  t << 1 + sign * n.x() * n.x() * a, b, sign * b, sign + n.y() * n.y() * a, -sign * n.x(), -n.y();
  return t;
}

template <class real>
ContactSystem contact_system(const Buffers<real>& buffers, std::span<const u32> counters, Features features) {
  ContactSystem system;
  system.convex = !buffers.gradient_laws.empty();
  system.bodies.reserve(buffers.motions.size());
  for (const Motion<real>& motion : buffers.motions) system.bodies.push_back(system_body(motion));
  const bool is_relaxed = (features & static_cast<Features>(Feature::relaxing)) != 0;
  if (!is_relaxed) take_solved_rotations(buffers, system);

  const u32 count = counters[COUNTER_CONTACTS];
  system.contacts.reserve(count);
  for (u32 i = 0; i < count; ++i) {
    const u32 slot = buffers.contact_slots[i], row = slot / PACK, lane = slot % PACK;
    const ContactBlock<real>& data = buffers.contact_blocks[row];
    const ContactImpulse<real>& stored =
        buffers.cached_impulses[i];  // of the same contact: the lists share their order
    SystemContact c;
    c.contact = i;
    c.body_a = buffers.contacts[i].body_a;
    c.body_b = buffers.contacts[i].body_b;
    c.normal = Eigen::Vector3d(data.normal_x[lane], data.normal_y[lane], data.normal_z[lane]).normalized();
    c.arm_a = {double(data.arm_a_x[lane]), double(data.arm_a_y[lane]), double(data.arm_a_z[lane])};
    c.arm_b = {double(data.arm_b_x[lane]), double(data.arm_b_y[lane]), double(data.arm_b_z[lane])};
    c.bias = relaxed_bias(buffers, row, lane);
    if (!buffers.slide_blocks.empty()) {
      const SlideBlock<real>& slides = buffers.slide_blocks[row];
      c.slide = solver_tangents(c.normal) * Eigen::Vector2d(slides.bias_1[lane], slides.bias_2[lane]);
    }
    c.friction = double(data.friction[lane]);
    c.impulse =
        double(stored.normal) * c.normal + Eigen::Vector3d(stored.tangent_x, stored.tangent_y, stored.tangent_z);
    system.contacts.push_back(c);
    if (!buffers.angular_friction_blocks.empty())
      system.angular_friction.push_back(
          system_angular_friction(buffers.angular_friction_blocks[row], buffers.cached_moments[i], c.normal, lane));
    if (!buffers.ellipse_blocks.empty())
      system.angular_friction.back().stretch = stretch_of(buffers.ellipse_blocks[row], c.normal, lane);
  }
  for (u32 slot = 0; slot < (buffers.patch_blocks.empty() ? 0 : counters[COUNTER_BLOCKS] * PACK); ++slot) {
    if (buffers.block_bodies[slot / PACK].count[slot % PACK] > 0)
      system.patches.push_back(system_patch(buffers, slot / PACK, slot % PACK));
  }
  for (u32 slot = 0; slot < buffers.joint_lanes.size() * PACK; ++slot) {
    if (is_solved(buffers, buffers.joint_lanes[slot / PACK].joint[slot % PACK]))
      system.joints.push_back(system_joint(buffers, slot / PACK, slot % PACK));
  }
  return system;
}

template ContactSystem contact_system(const Buffers<float>&, std::span<const u32>, Features);
template ContactSystem contact_system(const Buffers<double>&, std::span<const u32>, Features);

}  // namespace lockstep
