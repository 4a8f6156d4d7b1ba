// The dense Delassus matrix in tiles of PACK contacts, and what a sweep keeps of each contact beside it.
// cpu_reference/solve_dense.hpp is the twin and states the method.
#ifndef LOCKSTEP_DENSE_MATRIX_H
#define LOCKSTEP_DENSE_MATRIX_H

#include "common.h"
#include "frame.h"
#include "rigid_body.h"
#include "solve_contact.h"

// The blocks of a pair of tiles: w[k][i][j] is what component j of the impulse of the column's contact k makes of
// component i of the velocities of the row's contacts, a lane each, so that a column is read in lanes.
typedef struct DenseBlock {
  real w[PACK][3][3][PACK];
} DenseBlock;

// Of the contacts of a tile, along the normal and the two tangents: relative velocities with their biases, impulses,
// and by what their last solves changed these.
typedef struct DenseTile {
  real u[3][PACK], r[3][PACK], d[3][PACK];
  real friction[PACK];
} DenseTile;

// Behind the last tile of the step.
static inline u32 dense_tile_end(const StepParams* params, global const u32* counters) {
  return counters[COUNTER_CONTACTS] / PACK + params->worlds;
}

static inline Vec3 dense_normal(global const ContactBlock* block, u32 lane) {
  return make3(block->normal_x[lane], block->normal_y[lane], block->normal_z[lane]);
}
static inline Vec3 dense_arm_a(global const ContactBlock* block, u32 lane) {
  return make3(block->arm_a_x[lane], block->arm_a_y[lane], block->arm_a_z[lane]);
}
static inline Vec3 dense_arm_b(global const ContactBlock* block, u32 lane) {
  return make3(block->arm_b_x[lane], block->arm_b_y[lane], block->arm_b_z[lane]);
}

// Contacts of a tile in lanes. Those that are missing stand where the first does, and belong to no body.
typedef struct DenseRows {
  LaneContact frame;
  lane_u32 body_a, body_b;
} DenseRows;

static inline void dense_load_rows(ContactTile tile, u32 first, global const Contact* contacts,
                                   global const u32* contact_slots, global const ContactBlock* contact_blocks,
                                   DenseRows* rows) {
  real n[3][LANES], arm_a[3][LANES], arm_b[3][LANES];
  u32 a[LANES], b[LANES];
  for (u32 k = 0u; k < LANES; ++k) {
    const bool there = first + k < tile.count;
    const u32 i = tile.first + (there ? first + k : 0u), slot = contact_slots[i];
    global const ContactBlock* block = contact_blocks + slot / PACK;
    const Vec3 normal = dense_normal(block, slot % PACK);
    const Vec3 to_a = dense_arm_a(block, slot % PACK), to_b = dense_arm_b(block, slot % PACK);
    n[0][k] = normal.x, n[1][k] = normal.y, n[2][k] = normal.z;
    arm_a[0][k] = to_a.x, arm_a[1][k] = to_a.y, arm_a[2][k] = to_a.z;
    arm_b[0][k] = to_b.x, arm_b[1][k] = to_b.y, arm_b[2][k] = to_b.z;
    a[k] = there ? contacts[i].body_a : NONE;
    b[k] = there ? contacts[i].body_b : NONE;
  }
  rows->frame = lane_frame(lane_make3(LANE_LOAD(n[0]), LANE_LOAD(n[1]), LANE_LOAD(n[2])),
                           lane_make3(LANE_LOAD(arm_a[0]), LANE_LOAD(arm_a[1]), LANE_LOAD(arm_a[2])),
                           lane_make3(LANE_LOAD(arm_b[0]), LANE_LOAD(arm_b[1]), LANE_LOAD(arm_b[2])));
  rows->body_a = LANE_LOAD_U32(a);
  rows->body_b = LANE_LOAD_U32(b);
}

// The velocities that an impulse gives the two bodies of a contact from rest.
typedef struct DenseMoved {
  Vec3 v_a, w_a, v_b, w_b;
} DenseMoved;

