// A link of an articulation and the joint that holds it. cpu_reference/articulations/link.hpp is the twin and gives the
// equations.
#ifndef LOCKSTEP_ARTICULATION_LINK_H
#define LOCKSTEP_ARTICULATION_LINK_H

#include "rigid_body.h"
#include "types.h"

// A velocity, or an impulse and its moment.
typedef struct Twist {
  Vec3 linear, angular;
} Twist;

static inline Twist make_twist(Vec3 linear, Vec3 angular) {
  Twist twist;
  twist.linear = linear;
  twist.angular = angular;
  return twist;
}
static inline Twist no_twist(void) {
  const Vec3 none = make3((real)0, (real)0, (real)0);
  return make_twist(none, none);
}
static inline Vec3 global_vec3(global const real* p) { return make3(p[0], p[1], p[2]); }
static inline void global_store3(global real* p, Vec3 a) {
  p[0] = a.x;
  p[1] = a.y;
  p[2] = a.z;
}
static inline Twist read_twist(global const real* p) { return make_twist(global_vec3(p), global_vec3(p + 3)); }
static inline void write_twist(Twist twist, global real* p) {
  global_store3(p, twist.linear);
  global_store3(p + 3, twist.angular);
}
static inline void spread_twist(Twist twist, real* p) {
  store3(p, twist.linear);
  store3(p + 3, twist.angular);
}
static inline Twist add_twist(Twist a, Twist b) {
  return make_twist(add3(a.linear, b.linear), add3(a.angular, b.angular));
}
static inline Twist sub_twist(Twist a, Twist b) {
  return make_twist(sub3(a.linear, b.linear), sub3(a.angular, b.angular));
}
static inline Twist twist_at(Vec3 arm, Twist body) {
  return make_twist(add3(body.linear, cross3(body.angular, arm)), body.angular);
}
static inline Twist effort_about(Vec3 arm, Twist effort) {
  return make_twist(effort.linear, add3(cross3(arm, effort.linear), effort.angular));
}

// ---- symmetric matrices, the entries on and below the diagonal row by row ------------------------------------------

#define ENTRY_INDEX(i, j) ((i) * ((i) + 1u) / 2u + (j))
#define LEAST_PIVOT (sizeof(real) == 4 ? (real)1e-6 : (real)1e-14)

static inline void factorise_rows(u32 n, u32 rows, real* k) {
  real pivots[LINK_ROWS];
  for (u32 j = 0u; j < n; ++j) {
    const bool in = (rows >> j & 1u) != 0u;
    real pivot = k[ENTRY_INDEX(j, j)];
    const real least = LEAST_PIVOT * pivot;
    for (u32 m = 0u; m < j; ++m) pivot = pivot - k[ENTRY_INDEX(j, m)] * k[ENTRY_INDEX(j, m)] * pivots[m];
    pivots[j] = in ? (pivot > least ? pivot : least) : (real)0;
    const real inverse = in ? (real)1 / pivots[j] : (real)0;
    for (u32 i = j + 1u; i < n; ++i) {
      real entry = k[ENTRY_INDEX(i, j)];
      for (u32 m = 0u; m < j; ++m) entry = entry - k[ENTRY_INDEX(i, m)] * k[ENTRY_INDEX(j, m)] * pivots[m];
      k[ENTRY_INDEX(i, j)] = (rows >> i & 1u) != 0u ? entry * inverse : (real)0;
    }
    k[ENTRY_INDEX(j, j)] = inverse;
  }
}

static inline void solve_lower(const u32 n, const real* factor, real* b) {
  for (u32 i = 1u; i < n; ++i) {
    for (u32 m = 0u; m < i; ++m) b[i] = b[i] - factor[ENTRY_INDEX(i, m)] * b[m];
  }
}

// With a factor as it is kept.
static inline void solve_rows(const u32 n, global const real* factor, real* b) {
  for (u32 i = 1u; i < n; ++i) {
    for (u32 m = 0u; m < i; ++m) b[i] = b[i] - factor[ENTRY_INDEX(i, m)] * b[m];
  }
  for (u32 i = 0u; i < n; ++i) b[i] = b[i] * factor[ENTRY_INDEX(i, i)];
  for (u32 i = n; i-- > 0u;) {
    for (u32 m = i + 1u; m < n; ++m) b[i] = b[i] - factor[ENTRY_INDEX(m, i)] * b[m];
  }
}

