// Products with J and with B = M^-1 J^T of the contacts of a scene in several layouts (bench/layouts_bench.cpp). A
// contact has the rows normal, tangent, tangent; a body the velocities v and w, a line of eight reals (v, -, w, -).
//   csr      block CSR: blocks of 3 x 6 (J) and 6 x 3 (B) one after another, row by row
//   sell     SELL-C-sigma of such blocks (Kreutzer et al. 2014), C = PACK block rows a chunk, entries in lanes
//   packed   what the solver keeps: the normal and two arms, PACK contacts a block; tangents are recomputed
//   colours  the same in the solver's order, for B: PACK pairs of one colour a block, which push their bodies in place
// Sums of csr and sell go through a row in the same order, so that both have the same bits.
#include "common.h"
#include "lanes.h"
#include "solve_contact.h"

typedef LANES_JOIN(REAL, 4) Real4;

#define LANE_GATHER(lines, first)                      \
  for (u32 k = 0u; k < LANES; ++k) at[k] = (first)[k]; \
  const LaneLines line = lane_gather_lines(lines, 1u, at)

// ---- u = J v --------------------------------------------------------------------------------------------------------

kernel void csr_times(global const u32* starts, global const u32* columns, global const real* values,
                      global const Real8* v, global real* u, u32 rows) {
  FOR_EACH(i, rows) {
    real u0 = (real)0, u1 = (real)0, u2 = (real)0;
    for (u32 e = starts[i]; e < starts[i + 1u]; ++e) {
      const Real8 x = v[columns[e]];
      global const real* m = values + 18u * e;
      u0 = u0 + m[0] * x.s0 + m[1] * x.s1 + m[2] * x.s2 + m[3] * x.s4 + m[4] * x.s5 + m[5] * x.s6;
      u1 = u1 + m[6] * x.s0 + m[7] * x.s1 + m[8] * x.s2 + m[9] * x.s4 + m[10] * x.s5 + m[11] * x.s6;
      u2 = u2 + m[12] * x.s0 + m[13] * x.s1 + m[14] * x.s2 + m[15] * x.s4 + m[16] * x.s5 + m[17] * x.s6;
    }
    u[3u * i] = u0, u[3u * i + 1u] = u1, u[3u * i + 2u] = u2;
  }
}

// Entry k of a block, of LANES rows.
#define ENTRY(k) LANE_LOAD(m + (k)*PACK)
#define ROW_TIMES(sum, k)                                                                                     \
  sum = sum + ENTRY(k) * line.c0 + ENTRY(k + 1) * line.c1 + ENTRY(k + 2) * line.c2 + ENTRY(k + 3) * line.c4 + \
        ENTRY(k + 4) * line.c5 + ENTRY(k + 5) * line.c6

kernel void sell_times(global const u32* starts, global const u32* columns, global const real* values,
                       global const Real8* v, global real* u, u32 chunks) {
  FOR_EACH(i, chunks * ITEMS_PER_BLOCK) {
    const u32 chunk = i / ITEMS_PER_BLOCK, first = i % ITEMS_PER_BLOCK * LANES;
    lane u0 = (lane)0, u1 = (lane)0, u2 = (lane)0;
    for (u32 e = starts[chunk]; e < starts[chunk + 1u]; ++e) {
      u32 at[LANES];
      LANE_GATHER(v, columns + e * PACK + first);
      global const real* m = values + 18u * PACK * e + first;
      ROW_TIMES(u0, 0);
      ROW_TIMES(u1, 6);
      ROW_TIMES(u2, 12);
    }
    global real* out = u + 3u * PACK * chunk + first;
    LANE_STORE(u0, out);
    LANE_STORE(u1, out + PACK);
    LANE_STORE(u2, out + 2u * PACK);
  }
}

typedef struct PackedBlock {
  u32 body_a[PACK], body_b[PACK];
  real normal_x[PACK], normal_y[PACK], normal_z[PACK];
  real arm_a_x[PACK], arm_a_y[PACK], arm_a_z[PACK], arm_b_x[PACK], arm_b_y[PACK], arm_b_z[PACK];
} PackedBlock;

static inline Lane3 velocity_at(LaneLines line, Lane3 arm) {
  return lane_add3(lane_make3(line.c0, line.c1, line.c2), lane_cross3(lane_make3(line.c4, line.c5, line.c6), arm));
}
static inline Lane3 velocity_of(global const Real8* v, global const u32* bodies, Lane3 arm) {
  u32 at[LANES];
  LANE_GATHER(v, bodies);
  return velocity_at(line, arm);
}

