// Joints that close loops of an articulation, solved with it. cpu_reference/articulations/closures.hpp is the twin and
// gives the equations. Where a function has barriers, a work-group calls it as one; an empty set does nothing.
#ifndef LOCKSTEP_ARTICULATION_CLOSURES_H
#define LOCKSTEP_ARTICULATION_CLOSURES_H

#include "articulations/tree_passes.h"

// All that is known of them.
typedef struct Closures {
  global const ClosureSet* sets;
  global const ClosureInfo* closures;
  global LinkFactor* factors;
  global real* matrix;
  global real* wanted;
} Closures;

// Of the parameters of a kernel; a solve takes the factors as they are.
#define CLOSURES \
  { closure_sets, closures, (global LinkFactor*)closure_factors, (global real*)closure_matrix, closure_wanted }

static inline ClosureSet no_closures(void) {
  ClosureSet loops;
  loops.first = loops.count = loops.first_column = loops.links = 0u;
  return loops;
}

#if !FEATURE_CLOSURES

static inline ClosureSet closures_of(u32 tree, bool is_there, const Closures* s) { return no_closures(); }
static inline void clear_pushes(ClosureSet loops, const Closures* s, global LinkMotion* motions) {}

#else

#define CLOSURE_REGULARIZATION (sizeof(real) == 4 ? (real)1e-5 : (real)1e-10)

static inline ClosureSet closures_of(u32 tree, bool is_there, const Closures* s) {
  return is_there ? s->sets[tree] : no_closures();
}

static inline LinkInfo as_link(ClosureInfo closure, global const JointInfo* joint_infos) {
  LinkInfo link;
  link.body = joint_infos[closure.joint].body_b;
  link.parent = closure.link_a;
  link.joint = closure.joint;
  link.slot = closure.slot;
  link.first_child = link.child_count = link.pad = 0u;
  link.is_b = 1u;
  return link;
}

static inline void mark_rows(u32 rows, global LinkFactor* f) {
  for (u32 i = 0u; i < LINK_ROWS; ++i) f->mobility[ENTRY_INDEX(i, i)] = (rows >> i & 1u) != 0u ? (real)1 : (real)0;
}

static inline bool has_row(global const LinkFactor* f, u32 row) { return f->mobility[ENTRY_INDEX(row, row)] > (real)0; }

// By one work-item, with a barrier behind it.
static inline void clear_pushes_here(ClosureSet loops, const Closures* s, global LinkMotion* motions) {
  for (u32 k = loops.first; k < loops.first + loops.count; ++k) {
    const ClosureInfo closure = s->closures[k];
    if (closure.link_a != NONE) write_twist(no_twist(), motions[closure.link_a].push);
    if (closure.link_b != NONE) write_twist(no_twist(), motions[closure.link_b].push);
  }
}

static inline void clear_pushes(ClosureSet loops, const Closures* s, global LinkMotion* motions) {
  if (get_local_id(0) == 0) clear_pushes_here(loops, s, motions);
  barrier(CLK_GLOBAL_MEM_FENCE);
}

static inline void push_ends(global const LinkFactor* f, ClosureInfo closure, Twist effort,
                             global LinkMotion* motions) {
  if (closure.link_a != NONE) {
    global real* push = motions[closure.link_a].push;
    write_twist(sub_twist(read_twist(push), effort_about(global_vec3(f->parent_arm), effort)), push);
  }
  if (closure.link_b != NONE) {
    global real* push = motions[closure.link_b].push;
    write_twist(add_twist(read_twist(push), effort_about(global_vec3(f->arm), effort)), push);
  }
}

static inline void rows_of_changes(global const LinkFactor* f, ClosureInfo closure, global const LinkMotion* motions,
                                   real* rows) {
  const Twist a = closure.link_a != NONE ? read_twist(motions[closure.link_a].change) : no_twist();
  const Twist b = closure.link_b != NONE ? read_twist(motions[closure.link_b].change) : no_twist();
  link_rows(f, sub_twist(twist_at(global_vec3(f->arm), b), twist_at(global_vec3(f->parent_arm), a)), rows);
}

