// Solves the rows of articulations with their factors, once up and once down; twice where joints close loops.
// cpu_reference/articulations/solve_links.hpp is the twin and says more.
#ifndef LOCKSTEP_ARTICULATION_SOLVE_LINKS_H
#define LOCKSTEP_ARTICULATION_SOLVE_LINKS_H

#include "articulations/closures.h"
#include "sleep.h"
#include "sweep_change.h"

static inline Twist push_on_link(u32 index, LinkInfo link, global const LinkFactor* link_factors,
                                 global const LinkMotion* link_motions) {
  Twist push = effort_about(global_vec3(link_factors[index].arm), read_twist(link_motions[index].effort));
#if FEATURE_CLOSURES
  push = add_twist(push, read_twist(link_motions[index].push));
#endif
  return without_children(link, link_factors, link_motions, push);
}

// All that a solve reads and writes.
typedef struct Articulations {
  global const Articulation* trees;
  global const LinkInfo* links;
  global const u32* levels;
  global const LinkFactor* factors;
  global const JointInfo* joint_infos;
  global const Sleeper* sleepers;
  global LinkMotion* link_motions;
  global JointImpulseBlock* joint_impulses;
  global Motion* motions;
  global u32* counters;
  Closures loops;
} Articulations;

// Of the parameters of a kernel.
#define ARTICULATIONS                                                                                              \
  {                                                                                                                \
    articulations, links, link_levels, link_factors, joint_infos, sleepers, link_motions, joint_impulses, motions, \
        counters, CLOSURES                                                                                         \
  }

// Which of its impulses the free row of a link has.
static inline global real* free_row_impulses(global const LinkFactor* f, global JointImpulseBlock* impulses) {
#if FEATURE_JOINT_IMPEDANCES
  if (f->impedance > (real)0) return impulses->impedance;
#endif
  return impulses->free;
}

static inline void link_off(LinkInfo link, const Articulations* s, global const LinkFactor* f, real* off) {
  for (u32 i = 0u; i < LINK_ROWS; ++i) off[i] = (real)0;
  if (link.joint == NONE) return;
  const JointInfo info = s->joint_infos[link.joint];
  const Motion body = s->motions[link.body], other = s->motions[link.is_b != 0u ? info.body_a : info.body_b];
  const Twist u = sub_twist(twist_at(global_vec3(f->arm), make_twist(vec3(body.v), vec3(body.w))),
                            twist_at(global_vec3(f->parent_arm), make_twist(vec3(other.v), vec3(other.w))));
  link_rows(f, u, off);
  const real free = free_row_impulses(f, s->joint_impulses + link.slot / PACK)[link.slot % PACK];
  const real along = link.is_b != 0u ? free : -free;
  off[JOINT_ROWS] = off[JOINT_ROWS] + f->spring_compliance * along;
  for (u32 i = 0u; i < LINK_ROWS; ++i)
    off[i] = f->mobility[ENTRY_INDEX(i, i)] > (real)0 ? off[i] + f->error[i] : (real)0;
#if FEATURE_TOLERANCE
  const Twist change = link_effort(f, off);
  const real trace =
      body.inertia_xx + body.inertia_yy + body.inertia_zz + other.inertia_xx + other.inertia_yy + other.inertia_zz;
  const real squared = dot3(change.linear, change.linear) + (real)3 * (body.inverse_mass + other.inverse_mass) / trace *
                                                                dot3(change.angular, change.angular);
  note_change((lane)squared, s->counters);
#endif
}

static inline void link_up(u32 index, const Articulations* s) {
  const LinkInfo link = s->links[index];
  real off[LINK_ROWS];
  link_off(link, s, s->factors + index, off);
  backward_pass(index, link, off, s->factors, s->link_motions);
}

static inline void add_impulses(global const LinkFactor* f, u32 slot, bool is_b, const real* d,
                                global JointImpulseBlock* joint_impulses) {
  global JointImpulseBlock* impulses = joint_impulses + slot / PACK;
  const u32 lane_index = slot % PACK;
  const real sign = is_b ? (real)1 : (real)-1;
  for (u32 row = 0u; row < JOINT_ROWS; ++row)
    impulses->locked[row][lane_index] = impulses->locked[row][lane_index] + sign * d[row];
  global real* free = free_row_impulses(f, impulses);
  free[lane_index] = free[lane_index] + sign * d[JOINT_ROWS];
}

