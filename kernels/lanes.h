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
#define LANE_AT(x, k) (x)
#define LANE_EACH(DO) DO(0)
#define LANE_BITS(mask) ((u32)(mask))

#else

typedef LANES_JOIN(REAL, LANES) lane;
typedef LANES_JOIN(uint, LANES) lane_u32;
#define LANE_LOAD(p) LANES_JOIN(vload, LANES)(0, p)
#define LANE_STORE(x, p) LANES_JOIN(vstore, LANES)(x, 0, p)
#define LANE_LOAD_U32(p) LANES_JOIN(vload, LANES)(0, p)
#define LANE_ANY(x) any(x)
#define LANE_AT(x, k) ((x).s##k)
#if LANES == 8
#define LANE_EACH(DO) DO(0) DO(1) DO(2) DO(3) DO(4) DO(5) DO(6) DO(7)
#else
#define LANE_EACH(DO) DO(0) DO(1) DO(2) DO(3) DO(4) DO(5) DO(6) DO(7) DO(8) DO(9) DO(a) DO(b) DO(c) DO(d) DO(e) DO(f)
#endif
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
typedef LANES_JOIN(long, LANES) lane_mask;
#define LANE_MASK(x) LANES_JOIN(convert_long, LANES)(x)
#else
typedef LANES_JOIN(int, LANES) lane_mask;
#define LANE_MASK(x) (x)
#endif

#endif

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