// ---- their matrix --------------------------------------------------------------------------------------------------

#define CLOSURE_ENTRY(i, j) ((size_t)(i)*CLOSURE_STRIDE + (j))

static inline real closure_pivot(real pivot, real whole) {
  const real regularization = CLOSURE_REGULARIZATION * whole;
  return pivot > (real)0.01 * regularization ? pivot + regularization * regularization / pivot : (real)0;
}

// Column by column: each work-item has rows for itself.
static inline void factorise_closures(u32 n, global real* w, global const real* whole) {
  const u32 id = (u32)get_local_id(0), size = (u32)get_local_size(0);
  u32 j = 0u;
  do {
    const real pivot = j < n ? closure_pivot(w[CLOSURE_ENTRY(j, j)], whole[j]) : (real)0;
    const real inverse = pivot > (real)0 ? (real)1 / pivot : (real)0;
    for (u32 i = j + 1u + id; i < n; i += size) w[CLOSURE_ENTRY(i, j)] = w[CLOSURE_ENTRY(i, j)] * inverse;
    barrier(CLK_GLOBAL_MEM_FENCE);
    for (u32 i = j + 1u + id; i < n; i += size) {
      for (u32 m = j + 1u; m <= i; ++m) {
        global real* entry = w + CLOSURE_ENTRY(i, m);
        *entry = *entry - w[CLOSURE_ENTRY(i, j)] * w[CLOSURE_ENTRY(m, j)] * pivot;
      }
    }
    if (j < n && id == 0u) w[CLOSURE_ENTRY(j, j)] = inverse;
    barrier(CLK_GLOBAL_MEM_FENCE);
  } while (++j < n);
}

static inline void solve_closure_rows(u32 n, global const real* w, global real* x) {
  const u32 id = (u32)get_local_id(0), size = (u32)get_local_size(0);
  u32 j = 0u;
  do {
    for (u32 i = j + 1u + id; i < n; i += size) x[i] = x[i] - w[CLOSURE_ENTRY(i, j)] * x[j];
    barrier(CLK_GLOBAL_MEM_FENCE);
  } while (++j < n);
  for (u32 i = id; i < n; i += size) x[i] = x[i] * w[CLOSURE_ENTRY(i, i)];
  barrier(CLK_GLOBAL_MEM_FENCE);
  j = n;
  do {
    for (u32 i = id; i + 1u < j; i += size) x[i] = x[i] - w[CLOSURE_ENTRY(j - 1u, i)] * x[j - 1u];
    barrier(CLK_GLOBAL_MEM_FENCE);
  } while (j > 0u && --j > 0u);
}

// The links of an articulation, which have their factors.
typedef struct LinkTree {
  u32 first_level, levels;
  global const LinkInfo* links;
  global const u32* link_levels;
  global const LinkFactor* factors;
  global const Motion* bodies;
} LinkTree;

// Of the parameters of a kernel.
#define LINK_TREE(first_level, levels) \
  { first_level, levels, links, link_levels, link_factors, motions }

static inline real free_mobility_of_end(u32 link, Vec3 arm, Twist effort, const LinkTree* tree) {
  if (link == NONE) return (real)0;
  const Motion body = tree->bodies[tree->links[link].body];
  const Twist push = effort_about(arm, effort);
  return body.inverse_mass * dot3(push.linear, push.linear) +
         dot3(push.angular, apply_inverse_inertia(body, push.angular));
}

static inline real free_mobility(ClosureInfo closure, global const LinkFactor* f, u32 row, const LinkTree* tree) {
  const Twist effort = row_effort(f, row);
  return free_mobility_of_end(closure.link_a, global_vec3(f->parent_arm), effort, tree) +
         free_mobility_of_end(closure.link_b, global_vec3(f->arm), effort, tree);
}