static inline real product_by_factor(const u32 n, const real* factor, const real* x, const real* y) {
  real sum = (real)0;
  for (u32 i = 0u; i < n; ++i) sum = sum + x[i] * y[i] * factor[ENTRY_INDEX(i, i)];
  return sum;
}

// ---- rows ----------------------------------------------------------------------------------------------------------

static inline void set_link_joint(LinkInfo link, bool angular, const Vec3* axes, Vec3 arm_a, Vec3 arm_b, Vec3 free_axis,
                                  real lead, global LinkFactor* f) {
  for (u32 i = 0u; i < 3u; ++i) global_store3(f->axes[i], axes[i]);
  global_store3(f->arm, link.is_b != 0u ? arm_b : arm_a);
  global_store3(f->parent_arm, link.is_b != 0u ? arm_a : arm_b);
  global_store3(f->free_linear, scale3(angular ? (real)0 : (real)1, free_axis));
  global_store3(f->free_angular, scale3(angular ? (real)1 : (real)0, free_axis));
  f->lead = lead;
}

static inline void link_rows(global const LinkFactor* f, Twist u, real* rows) {
  for (u32 i = 0u; i < 3u; ++i) {
    const Vec3 axis = global_vec3(f->axes[i]);
    rows[i] = dot3(axis, u.linear);
    rows[i + 3u] = dot3(axis, u.angular);
  }
  rows[2] = rows[2] - f->lead * rows[5];
  rows[JOINT_ROWS] = dot3(global_vec3(f->free_linear), u.linear) + dot3(global_vec3(f->free_angular), u.angular);
}

static inline Twist link_effort(global const LinkFactor* f, const real* r) {
  const Vec3 x = global_vec3(f->axes[0]), y = global_vec3(f->axes[1]), z = global_vec3(f->axes[2]);
  const Vec3 impulse = add3(add3(scale3(r[0], x), scale3(r[1], y)), scale3(r[2], z));
  const Vec3 moment = add3(add3(scale3(r[3], x), scale3(r[4], y)), scale3(r[5] - f->lead * r[2], z));
  return make_twist(add3(impulse, scale3(r[JOINT_ROWS], global_vec3(f->free_linear))),
                    add3(moment, scale3(r[JOINT_ROWS], global_vec3(f->free_angular))));
}

static inline Twist row_effort(global const LinkFactor* f, u32 row) {
  const Vec3 none = make3((real)0, (real)0, (real)0);
  if (row == 2u) return make_twist(global_vec3(f->axes[2]), scale3(-f->lead, global_vec3(f->axes[2])));
  if (row < 3u) return make_twist(global_vec3(f->axes[row]), none);
  if (row < JOINT_ROWS) return make_twist(none, global_vec3(f->axes[row - 3u]));
  return make_twist(global_vec3(f->free_linear), global_vec3(f->free_angular));
}

// ---- factors -------------------------------------------------------------------------------------------------------

static inline void body_inertia(Motion body, real* h) {
  for (u32 i = 0u; i < LINK_ENTRIES; ++i) h[i] = (real)0;
  const real mass = (real)1 / body.inverse_mass;
  for (u32 i = 0u; i < 3u; ++i) h[ENTRY_INDEX(i, i)] = mass;
  const real scale = (real)1 / (body.inertia_xx + body.inertia_yy + body.inertia_zz);
  const real xx = scale * body.inertia_xx, yy = scale * body.inertia_yy, zz = scale * body.inertia_zz;
  const real xy = scale * body.inertia_xy, xz = scale * body.inertia_xz, yz = scale * body.inertia_yz;
  const real of_xx = yy * zz - yz * yz, of_xy = xz * yz - xy * zz, of_xz = xy * yz - xz * yy;
  const real back = scale / (xx * of_xx + xy * of_xy + xz * of_xz);
  h[ENTRY_INDEX(3u, 3u)] = back * of_xx;
  h[ENTRY_INDEX(4u, 3u)] = back * of_xy;
  h[ENTRY_INDEX(4u, 4u)] = back * (xx * zz - xz * xz);
  h[ENTRY_INDEX(5u, 3u)] = back * of_xz;
  h[ENTRY_INDEX(5u, 4u)] = back * (xy * xz - xx * yz);
  h[ENTRY_INDEX(5u, 5u)] = back * (xx * yy - xy * xy);
}