static inline DenseMoved dense_move(Vec3 impulse, Vec3 arm_a, Vec3 arm_b, const Motion a, const Motion b) {
  const Vec3 still = make3((real)0, (real)0, (real)0);
  DenseMoved moved = {still, still, still, still};
  if (a.inverse_mass > (real)0) {
    moved.v_a = add3(still, scale3(a.inverse_mass, impulse));
    moved.w_a = add3(still, apply_inverse_inertia(a, cross3(arm_a, impulse)));
  }
  if (b.inverse_mass > (real)0) {
    moved.v_b = sub3(still, scale3(b.inverse_mass, impulse));
    moved.w_b = sub3(still, apply_inverse_inertia(b, cross3(arm_b, impulse)));
  }
  return moved;
}

static inline Lane3 dense_splat(Vec3 a) { return lane_make3((lane)a.x, (lane)a.y, (lane)a.z); }

// Of the bodies on one side of the rows: the velocities of those that are body a or b of the column's contact.
static inline void dense_moved_side(lane_u32 bodies, u32 a, u32 b, DenseMoved moved, Lane3* v, Lane3* w) {
  const lane_mask is_a = LANE_MASK(bodies == (lane_u32)a), is_b = LANE_MASK(bodies == (lane_u32)b);
  const Lane3 still = lane_make3((lane)0, (lane)0, (lane)0);
  *v = lane_select3(is_a, dense_splat(moved.v_a), lane_select3(is_b, dense_splat(moved.v_b), still));
  *w = lane_select3(is_a, dense_splat(moved.w_a), lane_select3(is_b, dense_splat(moved.w_b), still));
}

// Whether any of the rows has a contact with the body, if that can move.
static inline bool dense_any_has(const DenseRows* rows, u32 body, const Motion motion) {
  const lane_u32 moving = (lane_u32)(motion.inverse_mass > (real)0 ? body : NONE - 1u);
  const lane_mask has = LANE_MASK((rows->body_a == moving) | (rows->body_b == moving));
  return LANE_ANY(has);
}

// Column k of a pair of tiles: the relative velocities of the rows, for an impulse of its contact along each axis.
static inline void dense_column(u32 k, u32 contact, u32 first, const DenseRows* rows, global const Contact* contacts,
                                global const u32* contact_slots, global const ContactBlock* contact_blocks,
                                global const Motion* motions, global DenseBlock* out) {
  const u32 slot = contact_slots[contact], a = contacts[contact].body_a, b = contacts[contact].body_b;
  const Motion motion_a = motions[a], motion_b = motions[b];
  if (!dense_any_has(rows, a, motion_a) && !dense_any_has(rows, b, motion_b)) {
    for (u32 i = 0u; i < 9u; ++i) LANE_STORE((lane)0, out->w[k][i / 3u][i % 3u] + first);
    return;
  }
  global const ContactBlock* block = contact_blocks + slot / PACK;
  const Vec3 arm_a = dense_arm_a(block, slot % PACK), arm_b = dense_arm_b(block, slot % PACK);
  Vec3 axes[3];
  axes[0] = dense_normal(block, slot % PACK);
  tangents(axes[0], &axes[1], &axes[2]);
  for (u32 j = 0u; j < 3u; ++j) {
    const DenseMoved moved = dense_move(axes[j], arm_a, arm_b, motion_a, motion_b);
    Lane3 v_a, w_a, v_b, w_b;
    dense_moved_side(rows->body_a, a, b, moved, &v_a, &w_a);
    dense_moved_side(rows->body_b, a, b, moved, &v_b, &w_b);
    const Lane3 u = lane_sub3(lane_add3(v_a, lane_cross3(w_a, rows->frame.arm_a)),
                              lane_add3(v_b, lane_cross3(w_b, rows->frame.arm_b)));
    LANE_STORE(lane_dot3(rows->frame.normal, u), out->w[k][0][j] + first);
    LANE_STORE(lane_dot3(rows->frame.tangent_1, u), out->w[k][1][j] + first);
    LANE_STORE(lane_dot3(rows->frame.tangent_2, u), out->w[k][2][j] + first);
  }
}

#endif
