// Solves the rows of articulations with their factors (cpu_reference/articulations/link.hpp): once up, once down, exact
// to rounding. With w the velocity that the rows are to lose, f what the children ask of a link:
//   up     g = S^-1 (-w - j H^-1 f),  the parent is asked for -p^T g
//   down   d = g + S^-1 p (change of the parent),  change = H^-1 (f + j^T d)
//   then every body gets the impulses d of its joint and the opposite of its children's.
// The changes that went down say which impulses are right; bodies are moved by the impulses themselves, so that
// momentum is kept to rounding. A second solve finds what rounding left. kernels/articulations/solve_links.h is the
// twin.
#pragma once

#include "cpu_reference/articulations/link.hpp"
#include "cpu_reference/sleep.hpp"
#include "cpu_reference/visit_contact.hpp"

namespace lockstep::reference {

template <class real>
Twist<real> twist_of(const Motion<real>& body) {
  return {vec3(body.v), vec3(body.w)};
}

template <class real>
void solve_mobility(const LinkFactor<real>& f, real (&r)[LINK_ROWS]) {
  u32 count = LINK_ROWS;
  while (count > 0 && !(f.mobility[entry_index(count - 1, count - 1)] > 0)) r[--count] = 0;
  solve_rows(count, f.mobility, r);
}

/// Takes away what the joints of a link's children push them with, about the link's centre of mass.
template <class real>
Twist<real> without_children(const Buffers<real>& b, const LinkInfo& link, Twist<real> push) {
  for (u32 child = link.first_child; child < link.first_child + link.child_count; ++child) {
    const Twist<real> effort = read_twist(b.link_motions[child].effort);
    push = sub_twist(push, effort_about(vec3(b.link_factors[child].parent_arm), effort));
  }
  return push;
}

/// Upwards. `off`: the velocities, or distances, that the rows are to lose, link against parent.
template <class real>
void ask_parent(const Buffers<real>& b, const LinkInfo& link, const LinkFactor<real>& f, const real (&off)[LINK_ROWS],
                LinkMotion<real>& m) {
  const Twist<real> force = without_children(b, link, Twist<real>{});
  write_twist(force, m.force);
  real change[6], answer[LINK_ROWS];
  write_twist(force, change);
  solve_rows(6, f.inertia, change);
  link_rows(f, twist_at(vec3(f.arm), read_twist(change)), answer);
  for (u32 i = 0; i < LINK_ROWS; ++i) {
    m.wanted[i] = -(off[i] + answer[i]);
    answer[i] = m.wanted[i];
  }
  solve_mobility(f, answer);
  write_twist(link_effort(f, answer), m.effort);
}

/// Downwards. Returns the impulses of the rows.
template <class real>
void answer_parent(const Buffers<real>& b, const LinkInfo& link, const LinkFactor<real>& f, LinkMotion<real>& m,
                   real (&d)[LINK_ROWS]) {
  Twist<real> parent = {};
  if (link.parent != NONE) parent = read_twist(b.link_motions[link.parent].change);
  link_rows(f, twist_at(vec3(f.parent_arm), parent), d);
  for (u32 i = 0; i < LINK_ROWS; ++i) d[i] = m.wanted[i] + d[i];
  solve_mobility(f, d);
  const Twist<real> effort = link_effort(f, d);
  write_twist(effort, m.effort);
  write_twist(add_twist(read_twist(m.force), effort_about(vec3(f.arm), effort)), m.change);
  solve_rows(6, f.inertia, m.change);
}

/// What its joint and those of its children push a link with, about its centre of mass.
template <class real>
Twist<real> push_on_link(const Buffers<real>& b, u32 index, const LinkInfo& link) {
  const Twist<real> effort = read_twist(b.link_motions[index].effort);
  return without_children(b, link, effort_about(vec3(b.link_factors[index].arm), effort));
}

/// What the rows are off by at the present velocities. Returns the square of the relative velocity that goes with it;
/// turns count as in joint_change (cpu_reference/joints/visit_joint.hpp).
template <class real>
real link_off(const Buffers<real>& b, const LinkInfo& link, const LinkFactor<real>& f, real (&off)[LINK_ROWS]) {
  for (real& row : off) row = 0;
  if (link.joint == NONE) return 0;
  const JointInfo& info = b.joint_infos[link.joint];
  const Motion<real>&body = b.motions[link.body], &other = b.motions[link.is_b != 0 ? info.body_a : info.body_b];
  const Twist<real> u = sub_twist(twist_at(vec3(f.arm), twist_of(body)), twist_at(vec3(f.parent_arm), twist_of(other)));
  link_rows(f, u, off);
  const real free = b.joint_impulses[link.slot / PACK].free[link.slot % PACK];
  const real along = link.is_b != 0 ? free : -free;
  off[JOINT_ROWS] = off[JOINT_ROWS] + f.yield * along;
  for (u32 i = 0; i < LINK_ROWS; ++i) off[i] = f.mobility[entry_index(i, i)] > 0 ? off[i] + f.error[i] : real(0);
  const Twist<real> change = link_effort(f, off);
  const real trace =
      body.inertia_xx + body.inertia_yy + body.inertia_zz + other.inertia_xx + other.inertia_yy + other.inertia_zz;
  return dot3(change.linear, change.linear) +
         real(3) * (body.inverse_mass + other.inverse_mass) / trace * dot3(change.angular, change.angular);
}

/// Returns the square of the largest change of a relative velocity.
template <class real>
real solve_articulation(Buffers<real>& b, const Articulation& tree) {
  real change = 0;
  for_each_link_up(b, tree, [&](u32 i, const LinkInfo& link) {
    real off[LINK_ROWS];
    change = larger(link_off(b, link, b.link_factors[i], off), change);
    ask_parent(b, link, b.link_factors[i], off, b.link_motions[i]);
  });
  for_each_link_down(b, tree, [&](u32 i, const LinkInfo& link) {
    real d[LINK_ROWS];
    answer_parent(b, link, b.link_factors[i], b.link_motions[i], d);
    if (link.joint == NONE) return;
    JointImpulseBlock<real>& impulses = b.joint_impulses[link.slot / PACK];
    const u32 lane = link.slot % PACK;
    const real sign = link.is_b != 0 ? real(1) : real(-1);
    for (u32 row = 0; row < JOINT_ROWS; ++row) impulses.locked[row][lane] = impulses.locked[row][lane] + sign * d[row];
    impulses.free[lane] = impulses.free[lane] + sign * d[JOINT_ROWS];
  });
  for_each_link_down(b, tree, [&](u32 i, const LinkInfo& link) {
    Motion<real>& body = b.motions[link.body];
    const Twist<real> push = push_on_link(b, i, link);
    store3(body.v, add3(vec3(body.v), scale3(body.inverse_mass, push.linear)));
    store3(body.w, add3(vec3(body.w), turn_by(body, push.angular)));
  });
  return change;
}

/// All articulations that are awake.
template <class real>
real solve_articulations(Buffers<real>& b) {
  real change = 0;
  for (const Articulation& tree : b.articulations) {
    if (!is_asleep(b, tree.root)) change = larger(solve_articulation(b, tree), change);
  }
  return change;
}

}  // namespace lockstep::reference
