// A link of an articulation and the joint that holds it: what its rows feel and push, and the factors that the solve
// goes up and down with. kernels/articulations/link.h is the twin.
//
// The equations of the locked rows of a tree, M dv = J^T d and J dv = -(u + error) (survey 4.4, eq 79), have as many
// blocks as bodies and joints, and where they are eliminated from the leaves to the root none fills in (Baraff,
// Linear-Time Dynamics using Lagrange Multipliers, 1996). With j the rows' Jacobian of the link, p that of its parent:
//   inertia   H = M + sum over the children of what the parent feels, H = L D L^T
//   mobility  S = j H^-1 j^T + compliance (of the free row's spring alone)
//   onto the parent          p^T S^-1 p
// H is the articulated-body inertia of Featherstone (Rigid Body Dynamics Algorithms, 2008, 7.1), in maximal
// coordinates.
#pragma once

#include <bit>

#include "cpu_reference/rigid_body.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// A velocity, or an impulse and its moment.
template <class real>
struct Twist {
  Vec3<real> linear, angular;
};

template <class real>
Twist<real> read_twist(const real (&field)[6]) {
  return {{field[0], field[1], field[2]}, {field[3], field[4], field[5]}};
}

template <class real>
void write_twist(Twist<real> twist, real (&field)[6]) {
  store3(field, twist.linear);
  store3(field + 3, twist.angular);
}

template <class real>
Twist<real> add_twist(Twist<real> a, Twist<real> b) {
  return {add3(a.linear, b.linear), add3(a.angular, b.angular)};
}

template <class real>
Twist<real> sub_twist(Twist<real> a, Twist<real> b) {
  return {sub3(a.linear, b.linear), sub3(a.angular, b.angular)};
}

/// The velocity of a body at the end of an arm.
template <class real>
Twist<real> twist_at(Vec3<real> arm, Twist<real> body) {
  return {add3(body.linear, cross3(body.angular, arm)), body.angular};
}

/// What an impulse at the end of an arm, and a moment, are about the centre of mass.
template <class real>
Twist<real> effort_about(Vec3<real> arm, Twist<real> effort) {
  return {effort.linear, add3(cross3(arm, effort.linear), effort.angular)};
}

// ---- symmetric matrices, the entries on and below the diagonal row by row ------------------------------------------

constexpr u32 entry_index(u32 i, u32 j) { return i * (i + 1) / 2 + j; }

/// Pivots are not less than this share of what they started from: where heavy bodies hang on light ones more is lost to
/// rounding than was there.
template <class real>
constexpr real least_pivot = sizeof(real) == 4 ? real(1e-6) : real(1e-14);

/// Replaces K by its factor: L below the diagonal of ones, 1 / D on it. What is not in `rows` gets zeros.
template <class real>
void factorise_rows(u32 n, u32 rows, real* k) {
  real pivots[LINK_ROWS];
  for (u32 j = 0; j < n; ++j) {
    const bool in = (rows >> j & 1) != 0;
    real pivot = k[entry_index(j, j)];
    const real least = least_pivot<real> * pivot;
    for (u32 m = 0; m < j; ++m) pivot = pivot - k[entry_index(j, m)] * k[entry_index(j, m)] * pivots[m];
    pivots[j] = in ? (pivot > least ? pivot : least) : real(0);
    const real inverse = in ? real(1) / pivots[j] : real(0);
    for (u32 i = j + 1; i < n; ++i) {
      real entry = k[entry_index(i, j)];
      for (u32 m = 0; m < j; ++m) entry = entry - k[entry_index(i, m)] * k[entry_index(j, m)] * pivots[m];
      k[entry_index(i, j)] = (rows >> i & 1) != 0 ? entry * inverse : real(0);
    }
    k[entry_index(j, j)] = inverse;
  }
}

/// Replaces b by L^-1 b.
template <class real>
void solve_lower(u32 n, const real* factor, real* b) {
  for (u32 i = 1; i < n; ++i) {
    for (u32 m = 0; m < i; ++m) b[i] = b[i] - factor[entry_index(i, m)] * b[m];
  }
}

