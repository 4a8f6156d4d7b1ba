// How the links of an articulation answer, with its factors. cpu_reference/articulations/tree_passes.hpp is the twin.
#ifndef LOCKSTEP_ARTICULATION_TREE_PASSES_H
#define LOCKSTEP_ARTICULATION_TREE_PASSES_H

#include "articulations/link.h"

static inline void solve_mobility(global const LinkFactor* f, real* r) {
  u32 count = LINK_ROWS;
  while (count > 0u && !(f->mobility[ENTRY_INDEX(count - 1u, count - 1u)] > (real)0)) r[--count] = (real)0;
  solve_rows(count, f->mobility, r);
}

static inline Twist without_children(LinkInfo link, global const LinkFactor* link_factors,
                                     global const LinkMotion* link_motions, Twist push) {
  for (u32 child = link.first_child; child < link.first_child + link.child_count; ++child) {
    const Twist effort = read_twist(link_motions[child].effort);
    push = sub_twist(push, effort_about(global_vec3(link_factors[child].parent_arm), effort));
  }
  return push;
}

static inline void backward_pass(u32 index, LinkInfo link, const real* off, global const LinkFactor* link_factors,
                                 global LinkMotion* link_motions) {
  global const LinkFactor* f = link_factors + index;
  global LinkMotion* m = link_motions + index;
#if FEATURE_CLOSURES
  const Twist push = read_twist(m->push);
#else
  const Twist push = no_twist();
#endif
  const Twist force = without_children(link, link_factors, link_motions, push);
  write_twist(force, m->force);
  real change[6], response[LINK_ROWS];
  spread_twist(force, change);
  solve_rows(6u, f->inertia, change);
  link_rows(f, twist_at(global_vec3(f->arm), make_twist(vec3(change), vec3(change + 3))), response);
  for (u32 i = 0u; i < LINK_ROWS; ++i) {
    response[i] = -(off[i] + response[i]);
    m->wanted[i] = response[i];
  }
  solve_mobility(f, response);
  write_twist(link_effort(f, response), m->effort);
}

static inline void forward_pass(u32 index, LinkInfo link, global const LinkFactor* link_factors,
                                global LinkMotion* link_motions, real* d) {
  global const LinkFactor* f = link_factors + index;
  global LinkMotion* m = link_motions + index;
  const Twist parent = link.parent != NONE ? read_twist(link_motions[link.parent].change) : no_twist();
  link_rows(f, twist_at(global_vec3(f->parent_arm), parent), d);
  for (u32 i = 0u; i < LINK_ROWS; ++i) d[i] = m->wanted[i] + d[i];
  solve_mobility(f, d);
  const Twist effort = link_effort(f, d);
  write_twist(effort, m->effort);
  real change[6];
  spread_twist(add_twist(read_twist(m->force), effort_about(global_vec3(f->arm), effort)), change);
  solve_rows(6u, f->inertia, change);
  for (u32 k = 0u; k < 6u; ++k) m->change[k] = change[k];
}

#endif
