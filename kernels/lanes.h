// One source, two widths: LANES = 1 makes a work-item one pair in contact (GPU), 8 or 16 as many pairs of one block,
// held in vector registers (CPU device). Comparisons of lanes give a mask for `mask ? lane : lane`; constants are cast:
// (lane)0.
#ifndef LOCKSTEP_LANES_H
#define LOCKSTEP_LANES_H

#include "types.h"

#define LANES_JOIN_(a, b) a##b
#define LANES_JOIN(a, b) LANES_JOIN_(a, b)

// Work-items that a block of PACK lanes gives.
#define ITEMS_PER_BLOCK (PACK / LANES)

typedef LANES_JOIN(REAL, 8) Real8;
typedef LANES_JOIN(REAL, 16) Real16;

#if LANES == 1

typedef real lane;
typedef u32 lane_u32;
typedef int lane_mask;
#define LANE_LOAD(p) (*(p))
#define LANE_STORE(x, p) (*(p) = (x))
#define LANE_LOAD_U32(p) (*(p))
#define LANE_MASK(x) (x)
#define LANE_ANY(x) (x)
#define LANE_BITS(mask) ((u32)(mask))

#else

typedef LANES_JOIN(REAL, LANES) lane;
typedef LANES_JOIN(uint, LANES) lane_u32;
#define LANE_LOAD(p) LANES_JOIN(vload, LANES)(0, p)
#define LANE_STORE(x, p) LANES_JOIN(vstore, LANES)(x, 0, p)
#define LANE_LOAD_U32(p) LANES_JOIN(vload, LANES)(0, p)
// Bit k of a word is lane k of a mask.
#define LANE_BITS(mask) lane_bits(LANES_JOIN(convert_int, LANES)(mask))
static inline u32 lane_bits(LANES_JOIN(int, LANES) mask) {
#if LANES == 8
  const int8 bits8 = mask & (int8)(1, 2, 4, 8, 16, 32, 64, 128);
#else
  const int16 bits16 = mask & (int16)(1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768);
  const int8 bits8 = bits16.lo | bits16.hi;
#endif
  const int4 bits4 = bits8.lo | bits8.hi;
  const int2 bits2 = bits4.lo | bits4.hi;
  return (u32)(bits2.x | bits2.y);
}
// A comparison of u32 lanes as a mask for lanes of reals.
#if REAL_IS_DOUBLE
#define LANE_INT(n) LANES_JOIN(long, n)
#define LANE_MASK(x) LANES_JOIN(convert_long, LANES)(x)
#else
#define LANE_INT(n) LANES_JOIN(int, n)
#define LANE_MASK(x) (x)
#endif
typedef LANE_INT(LANES) lane_mask;
// pocl makes a jump for each pair of lanes of any() and all().
static inline bool any8(LANE_INT(8) mask) {
  const LANE_INT(4) bits4 = mask.lo | mask.hi;
  const LANE_INT(2) bits2 = bits4.lo | bits4.hi;
  return (bits2.x | bits2.y) != 0;
}
#if LANES == 8
#define LANE_ANY(mask) any8(mask)
#else
#define LANE_ANY(mask) lane_any(mask)
static inline bool lane_any(lane_mask mask) { return any8(mask.lo | mask.hi); }
#endif

#endif

// The largest lane.
static inline real lane_largest(lane x) {
#if LANES == 1
  return x;
#else
#if LANES == 16
  const Real8 x8 = x.lo > x.hi ? x.lo : x.hi;
#else
  const Real8 x8 = x;
#endif
  const LANES_JOIN(REAL, 4) x4 = x8.lo > x8.hi ? x8.lo : x8.hi;
  const LANES_JOIN(REAL, 2) x2 = x4.lo > x4.hi ? x4.lo : x4.hi;
  return x2.x > x2.y ? x2.x : x2.y;
#endif
}

// ---- lines of bodies ----------------------------------------------------------------------------------------------
// Half a body line in each lane. Memory is touched in whole half lines, which vector shuffles turn into lanes and back:
// 8 x 8 transpositions, of which the compiler makes short code (it would scalarise a gather of single components).

typedef struct LaneLines {
  lane c0, c1, c2, c3, c4, c5, c6, c7;
} LaneLines;

#define LINE(k) lines[indices[k] * stride]

#if LANES == 1