static inline void factorise_link(LinkInfo link, u32 rows, Motion body, global const LinkFactor* link_factors,
                                  global LinkFactor* f) {
  real inertia[LINK_ENTRIES];
  body_inertia(body, inertia);
  for (u32 child = link.first_child; child < link.first_child + link.child_count; ++child) {
    for (u32 k = 0u; k < LINK_ENTRIES; ++k) inertia[k] = inertia[k] + link_factors[child].onto_parent[k];
  }
  factorise_rows(6u, 0x3fu, inertia);
  for (u32 k = 0u; k < LINK_ENTRIES; ++k) f->inertia[k] = inertia[k];

  const u32 count = 32u - clz(rows);
  const Vec3 arm = global_vec3(f->arm), parent_arm = global_vec3(f->parent_arm);
  real lower[LINK_ROWS][6], columns[6][LINK_ROWS], mobility[ROW_ENTRIES];
  for (u32 r = 0u; r < LINK_ROWS; ++r) {
    for (u32 s = 0u; s <= r; ++s) mobility[ENTRY_INDEX(r, s)] = (real)0;
    for (u32 k = 0u; k < 6u; ++k) columns[k][r] = lower[r][k] = (real)0;
    if ((rows >> r & 1u) == 0u) continue;
    const Twist effort = row_effort(f, r);
    real row[6];
    spread_twist(effort_about(parent_arm, effort), row);
    for (u32 k = 0u; k < 6u; ++k) columns[k][r] = row[k];
    spread_twist(effort_about(arm, effort), lower[r]);
    solve_lower(6u, inertia, lower[r]);
    for (u32 s = 0u; s <= r; ++s) {
      if ((rows >> s & 1u) != 0u) mobility[ENTRY_INDEX(r, s)] = product_by_factor(6u, inertia, lower[r], lower[s]);
    }
  }
  if ((rows >> JOINT_ROWS & 1u) != 0u) mobility[ROW_ENTRIES - 1u] = mobility[ROW_ENTRIES - 1u] + f->spring_compliance;
  factorise_rows(count, rows, mobility);
  for (u32 k = 0u; k < ROW_ENTRIES; ++k) f->mobility[k] = mobility[k];

  for (u32 k = 0u; k < LINK_ENTRIES; ++k) f->onto_parent[k] = (real)0;
  if (link.parent == NONE) return;
  for (u32 k = 0u; k < 6u; ++k) {
    solve_lower(count, mobility, columns[k]);
    for (u32 m = 0u; m <= k; ++m)
      f->onto_parent[ENTRY_INDEX(k, m)] = product_by_factor(count, mobility, columns[k], columns[m]);
  }
}

// ---- the order of a solve ------------------------------------------------------------------------------------------

typedef struct LinkRange {
  u32 begin, end;
} LinkRange;

static inline LinkRange links_of_level(u32 level, bool is_there, global const u32* link_levels) {
  LinkRange range;
  range.begin = link_levels[level];
  range.end = is_there ? link_levels[level + 1u] : range.begin;
  return range;
}

// Of so many levels, those of a step from the leaves to the root, or the other way round: none behind the last step.
static inline LinkRange links_up(u32 first, u32 levels, u32 step, global const u32* link_levels) {
  return links_of_level(first + (step < levels ? levels - 1u - step : 0u), step < levels, link_levels);
}
static inline LinkRange links_down(u32 first, u32 levels, u32 step, global const u32* link_levels) {
  return links_of_level(first + (step < levels ? step : 0u), step < levels, link_levels);
}

#endif
