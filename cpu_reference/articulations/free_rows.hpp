// Motors and limits of joints whose articulation solves the locked rows take turns with it: a sweep pushes along the
// free coordinate, then the tree answers. A joint alone is far more mobile than the tree lets it be, a light arm that
// holds a heavy end by a thousand times, and each turn finds but that share of the impulse. So where a free row is to
// push it counts with the mobility that the tree leaves it: what a unit of its impulse moves it by, once up and once
// down. All of them push before the tree answers, so that each counts with that of all, k times its own, which is less
// than it has at most, but never with more than it has alone. Trees with more than MOST_FREE_ROWS of them are left.
// kernels/articulations/free_rows.h is the twin.
#pragma once

#include "cpu_reference/articulations/tree_passes.hpp"
#include "cpu_reference/joints/solve_joint.hpp"

namespace lockstep::reference {

/// Whether the free row of the joint of a link is to push in a sweep, by the velocities at the start of the sub-step:
/// a motor, or a limit that it comes to or has pushed at.
template <class real>
bool is_to_push(const Buffers<real>& b, const LinkInfo& link) {
  if (link.joint == NONE) return false;
  const JointBlock<real>& block = b.joint_blocks[link.slot / PACK];
  const u32 lane = link.slot % PACK;
  const JointInfo& info = b.joint_infos[link.joint];
  const real slowest = block.slowest[lane], fastest = block.fastest[lane];
  if (info.free == FREE_NOTHING || slowest == fastest || has_impedance(block, lane)) return false;
  if (block.motor_impulse[lane] > 0 || b.joint_impulses[link.slot / PACK].free[lane] != 0) return true;
  const Motion<real>&body_a = b.motions[info.body_a], &body_b = b.motions[info.body_b];
  const Vec3<real> u = velocity_at(joint_vector(block.arm_b, lane), joint_vector(block.arm_a, lane), body_b, body_a);
  const Vec3<real> w = sub3(vec3(body_b.w), vec3(body_a.w));
  const real along = dot3(joint_vector(block.free_axis, lane), info.free == FREE_ANGLE ? w : u);
  return along < slowest || along > fastest;
}

/// What a unit of the free row of a link moves it by, all locked rows of the tree kept.
template <class real>
real mobility_in_tree(Buffers<real>& b, const Articulation& tree, u32 index) {
  const LinkInfo& link = b.links[index];
  const LinkFactor<real>& f = b.link_factors[index];
  const Twist<real> effort = row_effort(f, JOINT_ROWS);
  const real nothing[LINK_ROWS] = {};
  for_each_link_down(b, tree, [&](u32 i, const LinkInfo&) { b.link_motions[i] = {}; });
  write_twist(effort_about(vec3(f.arm), effort), b.link_motions[index].push);
  if (link.parent != NONE)
    write_twist(sub_twist(Twist<real>{}, effort_about(vec3(f.parent_arm), effort)), b.link_motions[link.parent].push);
  for_each_link_up(b, tree, [&](u32 i, const LinkInfo&) { backward_pass(b, i, nothing, b.link_motions.data()); });
  for_each_link_down(b, tree, [&](u32 i, const LinkInfo&) {
    real d[LINK_ROWS];
    forward_pass(b, i, b.link_motions.data(), d);
  });
  Twist<real> parent = {};
  if (link.parent != NONE) parent = read_twist(b.link_motions[link.parent].change);
  real rows[LINK_ROWS];
  link_rows(f, sub_twist(twist_at(vec3(f.arm), read_twist(b.link_motions[index].change)), twist_at(vec3(f.parent_arm), parent)), rows);
  return rows[JOINT_ROWS];
}

/// Gives the free rows that are to push their mobility in the tree.
template <class real>
void write_free_rows(Buffers<real>& b, const Articulation& tree) {
  u32 count = 0;
  for_each_link_down(b, tree, [&](u32, const LinkInfo& link) { count += is_to_push(b, link) ? 1u : 0u; });
  if (count == 0 || count > 16) return;
  std::vector<std::pair<u32, real>> mobilities;
  for_each_link_down(b, tree, [&](u32 i, const LinkInfo& link) {
    if (is_to_push(b, link)) mobilities.push_back({i, real(count) * mobility_in_tree(b, tree, i)});
  });
  for (const auto& [i, mobility] : mobilities) {
    const LinkInfo& link = b.links[i];
    JointBlock<real>& block = b.joint_blocks[link.slot / PACK];
    const u32 lane = link.slot % PACK;
    if (!(mobility > 0) || mobility > block.free_mobility[lane] - block.coupled_mobility[lane]) continue;
    block.free_mobility[lane] = mobility;
    block.coupled_mobility[lane] = 0;
  }
  for_each_link_down(b, tree, [&](u32 i, const LinkInfo&) { b.link_motions[i] = {}; });
}

}  // namespace lockstep::reference
