// Solves the rows of articulations with their factors (cpu_reference/articulations/link.hpp): once up, once down, exact
// to rounding. With w the velocity that the rows are to lose, f what the children ask of a link and what closures push:
//   up     g = S^-1 (-w - j H^-1 f),  the parent is asked for -p^T g
//   down   d = g + S^-1 p (change of the parent),  change = H^-1 (f + j^T d)
//   then every body gets the impulses d of its joint and the opposite of its children's.
// The changes that went down say which impulses are right; bodies are moved by the impulses themselves, so that
// momentum is kept to rounding. A second solve finds what rounding left. Where joints close loops of a tree, the first
// time up and down tells what they push with (cpu_reference/articulations/closures.hpp), the second makes the tree
// answer that. kernels/articulations/solve_links.h is the twin.
#pragma once

#include "cpu_reference/articulations/closures.hpp"
#include "cpu_reference/sleep.hpp"
#include "cpu_reference/solve_contact.hpp"

namespace lockstep::reference {

template <class real>
Twist<real> twist_of(const Motion<real>& body) {
  return {vec3(body.v), vec3(body.w)};
}

/// What its joint, those of its children and closures push a link with, about its centre of mass.
template <class real>
Twist<real> push_on_link(const Buffers<real>& b, u32 index, const LinkInfo& link) {
  const LinkMotion<real>& m = b.link_motions[index];
  Twist<real> push = effort_about(vec3(b.link_factors[index].arm), read_twist(m.effort));
  if (!b.closure_sets.empty()) push = add_twist(push, read_twist(m.push));
  return without_children(b, link, b.link_motions.data(), push);
}

/// What the rows are off by at the present velocities. Returns the square of the relative velocity that goes with it;
/// rotations count as in joint_change (cpu_reference/joints/solve_joint.hpp).
template <class real>
real link_off(const Buffers<real>& b, const LinkInfo& link, const LinkFactor<real>& f, real (&off)[LINK_ROWS]) {
  for (real& row : off) row = 0;
  if (link.joint == NONE) return 0;
  const JointInfo& info = b.joint_infos[link.joint];
  const Motion<real>&body = b.motions[link.body], &other = b.motions[link.is_b != 0 ? info.body_a : info.body_b];
  const Twist<real> u = sub_twist(twist_at(vec3(f.arm), twist_of(body)), twist_at(vec3(f.parent_arm), twist_of(other)));
  link_rows(f, u, off);
  const JointImpulseBlock<real>& impulses = b.joint_impulses[link.slot / PACK];
  const real free = (f.impedance > 0 ? impulses.impedance : impulses.free)[link.slot % PACK];
  const real along = link.is_b != 0 ? free : -free;
  off[JOINT_ROWS] = off[JOINT_ROWS] + f.spring_compliance * along;
  for (u32 i = 0; i < LINK_ROWS; ++i) off[i] = f.mobility[entry_index(i, i)] > 0 ? off[i] + f.error[i] : real(0);
  const Twist<real> change = link_effort(f, off);
  const real trace =
      body.inertia_xx + body.inertia_yy + body.inertia_zz + other.inertia_xx + other.inertia_yy + other.inertia_zz;
  return dot3(change.linear, change.linear) +
         real(3) * (body.inverse_mass + other.inverse_mass) / trace * dot3(change.angular, change.angular);
}

/// The impulses of the rows of a joint.
template <class real>
void add_impulses(Buffers<real>& b, const LinkFactor<real>& f, u32 slot, bool is_b, const real (&d)[LINK_ROWS]) {
  JointImpulseBlock<real>& impulses = b.joint_impulses[slot / PACK];
  const u32 lane = slot % PACK;
  const real sign = is_b ? real(1) : real(-1);
  for (u32 row = 0; row < JOINT_ROWS; ++row) impulses.locked[row][lane] = impulses.locked[row][lane] + sign * d[row];
  real& free = (f.impedance > 0 ? impulses.impedance : impulses.free)[lane];
  free = free + sign * d[JOINT_ROWS];
}

/// Once up, once down: the changes of the links, whose impulses are kept `last`. Returns the square of the largest
/// change of a relative velocity.
template <class real>
real solve_link_velocities(Buffers<real>& b, const Articulation& tree, bool last) {
  real change = 0;
  for_each_link_up(b, tree, [&](u32 i, const LinkInfo& link) {
    real off[LINK_ROWS];
    change = larger(link_off(b, link, b.link_factors[i], off), change);
    backward_pass(b, i, off, b.link_motions.data());
  });
  for_each_link_down(b, tree, [&](u32 i, const LinkInfo& link) {
    real d[LINK_ROWS];
    forward_pass(b, i, b.link_motions.data(), d);
    if (last && link.joint != NONE) add_impulses(b, b.link_factors[i], link.slot, link.is_b != 0, d);
  });
  return change;
}

/// Returns the square of the largest change of a relative velocity.
template <class real>
real solve_articulation(Buffers<real>& b, u32 index) {
  const Articulation& tree = b.articulations[index];
  const ClosureSet loops = closures_of(b, index);
  clear_pushes(b, loops, b.link_motions.data());
  real change = solve_link_velocities(b, tree, loops.count == 0);
  if (loops.count > 0) {
    for_each_closure(b, loops, [&](u32 k, const ClosureInfo& closure) {
      real off[LINK_ROWS];
      change = larger(link_off(b, as_link(b, closure), b.closure_factors[k], off), change);
      want_closed(b, k, off);
    });
    solve_closures(b, loops);
    for_each_closure(b, loops, [&](u32 k, const ClosureInfo& closure) {
      real d[LINK_ROWS];
      for (u32 row = 0; row < LINK_ROWS; ++row) d[row] = b.closure_wanted[k * LINK_ROWS + row];
      add_impulses(b, b.closure_factors[k], closure.slot, true, d);
    });
    solve_link_velocities(b, tree, true);
  }
  for_each_link_down(b, tree, [&](u32 i, const LinkInfo& link) {
    Motion<real>& body = b.motions[link.body];
    const Twist<real> push = push_on_link(b, i, link);
    store3(body.v, add3(vec3(body.v), scale3(body.inverse_mass, push.linear)));
    store3(body.w, add3(vec3(body.w), apply_inverse_inertia(body, push.angular)));
  });
  return change;
}

/// All articulations that are awake.
template <class real>
real solve_articulations(Buffers<real>& b) {
  real change = 0;
  for (u32 tree = 0; tree < b.articulations.size(); ++tree) {
    if (!is_asleep(b, b.articulations[tree].root)) change = larger(solve_articulation(b, tree), change);
  }
  return change;
}

}  // namespace lockstep::reference
