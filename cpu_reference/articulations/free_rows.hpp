// Motors and limits of joints whose articulation solves the locked rows take turns with it: a sweep pushes along the
// free coordinate, then the tree answers. A joint alone is far more mobile than the tree lets it be, a light arm that
// holds a heavy end by a thousand times, and each turn finds but that share of the impulse. So where a free row is to
// push it counts with the mobility that the tree leaves it: what a unit of its impulse moves it by, once up and once
// down. All of them push before the tree answers, so that each counts with that of all, k times its own, which is less
// than it has at most, but never with more than it has alone. Trees with more than most_free_rows of them are left.
// kernels/articulations/free_rows.h is the twin.
#pragma once

#include "cpu_reference/articulations/tree_passes.hpp"
#include "cpu_reference/joints/solve_joint.hpp"

namespace lockstep::reference {

constexpr u32 most_free_rows = 16;

/// Whether the free row of the joint of a link is to push in a sweep, by the velocities at the start of the sub-step:
/// a motor, or a limit that it comes to or has pushed at.
template <class real>
bool is_to_push(const Buffers<real>& b, u32 index) {
  const LinkInfo& link = b.links[index];
  if (link.joint == NONE) return false;
  const JointBlock<real>& block = b.joint_blocks[link.slot / PACK];
  const u32 lane = link.slot % PACK;
  const JointInfo& info = b.joint_infos[link.joint];
  const real slowest = block.slowest[lane], fastest = block.fastest[lane];
  if (info.free == FREE_NOTHING || slowest == fastest || has_impedance(block, lane)) return false;
  if (block.motor_impulse[lane] > 0 || b.joint_impulses[link.slot / PACK].free[lane] != 0) return true;
  const LinkFactor<real>& f = b.link_factors[index];
  const Motion<real>&body = b.motions[link.body], &other = b.motions[link.is_b != 0 ? info.body_a : info.body_b];
  real rows[LINK_ROWS];
  link_rows(f, sub_twist(twist_at(vec3(f.arm), twist_of(body)), twist_at(vec3(f.parent_arm), twist_of(other))), rows);
  const real along = link.is_b != 0 ? rows[JOINT_ROWS] : -rows[JOINT_ROWS];
  return along < slowest || along > fastest;
}

/// What a unit of the free row of a link moves it by, all locked rows of the tree kept.
template <class real>
real mobility_in_tree(Buffers<real>& b, const Articulation& tree, u32 index) {
  const LinkInfo& link = b.links[index];
  const LinkFactor<real>& f = b.link_factors[index];
  LinkMotion<real>* const motions = b.link_motions.data();
  const Twist<real> effort = row_effort(f, JOINT_ROWS);
  const auto push = [&](u32 at, Twist<real> by) {
    if (at != NONE) write_twist(by, motions[at].push);
  };
  push(index, effort_about(vec3(f.arm), effort));
  push(link.parent, sub_twist(Twist<real>{}, effort_about(vec3(f.parent_arm), effort)));
  real d[LINK_ROWS];
  const real nothing[LINK_ROWS] = {};
  for_each_link_up(b, tree, [&](u32 i, const LinkInfo&) { backward_pass(b, i, nothing, motions); });
  for_each_link_down(b, tree, [&](u32 i, const LinkInfo&) { forward_pass(b, i, motions, d); });
  push(index, {});
  push(link.parent, {});
  Twist<real> parent = {};
  if (link.parent != NONE) parent = read_twist(motions[link.parent].change);
  const Twist<real> own = read_twist(motions[index].change);
  link_rows(f, sub_twist(twist_at(vec3(f.arm), own), twist_at(vec3(f.parent_arm), parent)), d);
  return d[JOINT_ROWS];
}

/// Gives the free rows that are to push their mobility in the tree.
template <class real>
void write_free_rows(Buffers<real>& b, const Articulation& tree) {
  real count = 0;
  for_each_link_down(b, tree, [&](u32 i, const LinkInfo&) { count = count + (is_to_push(b, i) ? real(1) : real(0)); });
  if (count > real(most_free_rows)) return;
  for_each_link_down(b, tree, [&](u32 i, const LinkInfo& link) {
    if (!is_to_push(b, i)) return;
    const real mobility = count * mobility_in_tree(b, tree, i);
    JointBlock<real>& block = b.joint_blocks[link.slot / PACK];
    const u32 lane = link.slot % PACK;
    if (!(mobility > 0) || mobility > block.free_mobility[lane] - block.coupled_mobility[lane]) return;
    block.free_mobility[lane] = mobility;
    block.coupled_mobility[lane] = 0;
  });
}

}  // namespace lockstep::reference