/// Replaces b by K^-1 b; what is not in the rows of the factor becomes zero.
template <class real>
void solve_rows(u32 n, const real* factor, real* b) {
  solve_lower(n, factor, b);
  for (u32 i = 0; i < n; ++i) b[i] = b[i] * factor[entry_index(i, i)];
  for (u32 i = n; i-- > 0;) {
    for (u32 m = i + 1; m < n; ++m) b[i] = b[i] - factor[entry_index(m, i)] * b[m];
  }
}

/// x K^-1 y, from L^-1 x and L^-1 y.
template <class real>
real product_by_factor(u32 n, const real* factor, const real* x, const real* y) {
  real sum = 0;
  for (u32 i = 0; i < n; ++i) sum = sum + x[i] * y[i] * factor[entry_index(i, i)];
  return sum;
}

// ---- rows ----------------------------------------------------------------------------------------------------------

/// Where the joint of a link is: its axes, the arms of both bodies, the axis of the free row, that of an angle or
/// of a travel, and the lead of a screw.
template <class real>
void set_link_joint(const LinkInfo& link, bool angular, const Vec3<real> (&axes)[3], Vec3<real> arm_a, Vec3<real> arm_b,
                    Vec3<real> free_axis, real lead, LinkFactor<real>& f) {
  for (u32 i = 0; i < 3; ++i) store3(f.axes[i], axes[i]);
  store3(f.arm, link.is_b != 0 ? arm_b : arm_a);
  store3(f.parent_arm, link.is_b != 0 ? arm_a : arm_b);
  store3(f.free_linear, scale3(angular ? real(0) : real(1), free_axis));
  store3(f.free_angular, scale3(angular ? real(1) : real(0), free_axis));
  f.lead = lead;
}

/// The velocities of the rows where the ends of the joint move so against each other.
template <class real>
void link_rows(const LinkFactor<real>& f, Twist<real> u, real (&rows)[LINK_ROWS]) {
  for (u32 i = 0; i < 3; ++i) {
    const Vec3<real> axis = vec3(f.axes[i]);
    rows[i] = dot3(axis, u.linear);
    rows[i + 3] = dot3(axis, u.angular);
  }
  rows[2] = rows[2] - f.lead * rows[5];
  rows[JOINT_ROWS] = dot3(vec3(f.free_linear), u.linear) + dot3(vec3(f.free_angular), u.angular);
}

/// What impulses of the rows push with at the joint.
template <class real>
Twist<real> link_effort(const LinkFactor<real>& f, const real (&r)[LINK_ROWS]) {
  const Vec3<real> x = vec3(f.axes[0]), y = vec3(f.axes[1]), z = vec3(f.axes[2]);
  const Vec3<real> impulse = add3(add3(scale3(r[0], x), scale3(r[1], y)), scale3(r[2], z));
  const Vec3<real> moment = add3(add3(scale3(r[3], x), scale3(r[4], y)), scale3(r[5] - f.lead * r[2], z));
  return {add3(impulse, scale3(r[JOINT_ROWS], vec3(f.free_linear))),
          add3(moment, scale3(r[JOINT_ROWS], vec3(f.free_angular)))};
}

/// What a unit of one row pushes with there.
template <class real>
Twist<real> row_effort(const LinkFactor<real>& f, u32 row) {
  const Vec3<real> none = {0, 0, 0};
  if (row == 2) return {vec3(f.axes[2]), scale3(-f.lead, vec3(f.axes[2]))};
  if (row < 3) return {vec3(f.axes[row]), none};
  if (row < JOINT_ROWS) return {none, vec3(f.axes[row - 3])};
  return {vec3(f.free_linear), vec3(f.free_angular)};
}

// ---- factors -------------------------------------------------------------------------------------------------------

