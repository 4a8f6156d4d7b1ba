// The uniform grid of the broad phase, and how far shapes can come in a step. cpu_reference/grid.hpp is the twin.
#ifndef LOCKSTEP_GRID_H
#define LOCKSTEP_GRID_H

#include "math.h"

// Seconds of a whole step: contacts are found once for all its sub-steps.
static inline real step_length(const StepParams* params) { return params->dt * (real)params->substeps; }

// False for NaN, infinities and what is about to become one.
static inline bool is_finite(real x) { return fabs(x) <= (real)1e30; }

// Velocity of the point at `arm` from the centre of mass.
static inline Vec3 point_velocity(global const Motion* motion, Vec3 arm) {
  const Vec3 v = make3(motion->v[0], motion->v[1], motion->v[2]);
  const Vec3 w = make3(motion->w[0], motion->w[1], motion->w[2]);
  return add3(v, cross3(w, arm));
}

// A float that is no smaller than the extent, as bits: those of positive floats are ordered as integers are.
static inline u32 extent_bits(real extent) { return as_uint((float)extent * 1.000001f); }

// Raises the largest extent that a work-item has met; a body without a finite one leaves the grid.
static inline void note_extent(bool finite, real extent, u32 body, u32* largest, global u32* counters) {
  if (finite) {
    const u32 bits = extent_bits(extent);
    *largest = bits > *largest ? bits : *largest;
  } else {
    atomic_or(&counters[COUNTER_STATUS], (u32)STATUS_OUT_OF_GRID);
    atomic_max(&counters[COUNTER_BAD_BODY], NONE - body);
  }
}

// Two shapes that are to be paired are no farther apart than one cell, whatever their sizes and speeds. The factor
// covers the rounding of the pair test.
static inline real cell_size(u32 max_extent_bits) { return (real)2 * (real)as_float(max_extent_bits) * (real)1.0001; }

// How far the centres can be apart of a shape of this extent and of any that it is paired with.
static inline real pair_range(real extent, u32 max_extent_bits) {
  return (extent + (real)as_float(max_extent_bits)) * (real)1.0001;
}

// Cells are numbered as far as a real (and an i32) tells neighbours apart.
static inline bool in_grid(real x, real size) {
  return fabs(x / size) <= (sizeof(real) == 4 ? (real)8388608 : (real)1073741824);
}
static inline i32 cell_of(real x, real size) { return (i32)floor(x / size); }

// The cells of a row along x have buckets in a row, so that a search reads them as one list; rows are scattered.
static inline u32 row_hash(i32 y, i32 z, u32 world) {
  u32 h = (u32)y * 0x9e3779b1u + (u32)z * 0x85ebca77u + world * 0xc2b2ae3du;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return h ^ (h >> 15);
}
static inline u32 bucket_of(i32 x, u32 row, u32 buckets) { return (row + (u32)x) & (buckets - 1u); }

#endif
