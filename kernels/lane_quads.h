// Four neighbouring reals of a record in each lane, 16 bytes of floats: memory is touched in whole quads, which 4 x 4
// transpositions turn into lanes and back. They stay within the halves of eight lanes, and cost a third of the shuffles
// of whole lines (lanes.h).
#ifndef LOCKSTEP_LANE_QUADS_H
#define LOCKSTEP_LANE_QUADS_H

#include "called.h"
#include "lane_math.h"

// A call would pass lanes through memory. oclgrind, which runs without optimisation, knows no forced inlining
// (tests/golden/oclgrind).
#ifdef LANES_MAY_CALL
#define LANE_INLINE static inline
#else
#define LANE_INLINE static inline __attribute__((always_inline))
#endif
#if LANES == 1
#define LANE_CALLED CALLED
#else
#define LANE_CALLED LANE_INLINE
#endif

typedef LANES_JOIN(REAL, 4) Real4;

typedef struct LaneQuad {
  lane x, y, z, w;
} LaneQuad;

#if LANES == 1

LANE_INLINE LaneQuad lane_gather_quad(global const real* quads, u32 stride, const u32* indices) {
  const Real4 v = vload4(0, quads + (size_t)indices[0] * stride);
  const LaneQuad q = {v.x, v.y, v.z, v.w};
  return q;
}

LANE_INLINE void lane_keep_quad(LaneQuad q, real* kept) { vstore4((Real4)(q.x, q.y, q.z, q.w), 0, kept); }
LANE_INLINE Real4 lane_kept_quad(const real* kept, u32 k) { return vload4(k, kept); }

#else

// Of eight lanes; or rows, of which row i holds the quads of lanes i and i + 4.
typedef struct Quads8 {
  Real8 x, y, z, w;
} Quads8;

// Rows into lanes, or lanes into rows.
LANE_INLINE Quads8 transpose4(Quads8 m) {
  const Real8 xy = ZIP_FIRST(m.x, m.y), xy_last = ZIP_LAST(m.x, m.y);
  const Real8 zw = ZIP_FIRST(m.z, m.w), zw_last = ZIP_LAST(m.z, m.w);
  const Quads8 t = {PAIR_FIRST(xy, zw), PAIR_LAST(xy, zw), PAIR_FIRST(xy_last, zw_last), PAIR_LAST(xy_last, zw_last)};
  return t;
}

#define QUAD_AT(k) vload4(0, quads + (size_t)indices[k] * stride)
LANE_INLINE Quads8 gather_quads8(global const real* quads, u32 stride, const u32* indices) {
  const Quads8 rows = {(Real8)(QUAD_AT(0), QUAD_AT(4)), (Real8)(QUAD_AT(1), QUAD_AT(5)),
                       (Real8)(QUAD_AT(2), QUAD_AT(6)), (Real8)(QUAD_AT(3), QUAD_AT(7))};
  return transpose4(rows);
}

LANE_INLINE void keep_quads8(Quads8 quads, real* kept) {
  const Quads8 rows = transpose4(quads);
  vstore8(rows.x, 0, kept);
  vstore8(rows.y, 1, kept);
  vstore8(rows.z, 2, kept);
  vstore8(rows.w, 3, kept);
}

// Lane k gets the four reals at quads[indices[k] * stride]. A call, since where one of the four is not used the
// compiler would tear loads and shuffles apart.
LANE_INLINE LaneQuad lane_gather_quad(global const real* quads, u32 stride, const u32* indices) {
  const Quads8 first = gather_quads8(quads, stride, indices);
#if LANES == 8
  const LaneQuad q = {first.x, first.y, first.z, first.w};
#else
  const Quads8 last = gather_quads8(quads, stride, indices + 8);
  const LaneQuad q = {(lane)(first.x, last.x), (lane)(first.y, last.y), (lane)(first.z, last.z),
                      (lane)(first.w, last.w)};
#endif
  return q;
}

// Puts the quads of all lanes into 4 * LANES reals, from which each can be had as a whole.
LANE_INLINE void lane_keep_quad(LaneQuad q, real* kept) {
#if LANES == 8
  const Quads8 all = {q.x, q.y, q.z, q.w};
  keep_quads8(all, kept);
#else
  const Quads8 first = {q.x.lo, q.y.lo, q.z.lo, q.w.lo}, last = {q.x.hi, q.y.hi, q.z.hi, q.w.hi};
  keep_quads8(first, kept);
  keep_quads8(last, kept + 32);
#endif
}
LANE_INLINE Real4 lane_kept_quad(const real* kept, u32 k) {
  return vload4((k & ~7u) + 2u * (k & 3u) + (k >> 2 & 1u), kept);
}

#endif

LANE_INLINE Lane3 lane_xyz(LaneQuad q) { return lane_make3(q.x, q.y, q.z); }
LANE_INLINE LaneQuat lane_quat(LaneQuad q) {
  const LaneQuat quat = {q.x, q.y, q.z, q.w};
  return quat;
}

#endif
