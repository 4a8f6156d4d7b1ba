// Cylinders against planes, spheres and each other. cpu_reference/shapes/cylinders.hpp is the twin.
#ifndef LOCKSTEP_CYLINDERS_H
#define LOCKSTEP_CYLINDERS_H

#include "shapes/cylinder_polytope.h"

// The cap, or the line on the side, that lies on the plane.
static inline Manifold cylinder_plane(Placed a, Placed b, real limit) {
  const Cylinder cylinder = cylinder_of(a);
  Meeting meeting = no_meeting();
  meeting.normal = plane_normal(b.rotation);
  meeting.frame = NORMAL_OF_B;
  meeting.at_a = cylinder_support(&cylinder, scale3((real)-1, meeting.normal));
  meeting.gap = dot3(meeting.normal, sub3(meeting.at_a, b.center));
  meeting.at_b = sub3(meeting.at_a, scale3(meeting.gap, meeting.normal));
  if (meeting.gap > limit) return no_manifold();
  const Patch patch_a = cylinder_patch(a, cylinder.axes, (real)-1, meeting.normal);
  const Patch patch_b = plane_patch(b.center, meeting.normal);
  return share_patches(&patch_a, &patch_b, cylinder_rolls(&cylinder, meeting.normal), (real)0, &meeting, limit,
                       shape_tolerance(a, b), length3(a.size));
}

// The closest point of the cylinder; from inside, through the nearer of cap and side.
static inline Manifold sphere_cylinder(Placed a, Placed b) {
  const Cylinder c = cylinder_of(b);
  const Vec3 d = sub3(a.center, b.center);
  const real height = dot3(c.axes.z, d);
  const Vec3 across = cylinder_across(&c, d);
  const real rho = length3(across);
  const Vec3 radial = rho > (real)0 ? scale3((real)1 / rho, across) : c.axes.x;
  const Vec3 cap = scale3(height < (real)0 ? (real)-1 : (real)1, c.axes.z);
  const real over_cap = (height < (real)0 ? -height : height) - c.half_length, over_side = rho - c.radius;
  if (over_cap > (real)0 && over_side > (real)0) {
    const Vec3 on_rim = add3(b.center, add3(scale3(c.half_length, cap), scale3(c.radius, radial)));
    const Vec3 normal = direction_between(a.center, on_rim, length3(b.size), radial);
    return manifold_at(normal, NORMAL_FIXED, a.center, a.size.x, on_rim, (real)0, 0);
  }
  if (over_cap > over_side)
    return manifold_at(cap, NORMAL_OF_B, a.center, a.size.x, sub3(a.center, scale3(over_cap, cap)), (real)0, 0);
  const Vec3 on_axis = add3(b.center, scale3(height, c.axes.z));
  return manifold_at(radial, NORMAL_FIXED, a.center, a.size.x, on_axis, c.radius, 0);
}

// Offers the better of the meetings along a unit normal and its opposite, which is that from centre to centre:
// cylinders look the same from both ends. It is where a reaches farthest.
static inline Meeting cylinders_try(const Cylinder* a, const Cylinder* b, Meeting best, Vec3 normal, u32 frame,
                                    real tolerance) {
  const real apart = dot3(normal, sub3(a->center, b->center));
  const real gap = (apart < (real)0 ? -apart : apart) - cylinder_reach(a, normal) - cylinder_reach(b, normal);
  const Vec3 sensed = scale3(apart < (real)0 ? (real)-1 : (real)1, normal);
  const Vec3 on_a = cylinder_support(a, scale3((real)-1, sensed));
  return meeting_offer(best, gap, sensed, frame, on_a, sub3(on_a, scale3(gap, sensed)), tolerance);
}