static inline LaneLines lane_gather_lines(global const Real8* lines, u32 stride, const u32* indices) {
  const Real8 line = LINE(0);
  LaneLines r;
  r.c0 = line.s0, r.c1 = line.s1, r.c2 = line.s2, r.c3 = line.s3;
  r.c4 = line.s4, r.c5 = line.s5, r.c6 = line.s6, r.c7 = line.s7;
  return r;
}

static inline void lane_scatter_movable(LaneLines r, global Real8* lines, u32 stride, global const u32* indices) {
  if (r.c3 > (real)0) LINE(0) = (Real8)(r.c0, r.c1, r.c2, r.c3, r.c4, r.c5, r.c6, r.c7);
}

#else

typedef struct Rows8 {
  Real8 r0, r1, r2, r3, r4, r5, r6, r7;
} Rows8;

// In each half of four: the first or last two elements of a and b in turn, or in pairs.
#define ZIP_FIRST(a, b) ((Real16)(a, b)).s08194c5d
#define ZIP_LAST(a, b) ((Real16)(a, b)).s2a3b6e7f
#define PAIR_FIRST(a, b) ((Real16)(a, b)).s018945cd
#define PAIR_LAST(a, b) ((Real16)(a, b)).s23ab67ef

static inline Rows8 transpose8(Rows8 m) {
  const Real8 u0 = ZIP_FIRST(m.r0, m.r1), u1 = ZIP_LAST(m.r0, m.r1);
  const Real8 u2 = ZIP_FIRST(m.r2, m.r3), u3 = ZIP_LAST(m.r2, m.r3);
  const Real8 u4 = ZIP_FIRST(m.r4, m.r5), u5 = ZIP_LAST(m.r4, m.r5);
  const Real8 u6 = ZIP_FIRST(m.r6, m.r7), u7 = ZIP_LAST(m.r6, m.r7);
  const Real8 v0 = PAIR_FIRST(u0, u2), v1 = PAIR_LAST(u0, u2), v2 = PAIR_FIRST(u1, u3), v3 = PAIR_LAST(u1, u3);
  const Real8 v4 = PAIR_FIRST(u4, u6), v5 = PAIR_LAST(u4, u6), v6 = PAIR_FIRST(u5, u7), v7 = PAIR_LAST(u5, u7);
  Rows8 t;
  t.r0 = (Real8)(v0.lo, v4.lo), t.r1 = (Real8)(v1.lo, v5.lo);
  t.r2 = (Real8)(v2.lo, v6.lo), t.r3 = (Real8)(v3.lo, v7.lo);
  t.r4 = (Real8)(v0.hi, v4.hi), t.r5 = (Real8)(v1.hi, v5.hi);
  t.r6 = (Real8)(v2.hi, v6.hi), t.r7 = (Real8)(v3.hi, v7.hi);
  return t;
}

// Components of eight lines.
static inline Rows8 gather8(global const Real8* lines, u32 stride, const u32* indices) {
  Rows8 m;
  m.r0 = LINE(0), m.r1 = LINE(1), m.r2 = LINE(2), m.r3 = LINE(3);
  m.r4 = LINE(4), m.r5 = LINE(5), m.r6 = LINE(6), m.r7 = LINE(7);
  return transpose8(m);
}

static inline void scatter8(Rows8 components, global Real8* lines, u32 stride, global const u32* indices) {
  const Rows8 m = transpose8(components);
  if (!any8(!(components.r3 > (Real8)0))) {
    LINE(0) = m.r0, LINE(1) = m.r1, LINE(2) = m.r2, LINE(3) = m.r3;
    LINE(4) = m.r4, LINE(5) = m.r5, LINE(6) = m.r6, LINE(7) = m.r7;
  } else {
    if (m.r0.s3 > (real)0) LINE(0) = m.r0;
    if (m.r1.s3 > (real)0) LINE(1) = m.r1;
    if (m.r2.s3 > (real)0) LINE(2) = m.r2;
    if (m.r3.s3 > (real)0) LINE(3) = m.r3;
    if (m.r4.s3 > (real)0) LINE(4) = m.r4;
    if (m.r5.s3 > (real)0) LINE(5) = m.r5;
    if (m.r6.s3 > (real)0) LINE(6) = m.r6;
    if (m.r7.s3 > (real)0) LINE(7) = m.r7;
  }
}

