// How the links of an articulation answer, with its factors: upwards what each asks of its parent, downwards how it
// moves. cpu_reference/articulations/solve_links.hpp has the equations; kernels/articulations/tree_passes.h is the
// twin.
#pragma once

#include "cpu_reference/articulations/link.hpp"

namespace lockstep::reference {

template <class real>
void solve_mobility(const LinkFactor<real>& f, real (&r)[LINK_ROWS]) {
  u32 count = LINK_ROWS;
  while (count > 0 && !(f.mobility[entry_index(count - 1, count - 1)] > 0)) r[--count] = 0;
  solve_rows(count, f.mobility, r);
}

/// Takes away what the joints of a link's children push them with, about the link's centre of mass.
template <class real>
Twist<real> without_children(const Buffers<real>& b, const LinkInfo& link, const LinkMotion<real>* motions,
                             Twist<real> push) {
  for (u32 child = link.first_child; child < link.first_child + link.child_count; ++child) {
    const Twist<real> effort = read_twist(motions[child].effort);
    push = sub_twist(push, effort_about(vec3(b.link_factors[child].parent_arm), effort));
  }
  return push;
}

/// Upwards, of one link. `off`: the velocities, or distances, that its rows are to lose, link against parent;
/// `motions`: of the links, which closures push already.
template <class real>
void backward_pass(const Buffers<real>& b, u32 index, const real (&off)[LINK_ROWS], LinkMotion<real>* motions) {
  const LinkFactor<real>& f = b.link_factors[index];
  LinkMotion<real>& m = motions[index];
  const Twist<real> force = without_children(b, b.links[index], motions, read_twist(m.push));
  write_twist(force, m.force);
  real change[6], response[LINK_ROWS];
  write_twist(force, change);
  solve_rows(6, f.inertia, change);
  link_rows(f, twist_at(vec3(f.arm), read_twist(change)), response);
  for (u32 i = 0; i < LINK_ROWS; ++i) {
    m.wanted[i] = -(off[i] + response[i]);
    response[i] = m.wanted[i];
  }
  solve_mobility(f, response);
  write_twist(link_effort(f, response), m.effort);
}

/// Downwards, of one link: its change, and the impulses of its rows.
template <class real>
void forward_pass(const Buffers<real>& b, u32 index, LinkMotion<real>* motions, real (&d)[LINK_ROWS]) {
  const LinkFactor<real>& f = b.link_factors[index];
  LinkMotion<real>& m = motions[index];
  const u32 above = b.links[index].parent;
  Twist<real> parent = {};
  if (above != NONE) parent = read_twist(motions[above].change);
  link_rows(f, twist_at(vec3(f.parent_arm), parent), d);
  for (u32 i = 0; i < LINK_ROWS; ++i) d[i] = m.wanted[i] + d[i];
  solve_mobility(f, d);
  const Twist<real> effort = link_effort(f, d);
  write_twist(effort, m.effort);
  write_twist(add_twist(read_twist(m.force), effort_about(vec3(f.arm), effort)), m.change);
  solve_rows(6, f.inertia, m.change);
}

}  // namespace lockstep::reference
