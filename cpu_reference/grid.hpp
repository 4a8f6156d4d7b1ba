// The uniform grid of the broad phase, and how far shapes can come in a step. kernels/grid.h is the twin.
#pragma once

#include <algorithm>
#include <bit>
#include <vector>

#include "cpu_reference/shapes/manifold.hpp"

namespace lockstep::reference {

/// Seconds of a whole step: contacts are found once for all its sub-steps.
template <class real>
real step_length(const StepParams<real>& params) {
  return params.dt * real(params.substeps);
}

/// False for NaN, infinities and what is about to become one.
template <class real>
bool is_finite(real x) {
  return std::abs(x) <= real(1e30);
}

/// Velocity of the point at `arm` from the centre of mass.
template <class real, template <class> class Moving>
Vec3<real> point_velocity(const Moving<real>& motion, Vec3<real> arm) {
  return add3(vec3(motion.v), cross3(vec3(motion.w), arm));
}

/// A float that is no smaller than the extent, as bits: those of positive floats are ordered as integers are.
template <class real>
u32 extent_bits(real extent) {
  return std::bit_cast<u32>(float(extent) * 1.000001f);
}

/// Raises the largest extent; a body without a finite one leaves the grid.
template <class real>
void note_extent(bool finite, real extent, u32 body, std::vector<u32>& counters) {
  if (finite) {
    counters[COUNTER_MAX_EXTENT] = std::max(counters[COUNTER_MAX_EXTENT], extent_bits(extent));
  } else {
    counters[COUNTER_STATUS] |= STATUS_OUT_OF_GRID;
    counters[COUNTER_BAD_BODY] = std::max(counters[COUNTER_BAD_BODY], NONE - body);
  }
}

/// Two shapes that are to be paired are no farther apart than one cell, whatever their sizes and speeds. The factor
/// covers the rounding of the pair test.
template <class real>
real cell_size(u32 max_extent_bits) {
  return real(2) * real(std::bit_cast<float>(max_extent_bits)) * real(1.0001);
}

/// How far the centres can be apart of a shape of this extent and of any that it is paired with.
template <class real>
real pair_range(real extent, u32 max_extent_bits) {
  return (extent + real(std::bit_cast<float>(max_extent_bits))) * real(1.0001);
}

/// Cells are numbered as far as a real (and an i32) tells neighbours apart.
template <class real>
bool in_grid(real x, real size) {
  return std::abs(x / size) <= (sizeof(real) == 4 ? real(8388608) : real(1073741824));
}
template <class real>
i32 cell_of(real x, real size) {
  return i32(std::floor(x / size));
}

/// The cells of a row along x have buckets in a row, so that a search reads them as one list; rows are scattered.
inline u32 row_hash(i32 y, i32 z, u32 world) {
  u32 h = u32(y) * 0x9e3779b1u + u32(z) * 0x85ebca77u + world * 0xc2b2ae3du;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return h ^ (h >> 15);
}
inline u32 bucket_of(i32 x, u32 row, u32 buckets) { return (row + u32(x)) & (buckets - 1); }

}  // namespace lockstep::reference
