// Closes the joints of articulations by the poses of their bodies, all at once: one step of Newton's method, with what
// is off instead of velocities (cpu_reference/close_joints.hpp). Where it would turn a body by more than a tenth of a
// radian the tree goes that share of the way: what is far open, as joints are where links turn by a radian in a step,
// is not told by its slope. kernels/articulations/close_links.h is the twin.
#pragma once

#include <algorithm>
#include <bit>

#include "cpu_reference/articulations/solve_links.hpp"
#include "cpu_reference/joints/current_joint.hpp"
#include "cpu_reference/joints/displace.hpp"
#include "cpu_reference/joints/revolutions.hpp"

namespace lockstep::reference {

/// The joint of a link at the present poses. Returns the rows that are closed: springs are not, and limits that are
/// apart are for sweeps.
template <class real>
u32 write_current_link_joint(const Buffers<real>& b, const StepParams<real>& params, const LinkInfo& link,
                             LinkFactor<real>& f) {
  const JointInfo& info = b.joint_infos[link.joint];
  const Joint<real>& joint = b.joints[link.joint];
  Vec3<real> x_a, x_b;
  Quat<real> q_a, q_b;
  joint_pose(b, params, info.body_a, x_a, q_a);
  joint_pose(b, params, info.body_b, x_b, q_b);
  CurrentJoint<real> current = current_joint(joint, info, joint_sizes(b, link.joint), x_a, q_a, x_b, q_b);
  count_revolutions(b, params, link.joint, current);
  const bool rod =
      info.free != FREE_NOTHING && joint.limited != 0 && joint.low == joint.high && !(joint.spring_compliance > 0);
  const real sign = link.is_b != 0 ? real(1) : real(-1);
  set_link_joint(link, info.free == FREE_ANGLE, current.axes, current.arm_a, current.arm_b, current.free_axis,
                 current.lead, f);
  f.spring_compliance = 0;
  for (u32 i = 0; i < JOINT_ROWS; ++i) f.error[i] = (info.locked >> i & 1) != 0 ? sign * current.error[i] : real(0);
  f.error[JOINT_ROWS] = rod ? sign * (current.coordinate - joint.low) : real(0);
  return info.locked | (rod ? 1u << JOINT_ROWS : 0u);
}

/// Once up, once down: how the links are to move.
template <class real>
void solve_link_errors(Buffers<real>& b, const Articulation& tree) {
  for_each_link_up(
      b, tree, [&](u32 i, const LinkInfo&) { backward_pass(b, i, b.link_factors[i].error, b.link_motions.data()); });
  for_each_link_down(b, tree, [&](u32 i, const LinkInfo&) {
    real d[LINK_ROWS];
    forward_pass(b, i, b.link_motions.data(), d);
  });
}

template <class real>
void close_articulation(Buffers<real>& b, const StepParams<real>& params, u32 index,
                        std::vector<LinkMotion<real>>& columns) {
  const Articulation& tree = b.articulations[index];
  const ClosureSet loops = closures_of(b, index);
  for_each_link_up(b, tree, [&](u32 i, const LinkInfo& link) {
    LinkFactor<real>& f = b.link_factors[i];
    // one that floats has no rows, since it was factorised first
    const u32 rows = link.joint == NONE ? 0 : write_current_link_joint(b, params, link, f);
    factorise_link(b, link, rows, f);
  });
  for_each_closure(b, loops, [&](u32 k, const ClosureInfo& closure) {
    LinkFactor<real>& f = b.closure_factors[k];
    mark_rows(write_current_link_joint(b, params, as_link(b, closure), f), f);
  });
  factor_closures(b, tree, loops, columns);
  clear_pushes(b, loops, b.link_motions.data());
  solve_link_errors(b, tree);
  if (loops.count > 0) {
    for_each_closure(b, loops, [&](u32 k, const ClosureInfo&) { want_closed(b, k, b.closure_factors[k].error); });
    solve_closures(b, loops);
    solve_link_errors(b, tree);
  }
  u32 angle_word = 0;  // the largest, as the word of a float: those that are not negative are in order
  for_each_link_down(b, tree, [&](u32 i, const LinkInfo&) {
    const real own = length3(read_twist(b.link_motions[i].change).angular);
    angle_word = std::max(angle_word, std::bit_cast<u32>(static_cast<float>(own)));
  });
  const real most = real(0.1), largest = real(std::bit_cast<float>(angle_word));
  const real share = largest > most ? most / largest : real(1);
  for_each_link_down(b, tree, [&](u32 i, const LinkInfo& link) {
    const Twist<real> push = push_on_link(b, i, link);
    displace(b, params, link.body, vec3_of(b.positions[link.body]), quat(b.orientations[link.body]),
             scale3(share, push.linear), scale3(share, push.angular));
  });
}

/// All articulations that are awake.
template <class real>
void close_articulations(Buffers<real>& b, const StepParams<real>& params) {
  std::vector<LinkMotion<real>> columns = room_for_columns(b);
  for (u32 tree = 0; tree < b.articulations.size(); ++tree) {
    if (!is_asleep(b, b.articulations[tree].root)) close_articulation(b, params, tree, columns);
  }
}

}  // namespace lockstep::reference