// Lane k gets the eight reals of lines[indices[k] * stride].
static inline LaneLines lane_gather_lines(global const Real8* lines, u32 stride, const u32* indices) {
  const Rows8 x = gather8(lines, stride, indices);
  LaneLines r;
#if LANES == 8
  r.c0 = x.r0, r.c1 = x.r1, r.c2 = x.r2, r.c3 = x.r3, r.c4 = x.r4, r.c5 = x.r5, r.c6 = x.r6, r.c7 = x.r7;
#else
  const Rows8 y = gather8(lines, stride, indices + 8);
  r.c0 = (lane)(x.r0, y.r0), r.c1 = (lane)(x.r1, y.r1), r.c2 = (lane)(x.r2, y.r2), r.c3 = (lane)(x.r3, y.r3);
  r.c4 = (lane)(x.r4, y.r4), r.c5 = (lane)(x.r5, y.r5), r.c6 = (lane)(x.r6, y.r6), r.c7 = (lane)(x.r7, y.r7);
#endif
  return r;
}

// Writes lines[indices[k] * stride] of the bodies that can move: those belong to one lane alone. The others, whose
// inverse mass, the fourth real, is zero, are read by many and never written.
static inline void lane_scatter_movable(LaneLines r, global Real8* lines, u32 stride, global const u32* indices) {
  Rows8 m;
#if LANES == 8
  m.r0 = r.c0, m.r1 = r.c1, m.r2 = r.c2, m.r3 = r.c3, m.r4 = r.c4, m.r5 = r.c5, m.r6 = r.c6, m.r7 = r.c7;
  scatter8(m, lines, stride, indices);
#else
  m.r0 = r.c0.lo, m.r1 = r.c1.lo, m.r2 = r.c2.lo, m.r3 = r.c3.lo;
  m.r4 = r.c4.lo, m.r5 = r.c5.lo, m.r6 = r.c6.lo, m.r7 = r.c7.lo;
  scatter8(m, lines, stride, indices);
  m.r0 = r.c0.hi, m.r1 = r.c1.hi, m.r2 = r.c2.hi, m.r3 = r.c3.hi;
  m.r4 = r.c4.hi, m.r5 = r.c5.hi, m.r6 = r.c6.hi, m.r7 = r.c7.hi;
  scatter8(m, lines, stride, indices + 8);
#endif
}

#endif

// Lane k gets a half of the line of body indices[k].
static inline LaneLines lane_gather(global const Motion* motions, u32 half_line, global const u32* indices) {
  u32 bodies[LANES];
  for (u32 k = 0u; k < LANES; ++k) bodies[k] = indices[k];
  return lane_gather_lines((global const Real8*)motions + half_line, sizeof(Motion) / sizeof(Real8), bodies);
}

// ---- the larger and the less --------------------------------------------------------------------------------------

// In each lane, of x and what was found so far; an x that is no number does not count.
static inline lane lane_larger(lane x, lane so_far) { return x > so_far ? x : so_far; }
static inline lane lane_less(lane x, lane so_far) { return x < so_far ? x : so_far; }

// ---- vectors ------------------------------------------------------------------------------------------------------

// A vector in each lane.
typedef struct Lane3 {
  lane x, y, z;
} Lane3;

static inline Lane3 lane_make3(lane x, lane y, lane z) {
  Lane3 v;
  v.x = x;
  v.y = y;
  v.z = z;
  return v;
}
static inline void lane_store_where(lane_mask there, lane x, global real* p) { LANE_STORE(there ? x : (lane)0, p); }
static inline Lane3 lane_load_xyz(global const real* x, global const real* y, global const real* z) {
  return lane_make3(LANE_LOAD(x), LANE_LOAD(y), LANE_LOAD(z));
}
static inline Lane3 lane_add3(Lane3 a, Lane3 b) { return lane_make3(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline Lane3 lane_sub3(Lane3 a, Lane3 b) { return lane_make3(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline Lane3 lane_scale3(lane s, Lane3 a) { return lane_make3(s * a.x, s * a.y, s * a.z); }
static inline Lane3 lane_select3(lane_mask mask, Lane3 a, Lane3 b) {
  return lane_make3(mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z);
}
static inline lane lane_dot3(Lane3 a, Lane3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline Lane3 lane_cross3(Lane3 a, Lane3 b) {
  return lane_make3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

#endif