kernel void packed_times(global const PackedBlock* blocks, global const Real8* v, global real* u, u32 count) {
  FOR_EACH(i, count * ITEMS_PER_BLOCK) {
    const u32 first = i % ITEMS_PER_BLOCK * LANES;
    global const PackedBlock* block = blocks + i / ITEMS_PER_BLOCK;
    const LaneContact c = lane_frame(LANE_NORMAL(block, first), LANE_ARM_A(block, first), LANE_ARM_B(block, first));
    const Lane3 relative =
        lane_sub3(velocity_of(v, block->body_a + first, c.arm_a), velocity_of(v, block->body_b + first, c.arm_b));
    global real* out = u + 3u * PACK * (i / ITEMS_PER_BLOCK) + first;
    LANE_STORE(lane_dot3(c.normal, relative), out);
    LANE_STORE(lane_dot3(c.tangent_1, relative), out + PACK);
    LANE_STORE(lane_dot3(c.tangent_2, relative), out + 2u * PACK);
  }
}

// ---- v = B lambda ---------------------------------------------------------------------------------------------------
// Impulses are (normal, tangent, tangent, -) of each contact.

kernel void csr_gather(global const u32* starts, global const u32* columns, global const real* values,
                       global const Real4* impulses, global Real8* v, u32 rows) {
  FOR_EACH(i, rows) {
    real s[6] = {(real)0, (real)0, (real)0, (real)0, (real)0, (real)0};
    for (u32 e = starts[i]; e < starts[i + 1u]; ++e) {
      const Real4 r = impulses[columns[e]];
      global const real* m = values + 18u * e;
      for (u32 k = 0u; k < 6u; ++k) s[k] = s[k] + m[3u * k] * r.x + m[3u * k + 1u] * r.y + m[3u * k + 2u] * r.z;
    }
    v[i] = (Real8)(s[0], s[1], s[2], (real)0, s[3], s[4], s[5], (real)0);
  }
}

#define ROW_GATHER(sum, k) sum = sum + ENTRY(k) * r.x + ENTRY(k + 1) * r.y + ENTRY(k + 2) * r.z

// Impulses in lanes. A gather of 16 bytes each; what turns them into lanes is left to the compiler.
static inline Lane3 lane_impulses(global const Real4* impulses, global const u32* at) {
#if LANES == 1
  const Real4 r = impulses[*at];
  return lane_make3(r.x, r.y, r.z);
#else
  real x[LANES], y[LANES], z[LANES];
  for (u32 k = 0u; k < LANES; ++k) {
    const Real4 r = impulses[at[k]];
    x[k] = r.x, y[k] = r.y, z[k] = r.z;
  }
  return lane_make3(LANE_LOAD(x), LANE_LOAD(y), LANE_LOAD(z));
#endif
}

kernel void sell_gather(global const u32* starts, global const u32* columns, global const real* values,
                        global const Real4* impulses, global const u32* order, global Real8* v, u32 chunks, u32 rows) {
  FOR_EACH(i, chunks * ITEMS_PER_BLOCK) {
    const u32 chunk = i / ITEMS_PER_BLOCK, first = i % ITEMS_PER_BLOCK * LANES;
    lane s0 = (lane)0, s1 = (lane)0, s2 = (lane)0, s3 = (lane)0, s4 = (lane)0, s5 = (lane)0;
    for (u32 e = starts[chunk]; e < starts[chunk + 1u]; ++e) {
      const Lane3 r = lane_impulses(impulses, columns + e * PACK + first);
      global const real* m = values + 18u * PACK * e + first;
      ROW_GATHER(s0, 0);
      ROW_GATHER(s1, 3);
      ROW_GATHER(s2, 6);
      ROW_GATHER(s3, 9);
      ROW_GATHER(s4, 12);
      ROW_GATHER(s5, 15);
    }
    // the fourth real says which lanes are rows
    const lane there = LANE_LOAD_U32(order + chunk * PACK + first) < rows ? (lane)1 : (lane)0;
    LaneLines line;
    line.c0 = s0, line.c1 = s1, line.c2 = s2, line.c3 = there;
    line.c4 = s3, line.c5 = s4, line.c6 = s5, line.c7 = (lane)0;
    lane_scatter_movable(line, v, 1u, order + chunk * PACK + first);
  }
}