// Impulses are kept the last time.
static inline void link_down(u32 index, bool last, const Articulations* s) {
  const LinkInfo link = s->links[index];
  real d[LINK_ROWS];
  forward_pass(index, link, s->factors, s->link_motions, d);
  if (last && link.joint != NONE) add_impulses(s->factors + index, link.slot, link.is_b != 0u, d, s->joint_impulses);
}

#if FEATURE_CLOSURES
// A group: what the loops of a tree push with, once it has answered what is off in it.
static inline void solve_loops(ClosureSet loops, const Articulations* s) {
  for (u32 k = loops.first + (u32)get_local_id(0); k < loops.first + loops.count; k += (u32)get_local_size(0)) {
    real off[LINK_ROWS];
    link_off(as_link(s->loops.closures[k], s->joint_infos), s, s->loops.factors + k, off);
    want_closed(k, off, &s->loops, s->link_motions);
  }
  barrier(CLK_GLOBAL_MEM_FENCE);
  solve_closures(loops, &s->loops, s->link_motions);
  for (u32 k = loops.first + (u32)get_local_id(0); k < loops.first + loops.count; k += (u32)get_local_size(0)) {
    real d[LINK_ROWS];
    for (u32 row = 0u; row < LINK_ROWS; ++row) d[row] = s->loops.wanted[k * LINK_ROWS + row];
    add_impulses(s->loops.factors + k, s->loops.closures[k].slot, true, d, s->joint_impulses);
  }
}
#endif

static inline void link_push(u32 index, const Articulations* s) {
  const LinkInfo link = s->links[index];
  const Twist push = push_on_link(index, link, s->factors, s->link_motions);
  Motion body = s->motions[link.body];
  store3(body.v, add3(vec3(body.v), scale3(body.inverse_mass, push.linear)));
  store3(body.w, add3(vec3(body.w), apply_inverse_inertia(body, push.angular)));
  s->motions[link.body] = body;
}

// A work-group has an articulation for itself, and every n-th behind it. At least one round in each loop, as in all
// with a barrier.
static inline void solve_articulation_groups(u32 count, const Articulations* s) {
  u32 tree = (u32)get_group_id(0);
  do {
    const bool is_there = tree < count && !SWEEP_SKIPPED(s->counters) && !is_asleep(s->sleepers, s->trees[tree].root);
    const u32 first = is_there ? s->trees[tree].first_level : 0u, levels = is_there ? s->trees[tree].level_count : 0u;
    const ClosureSet loops = closures_of(tree, is_there, &s->loops);
    clear_pushes(loops, &s->loops, s->link_motions);
    const u32 passes = loops.count > 0u ? 2u : 1u;
    u32 pass = 0u;
    do {
      const bool last = pass + 1u == passes;
      u32 step = 0u;
      do {  // from the leaves to the root
        const LinkRange at = links_up(first, levels, step, s->levels);
        for (u32 i = at.begin + (u32)get_local_id(0); i < at.end; i += (u32)get_local_size(0)) link_up(i, s);
        barrier(CLK_GLOBAL_MEM_FENCE);
      } while (++step < levels);
      step = 0u;
      do {
        const LinkRange at = links_down(first, levels, step, s->levels);
        for (u32 i = at.begin + (u32)get_local_id(0); i < at.end; i += (u32)get_local_size(0)) link_down(i, last, s);
        barrier(CLK_GLOBAL_MEM_FENCE);
      } while (++step < levels);
#if FEATURE_CLOSURES
      solve_loops(last ? no_closures() : loops, s);
#endif
    } while (++pass < passes);
    const u32 begin = s->levels[first], end = s->levels[first + levels];
    for (u32 i = begin + (u32)get_local_id(0); i < end; i += (u32)get_local_size(0)) link_push(i, s);
    barrier(CLK_GLOBAL_MEM_FENCE);
    tree += (u32)get_num_groups(0);
  } while (tree < count);
}

#endif