/// The mass and the inertia of a body, from their inverses: those are what the solve moves it by.
template <class real>
void body_inertia(const Motion<real>& body, real (&h)[LINK_ENTRIES]) {
  for (real& entry : h) entry = 0;
  const real mass = real(1) / body.inverse_mass;
  for (u32 i = 0; i < 3; ++i) h[entry_index(i, i)] = mass;
  const real scale = real(1) / (body.inertia_xx + body.inertia_yy + body.inertia_zz);
  const real xx = scale * body.inertia_xx, yy = scale * body.inertia_yy, zz = scale * body.inertia_zz;
  const real xy = scale * body.inertia_xy, xz = scale * body.inertia_xz, yz = scale * body.inertia_yz;
  const real of_xx = yy * zz - yz * yz, of_xy = xz * yz - xy * zz, of_xz = xy * yz - xz * yy;
  const real back = scale / (xx * of_xx + xy * of_xy + xz * of_xz);
  h[entry_index(3, 3)] = back * of_xx;
  h[entry_index(4, 3)] = back * of_xy;
  h[entry_index(4, 4)] = back * (xx * zz - xz * xz);
  h[entry_index(5, 3)] = back * of_xz;
  h[entry_index(5, 4)] = back * (xy * xz - xx * yz);
  h[entry_index(5, 5)] = back * (xx * yy - xy * xy);
}

/// The factors of a link whose children have theirs, and whose joint is written. `rows`: bits of those that it solves.
template <class real>
void factorise_link(const Buffers<real>& b, const LinkInfo& link, u32 rows, LinkFactor<real>& f) {
  body_inertia(b.motions[link.body], f.inertia);
  for (u32 child = link.first_child; child < link.first_child + link.child_count; ++child) {
    for (u32 k = 0; k < LINK_ENTRIES; ++k) f.inertia[k] = f.inertia[k] + b.link_factors[child].onto_parent[k];
  }
  factorise_rows(6, 0x3f, f.inertia);

  real lower[LINK_ROWS][6], columns[6][LINK_ROWS] = {};
  const u32 count = 32 - static_cast<u32>(std::countl_zero(rows));  // up to the last
  for (u32 r = 0; r < LINK_ROWS; ++r) {
    for (u32 s = 0; s <= r; ++s) f.mobility[entry_index(r, s)] = 0;
    if ((rows >> r & 1) == 0) continue;
    const Twist<real> effort = row_effort(f, r);
    real row[6];
    write_twist(effort_about(vec3(f.parent_arm), effort), row);
    for (u32 k = 0; k < 6; ++k) columns[k][r] = row[k];
    write_twist(effort_about(vec3(f.arm), effort), lower[r]);
    solve_lower(6, f.inertia, lower[r]);
    for (u32 s = 0; s <= r; ++s) {
      if ((rows >> s & 1) != 0) f.mobility[entry_index(r, s)] = product_by_factor(6, f.inertia, lower[r], lower[s]);
    }
  }
  if ((rows >> JOINT_ROWS & 1) != 0) f.mobility[ROW_ENTRIES - 1] = f.mobility[ROW_ENTRIES - 1] + f.spring_compliance;
  factorise_rows(count, rows, f.mobility);

  for (real& entry : f.onto_parent) entry = 0;
  if (link.parent == NONE) return;
  for (u32 k = 0; k < 6; ++k) {
    solve_lower(count, f.mobility, columns[k]);
    for (u32 m = 0; m <= k; ++m)
      f.onto_parent[entry_index(k, m)] = product_by_factor(count, f.mobility, columns[k], columns[m]);
  }
}

// ---- the order of a solve ------------------------------------------------------------------------------------------

/// Calls function(index, link) for all links of an articulation, from the leaves to the roots, or the other way round.
template <class real, class Function>
void for_each_link_up(const Buffers<real>& b, const Articulation& tree, Function&& function) {
  for (u32 level = tree.first_level + tree.level_count; level-- > tree.first_level;) {
    for (u32 i = b.link_levels[level]; i < b.link_levels[level + 1]; ++i) function(i, b.links[i]);
  }
}

template <class real, class Function>
void for_each_link_down(const Buffers<real>& b, const Articulation& tree, Function&& function) {
  const u32 end = b.link_levels[tree.first_level + tree.level_count];
  for (u32 i = b.link_levels[tree.first_level]; i < end; ++i) function(i, b.links[i]);
}

}  // namespace lockstep::reference
