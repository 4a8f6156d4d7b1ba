// One source, two widths: LANES = 1 makes a work-item one contact (GPU), 8 or 16 a row of contacts of one block held in
// vector registers (CPU device). Comparisons of lanes give a mask for `mask ? lane : lane`; constants are cast:
// (lane)0.
#ifndef LOCKSTEP_LANES_H
#define LOCKSTEP_LANES_H

#include "types.h"

#define LANES_JOIN_(a, b) a##b
#define LANES_JOIN(a, b) LANES_JOIN_(a, b)

typedef LANES_JOIN(REAL, 8) Real8;

#if LANES == 1

typedef real lane;
typedef u32 lane_u32;
typedef int lane_mask;
#define LANE_LOAD(p) (*(p))
#define LANE_STORE(x, p) (*(p) = (x))
#define LANE_LOAD_U32(p) (*(p))
#define LANE_MASK(x) (x)
#define LANE_ANY(x) (x)

#else

typedef LANES_JOIN(REAL, LANES) lane;
typedef LANES_JOIN(uint, LANES) lane_u32;
#define LANE_LOAD(p) LANES_JOIN(vload, LANES)(0, p)
#define LANE_STORE(x, p) LANES_JOIN(vstore, LANES)(x, 0, p)
#define LANE_LOAD_U32(p) LANES_JOIN(vload, LANES)(0, p)
#define LANE_ANY(x) any(x)
// A comparison of u32 lanes as a mask for lanes of reals.
#if REAL_IS_DOUBLE
typedef LANES_JOIN(long, LANES) lane_mask;
#define LANE_MASK(x) LANES_JOIN(convert_long, LANES)(x)
#else
typedef LANES_JOIN(int, LANES) lane_mask;
#define LANE_MASK(x) (x)
#endif

#endif

// Eight reals of memory in each lane.
typedef struct LaneLines {
  lane c0, c1, c2, c3, c4, c5, c6, c7;
} LaneLines;

// Of the elements of eight vectors, read as one array, first those of even and then those of odd place: the bits of a
// place are rotated by one. So the lines of bodies become lanes and back by vector shuffles; memory is touched in whole
// lines only.
#define LANE_UNZIP(from, to)                                                                                 \
  const lane to##0 = (lane)((from##0).even, (from##1).even), to##1 = (lane)((from##2).even, (from##3).even), \
             to##2 = (lane)((from##4).even, (from##5).even), to##3 = (lane)((from##6).even, (from##7).even), \
             to##4 = (lane)((from##0).odd, (from##1).odd), to##5 = (lane)((from##2).odd, (from##3).odd),     \
             to##6 = (lane)((from##4).odd, (from##5).odd), to##7 = (lane)((from##6).odd, (from##7).odd)

// Lane k gets a half of the line of body indices[k].
static inline LaneLines lane_gather(global const Motion* motions, u32 half_line, global const u32* indices) {
  LaneLines r;
#define LINE(k) ((global const Real8*)(motions + indices[k]))[half_line]
#if LANES == 1
  const Real8 t = LINE(0);
  r.c0 = t.s0, r.c1 = t.s1, r.c2 = t.s2, r.c3 = t.s3, r.c4 = t.s4, r.c5 = t.s5, r.c6 = t.s6, r.c7 = t.s7;
#else
#if LANES == 8
  const lane a0 = LINE(0), a1 = LINE(1), a2 = LINE(2), a3 = LINE(3);
  const lane a4 = LINE(4), a5 = LINE(5), a6 = LINE(6), a7 = LINE(7);
#else
  const lane a0 = (lane)(LINE(0), LINE(1)), a1 = (lane)(LINE(2), LINE(3)), a2 = (lane)(LINE(4), LINE(5));
  const lane a3 = (lane)(LINE(6), LINE(7)), a4 = (lane)(LINE(8), LINE(9)), a5 = (lane)(LINE(10), LINE(11));
  const lane a6 = (lane)(LINE(12), LINE(13)), a7 = (lane)(LINE(14), LINE(15));
#endif
  LANE_UNZIP(a, b);
  LANE_UNZIP(b, c);
  LANE_UNZIP(c, d);
  r.c0 = d0, r.c1 = d1, r.c2 = d2, r.c3 = d3, r.c4 = d4, r.c5 = d5, r.c6 = d6, r.c7 = d7;
#endif
#undef LINE
  return r;
}

// Writes back the first halves, but of the bodies that cannot move none: many lanes read them, and no order is kept
// among lanes. The fourth real is the inverse mass.
static inline void lane_scatter(LaneLines r, global Motion* motions, global const u32* indices) {
#define LINE(k, line) \
  if ((line).s3 > (real)0) *(global Real8*)(motions + indices[k]) = line;
#if LANES == 1
  LINE(0, (Real8)(r.c0, r.c1, r.c2, r.c3, r.c4, r.c5, r.c6, r.c7))
#else
  const lane a0 = r.c0, a1 = r.c1, a2 = r.c2, a3 = r.c3, a4 = r.c4, a5 = r.c5, a6 = r.c6, a7 = r.c7;
  LANE_UNZIP(a, b);
  LANE_UNZIP(b, c);
  LANE_UNZIP(c, d);
#if LANES == 8
  LINE(0, d0) LINE(1, d1) LINE(2, d2) LINE(3, d3) LINE(4, d4) LINE(5, d5) LINE(6, d6) LINE(7, d7)
#else
  LANE_UNZIP(d, e);
  LINE(0, e0.lo)
  LINE(1, e0.hi)
  LINE(2, e1.lo) LINE(3, e1.hi) LINE(4, e2.lo) LINE(5, e2.hi) LINE(6, e3.lo) LINE(7, e3.hi) LINE(8, e4.lo)
      LINE(9, e4.hi) LINE(10, e5.lo) LINE(11, e5.hi) LINE(12, e6.lo) LINE(13, e6.hi) LINE(14, e7.lo) LINE(15, e7.hi)
#endif
#endif
#undef LINE
}

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
static inline Lane3 lane_add3(Lane3 a, Lane3 b) { return lane_make3(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline Lane3 lane_sub3(Lane3 a, Lane3 b) { return lane_make3(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline Lane3 lane_scale3(lane s, Lane3 a) { return lane_make3(s * a.x, s * a.y, s * a.z); }
static inline lane lane_dot3(Lane3 a, Lane3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline Lane3 lane_cross3(Lane3 a, Lane3 b) {
  return lane_make3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

#endif