// Offers a rim of one of them and a line or rim of the other one; `offset` is how far the surface is from that line.
static inline Meeting cylinders_try_rim(const Cylinder* a, const Cylinder* b, Meeting best, const RimNearest* rim,
                                        bool of_a, real offset, real tolerance) {
  if (!rim->found) return best;
  const real apart = dot3(rim->normal, sub3(a->center, b->center));
  const real gap = (apart < (real)0 ? -apart : apart) - cylinder_reach(a, rim->normal) - cylinder_reach(b, rim->normal);
  if (!(gap > meeting_least(&best, tolerance))) return best;
  const Vec3 normal = scale3(apart < (real)0 ? (real)-1 : (real)1, rim->normal);
  // the bound may be met at other points than these
  const real off = dot3(normal, sub3(rim->on_rim, rim->on_other)) * (of_a ? (real)1 : (real)-1) - offset - gap;
  if (off > (real)100 * tolerance || off < (real)-100 * tolerance) {
    const Vec3 on_a = cylinder_support(a, scale3((real)-1, normal));
    return meeting_offer(best, gap, normal, NORMAL_FIXED, on_a, cylinder_support(b, normal), tolerance);
  }
  const Vec3 other = add3(rim->on_other, scale3(of_a ? offset : -offset, normal));
  return meeting_offer(best, gap, normal, NORMAL_FIXED, of_a ? rim->on_rim : other, of_a ? other : rim->on_rim,
                       tolerance);
}

// Across the axis of c, towards the other one; anywhere across where their centres are in line.
static inline Vec3 cylinder_outwards(const Cylinder* c, Vec3 apart) {
  const Vec3 across = cylinder_across(c, apart);
  const real length = length3(across);
  return length > (real)0 ? scale3((real)1 / length, across) : c->axes.x;
}

// The best normal: of a cap, across both axes, across one of them, or the shortest line between a rim and the other
// one's axis or rim.
static inline Meeting cylinders_meet(const Cylinder* a, const Cylinder* b, real limit, real tolerance) {
  const Vec3 apart = sub3(a->center, b->center);
  Meeting best = cylinders_try(a, b, no_meeting(), a->axes.z, NORMAL_OF_A, tolerance);
  best = cylinders_try(a, b, best, b->axes.z, NORMAL_OF_B, tolerance);
  const Vec3 across = cross3(a->axes.z, b->axes.z);
  const real length = length3(across);
  if (length > (real)1e-5) best = cylinders_try(a, b, best, scale3((real)1 / length, across), NORMAL_FIXED, tolerance);
  best = cylinders_try(a, b, best, cylinder_outwards(a, apart), NORMAL_FIXED, tolerance);
  best = cylinders_try(a, b, best, cylinder_outwards(b, apart), NORMAL_FIXED, tolerance);
  if (best.gap > limit) return best;
  for (u32 k = 0; k < 4; ++k) {
    const RimNearest of_a = rim_line(a, k >> 1, cylinder_cap(b, 0), b->axes.z, (real)2 * b->half_length, k & 1);
    best = cylinders_try_rim(a, b, best, &of_a, true, b->radius, tolerance);
    const RimNearest of_b = rim_line(b, k >> 1, cylinder_cap(a, 0), a->axes.z, (real)2 * a->half_length, k & 1);
    best = cylinders_try_rim(a, b, best, &of_b, false, a->radius, tolerance);
  }
  if (best.gap > limit) return best;
  // from either rim: one may see two places in a sixteenth of the other
  for (u32 k = 0; k < 64; ++k) {
    const RimNearest of_a = rim_rim(a, k >> 5, b, k >> 4 & 1, k & 15);
    best = cylinders_try_rim(a, b, best, &of_a, true, (real)0, tolerance);
    const RimNearest of_b = rim_rim(b, k >> 5, a, k >> 4 & 1, k & 15);
    best = cylinders_try_rim(a, b, best, &of_b, false, (real)0, tolerance);
  }
  return best;
}

static inline Manifold cylinder_cylinder(Placed a, Placed b, real limit) {
  const Cylinder one = cylinder_of(a), other = cylinder_of(b);
  const real tolerance = shape_tolerance(a, b);
  const Meeting meeting = cylinders_meet(&one, &other, limit, tolerance);
  if (meeting.gap > limit) return no_manifold();
  const Patch patch_a = cylinder_patch(a, one.axes, (real)-1, meeting.normal);
  const Patch patch_b = cylinder_patch(b, other.axes, (real)1, meeting.normal);
  return share_patches(&patch_a, &patch_b, cylinder_rolls(&one, meeting.normal), cylinder_rolls(&other, meeting.normal),
                       &meeting, limit, tolerance, smaller_size(a, b));
}

#endif
