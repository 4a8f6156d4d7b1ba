// Joints that close loops of an articulation, solved with it: auxiliary constraints (Baraff 1996, 7). A tree whose rows
// are solved answers a unit of each of their rows, at both ends, with velocities u_j of the ends of all of them:
//   W = [u_1 u_2 ...] (+ compliance of springs),   W mu = -(what is off once the tree has answered what is off in it)
// W is symmetric and is factorised as L D L^T. Where a loop holds what is held already, by the tree or by other rows,
// a pivot p is rounding. In its place comes p + f^2 / p, with f a small share of the row's mobility if both ends were
// free: what is well above f stays as it is, and a row that nothing moves gets hardly an impulse, so that loops that
// cannot close are left open. kernels/articulations/closures.h is the twin.
#pragma once

#include "cpu_reference/articulations/tree_passes.hpp"

namespace lockstep::reference {

template <class real>
constexpr real closure_regularization = sizeof(real) == 4 ? real(1e-5) : real(1e-10);

/// An articulation without any has an empty set.
template <class real>
ClosureSet closures_of(const Buffers<real>& b, u32 tree) {
  return b.closure_sets.empty() ? ClosureSet{} : b.closure_sets[tree];
}

/// Calls function(index, closure).
template <class real, class Function>
void for_each_closure(const Buffers<real>& b, const ClosureSet& loops, Function&& function) {
  for (u32 k = loops.first; k < loops.first + loops.count; ++k) function(k, b.closures[k]);
}

/// As if body a held body b.
template <class real>
LinkInfo as_link(const Buffers<real>& b, const ClosureInfo& closure) {
  return {b.joint_infos[closure.joint].body_b, closure.link_a, closure.joint, closure.slot, 0, 0, 1, 0};
}

/// Marks the rows that are solved, as the mobility of a link does.
template <class real>
void mark_rows(u32 rows, LinkFactor<real>& f) {
  for (u32 i = 0; i < LINK_ROWS; ++i) f.mobility[entry_index(i, i)] = (rows >> i & 1) != 0 ? real(1) : real(0);
}

template <class real>
bool has_row(const LinkFactor<real>& f, u32 row) {
  return f.mobility[entry_index(row, row)] > 0;
}

template <class real>
void clear_pushes(const Buffers<real>& b, const ClosureSet& loops, LinkMotion<real>* motions) {
  for_each_closure(b, loops, [&](u32, const ClosureInfo& closure) {
    if (closure.link_a != NONE) write_twist(Twist<real>{}, motions[closure.link_a].push);
    if (closure.link_b != NONE) write_twist(Twist<real>{}, motions[closure.link_b].push);
  });
}

/// Adds what an impulse and a moment at the joint push both ends with.
template <class real>
void push_ends(const LinkFactor<real>& f, const ClosureInfo& closure, Twist<real> effort, LinkMotion<real>* motions) {
  if (closure.link_a != NONE) {
    real(&push)[6] = motions[closure.link_a].push;
    write_twist(sub_twist(read_twist(push), effort_about(vec3(f.parent_arm), effort)), push);
  }
  if (closure.link_b != NONE) {
    real(&push)[6] = motions[closure.link_b].push;
    write_twist(add_twist(read_twist(push), effort_about(vec3(f.arm), effort)), push);
  }
}

/// How fast the ends part by the changes of their links.
template <class real>
void rows_of_changes(const LinkFactor<real>& f, const ClosureInfo& closure, const LinkMotion<real>* motions,
                     real (&rows)[LINK_ROWS]) {
  Twist<real> a = {}, b = {};
  if (closure.link_a != NONE) a = read_twist(motions[closure.link_a].change);
  if (closure.link_b != NONE) b = read_twist(motions[closure.link_b].change);
  link_rows(f, sub_twist(twist_at(vec3(f.arm), b), twist_at(vec3(f.parent_arm), a)), rows);
}

/// How fast a unit of a row parts its ends where nothing else holds them.
template <class real>
real free_mobility(const Buffers<real>& b, const ClosureInfo& closure, const LinkFactor<real>& f, u32 row) {
  const Twist<real> effort = row_effort(f, row);
  real sum = 0;
  const auto add_end = [&](u32 link, Vec3<real> arm) {
    if (link == NONE) return;
    const Motion<real>& body = b.motions[b.links[link].body];
    const Twist<real> push = effort_about(arm, effort);
    sum = sum + (body.inverse_mass * dot3(push.linear, push.linear) +
                 dot3(push.angular, apply_inverse_inertia(body, push.angular)));
  };
  add_end(closure.link_a, vec3(f.parent_arm));
  add_end(closure.link_b, vec3(f.arm));
  return sum;
}

// ---- their matrix, the entries on and below the diagonal -----------------------------------------------------------

constexpr std::size_t closure_entry(u32 i, u32 j) { return std::size_t{i} * CLOSURE_STRIDE + j; }

template <class real>
real closure_pivot(real pivot, real whole) {
  const real regularization = closure_regularization<real> * whole;
  return pivot > real(0.01) * regularization ? pivot + regularization * regularization / pivot : real(0);
}

/// Replaces W by its factor: L below the diagonal of ones, 1 / D on it, zeros in rows that are not solved. `whole`: the
/// mobility of each row if its ends were free, 0 of rows that are not solved.
template <class real>
void factorise_closures(u32 n, real* w, const real* whole) {
  for (u32 j = 0; j < n; ++j) {
    const real pivot = closure_pivot(w[closure_entry(j, j)], whole[j]);
    const real inverse = pivot > 0 ? real(1) / pivot : real(0);
    for (u32 i = j + 1; i < n; ++i) w[closure_entry(i, j)] = w[closure_entry(i, j)] * inverse;
    for (u32 i = j + 1; i < n; ++i) {
      for (u32 m = j + 1; m <= i; ++m) {
        real& entry = w[closure_entry(i, m)];
        entry = entry - w[closure_entry(i, j)] * w[closure_entry(m, j)] * pivot;
      }
    }
    w[closure_entry(j, j)] = inverse;
  }
}

/// Replaces x by W^-1 x.
template <class real>
void solve_closure_rows(u32 n, const real* w, real* x) {
  for (u32 j = 0; j < n; ++j) {
    for (u32 i = j + 1; i < n; ++i) x[i] = x[i] - w[closure_entry(i, j)] * x[j];
  }
  for (u32 i = 0; i < n; ++i) x[i] = x[i] * w[closure_entry(i, i)];
  for (u32 j = n; j-- > 0;) {
    for (u32 i = 0; i < j; ++i) x[i] = x[i] - w[closure_entry(j, i)] * x[j];
  }
}

/// Nothing is factorised.
template <class real>
void clear_closures(Buffers<real>& b, const ClosureSet& loops) {
  const u32 begin = loops.first * LINK_ROWS, end = begin + loops.count * LINK_ROWS;
  for_each_closure(b, loops, [&](u32 k, const ClosureInfo&) { b.closure_factors[k] = {}; });
  for (u32 row = begin; row < end; ++row) b.closure_wanted[row] = 0;
  for (std::size_t i = closure_entry(begin, 0); i < closure_entry(end, 0); ++i) b.closure_matrix[i] = 0;
}

/// Room for what links do while columns are written; no closure pushes any of them yet.
template <class real>
std::vector<LinkMotion<real>> room_for_columns(const Buffers<real>& b) {
  return std::vector<LinkMotion<real>>(b.closures.empty() ? 0 : b.links.size());
}

/// The matrix of an articulation whose links have their factors, and whose closures are written.
template <class real>
void factor_closures(Buffers<real>& b, const Articulation& tree, const ClosureSet& loops,
                     std::vector<LinkMotion<real>>& motions) {
  const u32 n = loops.count * LINK_ROWS;
  if (n == 0) return;
  real* const w = b.closure_matrix.data() + closure_entry(loops.first * LINK_ROWS, 0);
  real* const whole = b.closure_wanted.data() + loops.first * LINK_ROWS;  // nothing is wanted yet
  const real nothing[LINK_ROWS] = {};
  for (u32 j = 0; j < n; ++j) {
    const u32 of = loops.first + j / LINK_ROWS, row = j % LINK_ROWS;
    const LinkFactor<real>& f = b.closure_factors[of];
    for (u32 i = j; i < n; ++i) w[closure_entry(i, j)] = 0;
    whole[j] = has_row(f, row) ? free_mobility(b, b.closures[of], f, row) : real(0);
    if (!has_row(f, row)) continue;
    clear_pushes(b, loops, motions.data());
    push_ends(f, b.closures[of], row_effort(f, row), motions.data());
    for_each_link_up(b, tree, [&](u32 i, const LinkInfo&) { backward_pass(b, i, nothing, motions.data()); });
    for_each_link_down(b, tree, [&](u32 i, const LinkInfo&) {
      real d[LINK_ROWS];
      forward_pass(b, i, motions.data(), d);
    });
    for (u32 k = of; k < loops.first + loops.count; ++k) {
      real response[LINK_ROWS];
      rows_of_changes(b.closure_factors[k], b.closures[k], motions.data(), response);
      for (u32 r = 0; r < LINK_ROWS; ++r) {
        const u32 i = (k - loops.first) * LINK_ROWS + r;
        if (i >= j && has_row(b.closure_factors[k], r)) w[closure_entry(i, j)] = response[r];
      }
    }
    if (row == JOINT_ROWS) w[closure_entry(j, j)] = w[closure_entry(j, j)] + f.spring_compliance;
  }
  factorise_closures(n, w, whole);
}

/// What the rows of a closure are to lose: what is off, and what the tree's answer adds.
template <class real>
void want_closed(Buffers<real>& b, u32 k, const real (&off)[LINK_ROWS]) {
  const LinkFactor<real>& f = b.closure_factors[k];
  real moved[LINK_ROWS];
  rows_of_changes(f, b.closures[k], b.link_motions.data(), moved);
  for (u32 i = 0; i < LINK_ROWS; ++i)
    b.closure_wanted[k * LINK_ROWS + i] = has_row(f, i) ? -(off[i] + moved[i]) : real(0);
}

/// Solves for the impulses of the closures, which take the place of what is wanted, and pushes their ends.
template <class real>
void solve_closures(Buffers<real>& b, const ClosureSet& loops) {
  real* const x = b.closure_wanted.data() + loops.first * LINK_ROWS;
  solve_closure_rows(loops.count * LINK_ROWS, b.closure_matrix.data() + closure_entry(loops.first * LINK_ROWS, 0), x);
  for_each_closure(b, loops, [&](u32 k, const ClosureInfo& closure) {
    real d[LINK_ROWS];
    for (u32 i = 0; i < LINK_ROWS; ++i) d[i] = b.closure_wanted[k * LINK_ROWS + i];
    push_ends(b.closure_factors[k], closure, link_effort(b.closure_factors[k], d), b.link_motions.data());
  });
}

}  // namespace lockstep::reference