// One column: what all rows answer to a unit of row `j`. `motions`: room for what links do, counted like them.
static inline void write_closure_column(u32 j, ClosureSet loops, const Closures* s, const LinkTree* tree,
                                        global LinkMotion* motions) {
  global real* w = s->matrix + CLOSURE_ENTRY(loops.first * LINK_ROWS, 0u);
  const u32 n = loops.count * LINK_ROWS, of = loops.first + j / LINK_ROWS, row = j % LINK_ROWS;
  global const LinkFactor* f = s->factors + of;
  const bool is_solved = has_row(f, row);
  for (u32 i = j; i < n; ++i) w[CLOSURE_ENTRY(i, j)] = (real)0;
  // nothing is wanted yet
  s->wanted[loops.first * LINK_ROWS + j] = is_solved ? free_mobility(s->closures[of], f, row, tree) : (real)0;
  if (!is_solved) return;
  const u32 begin = tree->link_levels[tree->first_level];
  const u32 end = tree->link_levels[tree->first_level + tree->levels];
  for (u32 i = begin; i < end; ++i) write_twist(no_twist(), motions[i].push);
  push_ends(f, s->closures[of], row_effort(f, row), motions);
  real nothing[LINK_ROWS], d[LINK_ROWS];
  for (u32 i = 0u; i < LINK_ROWS; ++i) nothing[i] = (real)0;
  for (u32 step = 0u; step < tree->levels; ++step) {
    const LinkRange at = links_up(tree->first_level, tree->levels, step, tree->link_levels);
    for (u32 i = at.begin; i < at.end; ++i) backward_pass(i, tree->links[i], nothing, tree->factors, motions);
  }
  for (u32 i = begin; i < end; ++i) forward_pass(i, tree->links[i], tree->factors, motions, d);
  for (u32 k = of; k < loops.first + loops.count; ++k) {
    real response[LINK_ROWS];
    rows_of_changes(s->factors + k, s->closures[k], motions, response);
    for (u32 r = 0u; r < LINK_ROWS; ++r) {
      const u32 i = (k - loops.first) * LINK_ROWS + r;
      if (i >= j && has_row(s->factors + k, r)) w[CLOSURE_ENTRY(i, j)] = response[r];
    }
  }
  if (row == JOINT_ROWS) w[CLOSURE_ENTRY(j, j)] = w[CLOSURE_ENTRY(j, j)] + f->spring_compliance;
}

// `columns`: room for what links do, one after the other for each row of the closures.
static inline void factor_closures(ClosureSet loops, const Closures* s, const LinkTree* tree,
                                   global LinkMotion* columns) {
  const u32 n = loops.count * LINK_ROWS;
  for (u32 j = (u32)get_local_id(0); j < n; j += (u32)get_local_size(0))
    write_closure_column(j, loops, s, tree, columns + loops.first_column + (size_t)j * loops.links);
  barrier(CLK_GLOBAL_MEM_FENCE);
  factorise_closures(n, s->matrix + CLOSURE_ENTRY(loops.first * LINK_ROWS, 0u), s->wanted + loops.first * LINK_ROWS);
}

// ---- their solution ------------------------------------------------------------------------------------------------

static inline void want_closed(u32 k, const real* off, const Closures* s, global const LinkMotion* motions) {
  global const LinkFactor* f = s->factors + k;
  real moved[LINK_ROWS];
  rows_of_changes(f, s->closures[k], motions, moved);
  for (u32 i = 0u; i < LINK_ROWS; ++i) s->wanted[k * LINK_ROWS + i] = has_row(f, i) ? -(off[i] + moved[i]) : (real)0;
}

// Behind a barrier; one is behind it.
static inline void solve_closures(ClosureSet loops, const Closures* s, global LinkMotion* motions) {
  solve_closure_rows(loops.count * LINK_ROWS, s->matrix + CLOSURE_ENTRY(loops.first * LINK_ROWS, 0u),
                     s->wanted + loops.first * LINK_ROWS);
  if (get_local_id(0) == 0) {
    for (u32 k = loops.first; k < loops.first + loops.count; ++k) {
      real d[LINK_ROWS];
      for (u32 i = 0u; i < LINK_ROWS; ++i) d[i] = s->wanted[k * LINK_ROWS + i];
      push_ends(s->factors + k, s->closures[k], link_effort(s->factors + k, d), motions);
    }
  }
  barrier(CLK_GLOBAL_MEM_FENCE);
}

#endif
#endif
