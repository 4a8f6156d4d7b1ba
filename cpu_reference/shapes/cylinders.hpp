// Cylinder against cylinder: which direction separates them best. kernels/shapes/cylinders.h is the twin.
#pragma once

#include "cpu_reference/shapes/cylinder.hpp"

namespace lockstep::reference {

/// Offers the better of the meetings along a unit normal and its opposite, which is that from centre to centre:
/// cylinders look the same from both ends. It is where a reaches farthest.
template <class real>
Meeting<real> cylinders_try(const Cylinder<real>& a, const Cylinder<real>& b, Meeting<real> best, Vec3<real> normal,
                            u32 frame, real tolerance) {
  const real apart = dot3(normal, sub3(a.center, b.center));
  const real gap = (apart < 0 ? -apart : apart) - cylinder_reach(a, normal) - cylinder_reach(b, normal);
  const Vec3<real> sensed = scale3(apart < 0 ? real(-1) : real(1), normal);
  const Vec3<real> on_a = cylinder_support(a, scale3(real(-1), sensed));
  return meeting_offer(best, gap, sensed, frame, on_a, sub3(on_a, scale3(gap, sensed)), tolerance);
}

/// Offers a rim of one of them and a line or rim of the other one; `offset` is how far the surface is from that line.
template <class real>
Meeting<real> cylinders_try_rim(const Cylinder<real>& a, const Cylinder<real>& b, Meeting<real> best,
                                const RimNearest<real>& rim, bool of_a, real offset, real tolerance) {
  if (!rim.found) return best;
  const real apart = dot3(rim.normal, sub3(a.center, b.center));
  const real gap = (apart < 0 ? -apart : apart) - cylinder_reach(a, rim.normal) - cylinder_reach(b, rim.normal);
  if (!(gap > meeting_least(best, tolerance))) return best;
  const Vec3<real> normal = scale3(apart < 0 ? real(-1) : real(1), rim.normal);
  // the bound may be met at other points than these
  const real off = dot3(normal, sub3(rim.on_rim, rim.on_other)) * (of_a ? real(1) : real(-1)) - offset - gap;
  if (off > real(100) * tolerance || off < real(-100) * tolerance) {
    const Vec3<real> on_a = cylinder_support(a, scale3(real(-1), normal));
    return meeting_offer(best, gap, normal, NORMAL_FIXED, on_a, cylinder_support(b, normal), tolerance);
  }
  const Vec3<real> other = add3(rim.on_other, scale3(of_a ? offset : -offset, normal));
  return meeting_offer(best, gap, normal, NORMAL_FIXED, of_a ? rim.on_rim : other, of_a ? other : rim.on_rim,
                       tolerance);
}

/// Across the axis of c, towards the other one; anywhere across where their centres are in line.
template <class real>
Vec3<real> cylinder_outwards(const Cylinder<real>& c, Vec3<real> apart) {
  const Vec3<real> across = cylinder_across(c, apart);
  const real length = length3(across);
  return length > 0 ? scale3(real(1) / length, across) : c.axes.x;
}

/// The best normal: of a cap, across both axes, across one of them, or the shortest line between a rim and the other
/// one's axis or rim.
template <class real>
Meeting<real> cylinders_meet(const Cylinder<real>& a, const Cylinder<real>& b, real limit, real tolerance) {
  const Vec3<real> apart = sub3(a.center, b.center);
  Meeting<real> best = cylinders_try(a, b, no_meeting<real>(), a.axes.z, NORMAL_OF_A, tolerance);
  best = cylinders_try(a, b, best, b.axes.z, NORMAL_OF_B, tolerance);
  const Vec3<real> across = cross3(a.axes.z, b.axes.z);
  const real length = length3(across);
  if (length > real(1e-5)) best = cylinders_try(a, b, best, scale3(real(1) / length, across), NORMAL_FIXED, tolerance);
  best = cylinders_try(a, b, best, cylinder_outwards(a, apart), NORMAL_FIXED, tolerance);
  best = cylinders_try(a, b, best, cylinder_outwards(b, apart), NORMAL_FIXED, tolerance);
  if (best.gap > limit) return best;
  for (u32 k = 0; k < 4; ++k) {
    const RimNearest<real> of_a = rim_line(a, k >> 1, cylinder_cap(b, 0), b.axes.z, real(2) * b.half_length, k & 1);
    best = cylinders_try_rim(a, b, best, of_a, true, b.radius, tolerance);
    const RimNearest<real> of_b = rim_line(b, k >> 1, cylinder_cap(a, 0), a.axes.z, real(2) * a.half_length, k & 1);
    best = cylinders_try_rim(a, b, best, of_b, false, a.radius, tolerance);
  }
  if (best.gap > limit) return best;
  // from either rim: one may see two places in a sixteenth of the other
  for (u32 k = 0; k < 64; ++k) {
    const RimNearest<real> of_a = rim_rim(a, k >> 5, b, k >> 4 & 1, k & 15);
    best = cylinders_try_rim(a, b, best, of_a, true, real(0), tolerance);
    const RimNearest<real> of_b = rim_rim(b, k >> 5, a, k >> 4 & 1, k & 15);
    best = cylinders_try_rim(a, b, best, of_b, false, real(0), tolerance);
  }
  return best;
}

}  // namespace lockstep::reference