// What each contact pushes its bodies with, (impulse, -, moment, -), in the order in which the bodies add it up.
kernel void packed_push(global const PackedBlock* blocks, global const real* impulses, global const u32* slots,
                        global Real8* pushes, u32 count, u32 slot_count) {
  FOR_EACH(i, count * ITEMS_PER_BLOCK) {
    const u32 first = i % ITEMS_PER_BLOCK * LANES;
    global const PackedBlock* block = blocks + i / ITEMS_PER_BLOCK;
    global const real* in = impulses + 3u * PACK * (i / ITEMS_PER_BLOCK) + first;
    global const u32* slot = slots + 2u * PACK * (i / ITEMS_PER_BLOCK) + first;
    const LaneContact c = lane_frame(LANE_NORMAL(block, first), LANE_ARM_A(block, first), LANE_ARM_B(block, first));
    const Lane3 p =
        lane_add3(lane_add3(lane_scale3(LANE_LOAD(in), c.normal), lane_scale3(LANE_LOAD(in + PACK), c.tangent_1)),
                  lane_scale3(LANE_LOAD(in + 2u * PACK), c.tangent_2));
    for (u32 side = 0u; side < 2u; ++side) {
      const Lane3 push = side == 0u ? p : lane_scale3((lane)-1, p);
      const Lane3 moment = lane_cross3(side == 0u ? c.arm_a : c.arm_b, push);
      LaneLines line;
      line.c0 = push.x, line.c1 = push.y, line.c2 = push.z;
      line.c3 = LANE_LOAD_U32(slot + side * PACK) < slot_count ? (lane)1 : (lane)0;
      line.c4 = moment.x, line.c5 = moment.y, line.c6 = moment.z, line.c7 = (lane)0;
      lane_scatter_movable(line, pushes, 1u, slot + side * PACK);
    }
  }
}

// The inverse inertia of bodies, xx in their first line and the others in their second, times a moment.
static inline Lane3 apply_inverse_inertia(lane xx, LaneLines second, Lane3 m) {
  return lane_make3(xx * m.x + second.c2 * m.y + second.c3 * m.z, second.c2 * m.x + second.c0 * m.y + second.c4 * m.z,
                    second.c3 * m.x + second.c4 * m.y + second.c1 * m.z);
}

// Blocks of one colour: blocks[starts[k]] .. blocks[starts[k + 1]] are the contacts of the same PACK pairs.
kernel void colour_push(global const u32* starts, global const PackedBlock* blocks, global const real* impulses,
                        global Motion* motions, u32 begin, u32 count) {
  FOR_EACH(i, count * ITEMS_PER_BLOCK) {
    const u32 first = i % ITEMS_PER_BLOCK * LANES, k = begin + i / ITEMS_PER_BLOCK;
    global const u32* body_a = blocks[starts[k]].body_a + first;
    global const u32* body_b = blocks[starts[k]].body_b + first;
    LaneLines a = lane_gather(motions, 0u, body_a), b = lane_gather(motions, 0u, body_b);
    const LaneLines rest_a = lane_gather(motions, 1u, body_a), rest_b = lane_gather(motions, 1u, body_b);
    for (u32 row = starts[k]; row < starts[k + 1u]; ++row) {
      global const PackedBlock* block = blocks + row;
      global const real* in = impulses + 3u * PACK * row + first;
      const LaneContact c = lane_frame(LANE_NORMAL(block, first), LANE_ARM_A(block, first), LANE_ARM_B(block, first));
      const Lane3 p =
          lane_add3(lane_add3(lane_scale3(LANE_LOAD(in), c.normal), lane_scale3(LANE_LOAD(in + PACK), c.tangent_1)),
                    lane_scale3(LANE_LOAD(in + 2u * PACK), c.tangent_2));
      const Lane3 delta_w_a = apply_inverse_inertia(a.c7, rest_a, lane_cross3(c.arm_a, p));
      const Lane3 delta_w_b = apply_inverse_inertia(b.c7, rest_b, lane_cross3(c.arm_b, p));
      a.c0 += a.c3 * p.x, a.c1 += a.c3 * p.y, a.c2 += a.c3 * p.z;
      a.c4 += delta_w_a.x, a.c5 += delta_w_a.y, a.c6 += delta_w_a.z;
      b.c0 -= b.c3 * p.x, b.c1 -= b.c3 * p.y, b.c2 -= b.c3 * p.z;
      b.c4 -= delta_w_b.x, b.c5 -= delta_w_b.y, b.c6 -= delta_w_b.z;
    }
    lane_scatter_movable(a, (global Real8*)motions, 2u, body_a);
    lane_scatter_movable(b, (global Real8*)motions, 2u, body_b);
  }
}

// `inverses`: of each body 1 / m, and of the inverse inertia xx, yy, zz, xy, xz, yz.
kernel void packed_gather(global const u32* starts, global const Real8* pushes, global const Real8* inverses,
                          global Real8* v, u32 rows) {
  FOR_EACH(i, rows) {
    Real8 s = (Real8)0;
    for (u32 e = starts[i]; e < starts[i + 1u]; ++e) s = s + pushes[e];
    const Real8 m = inverses[i];
    v[i] = (Real8)(m.s0 * s.s0, m.s0 * s.s1, m.s0 * s.s2, (real)0, m.s1 * s.s4 + m.s4 * s.s5 + m.s5 * s.s6,
                   m.s4 * s.s4 + m.s2 * s.s5 + m.s6 * s.s6, m.s5 * s.s4 + m.s6 * s.s5 + m.s3 * s.s6, (real)0);
  }
}
