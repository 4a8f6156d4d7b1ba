// Cylinder against cylinder: which direction separates them best. cpu_reference/shapes/cylinders.hpp is the twin.
#ifndef LOCKSTEP_CYLINDERS_H
#define LOCKSTEP_CYLINDERS_H

#include "shapes/cylinder.h"

// A normal from b to a and the separation along it: a lower bound of the true one.
typedef struct CylinderBound {
  real gap;
  Vec3 normal;
} CylinderBound;

// Along a unit normal or its opposite.
static inline CylinderBound cylinders_bound(const Cylinder* a, const Cylinder* b, Vec3 normal) {
  const real axis_offset = dot3(normal, sub3(a->center, b->center));
  CylinderBound bound;
  bound.gap =
      (axis_offset < (real)0 ? -axis_offset : axis_offset) - cylinder_extent(a, normal) - cylinder_extent(b, normal);
  bound.normal = scale3(axis_offset < (real)0 ? (real)-1 : (real)1, normal);
  return bound;
}

// Offers the better of the meetings along a unit normal and its opposite, which is that from centre to centre:
// cylinders look the same from both ends. It is where a reaches farthest.
CALLED Meeting cylinders_try(const Cylinder* a, const Cylinder* b, Meeting best, Vec3 normal, u32 frame,
                             real tolerance) {
  const CylinderBound bound = cylinders_bound(a, b, normal);
  const Vec3 on_a = cylinder_support(a, scale3((real)-1, bound.normal));
  const Vec3 on_b = sub3(on_a, scale3(bound.gap, bound.normal));
  return meeting_offer(best, bound.gap, bound.normal, frame, on_a, on_b, tolerance);
}

// Offers a rim of one of them and a line or rim of the other one; `offset` is how far the surface is from that line.
CALLED Meeting cylinders_try_rim(const Cylinder* a, const Cylinder* b, Meeting best, const RimNearest* rim, bool of_a,
                                 real offset, real tolerance) {
  if (!rim->found) return best;
  const CylinderBound bound = cylinders_bound(a, b, rim->normal);
  const real gap = bound.gap;
  if (!(gap > meeting_least(&best, tolerance))) return best;
  const Vec3 normal = bound.normal;
  // the bound may be met at other points than these: they say where only if the normal is better, too
  const real off = dot3(normal, sub3(rim->on_rim, rim->on_other)) * (of_a ? (real)1 : (real)-1) - offset - gap;
  if (off > (real)100 * tolerance || off < (real)-100 * tolerance) {
    if (!(gap > best.gap + tolerance)) return best;
    const Vec3 on_a = cylinder_support(a, scale3((real)-1, normal));
    return meeting_offer(best, gap, normal, NORMAL_FIXED, on_a, cylinder_support(b, normal), tolerance);
  }
  const Vec3 other = add3(rim->on_other, scale3(of_a ? offset : -offset, normal));
  return meeting_offer(best, gap, normal, NORMAL_FIXED, of_a ? rim->on_rim : other, of_a ? other : rim->on_rim,
                       tolerance);
}

// Steps of Newton's method, shorter ones where they led down.
#define CYLINDER_CLIMBS 10u

// Climbs to where the bound is greatest nearby, on two rims: there it is bent along their tangents.
static inline CylinderBound cylinders_climb(const Cylinder* a, const Cylinder* b, CylinderBound from) {
  CylinderBound best = from;
  real share = (real)1;
  for (u32 k = 0; k < CYLINDER_CLIMBS; ++k) {
    const Vec3 n = best.normal;
    const Vec3 tangent_a = cross3(a->axes.z, n), tangent_b = cross3(b->axes.z, n);
    const real rho_a = length3(tangent_a), rho_b = length3(tangent_b);
    if (!(rho_a > (real)1e-4) || !(rho_b > (real)1e-4)) break;
    const Vec3 across = sub3(cylinder_support(a, scale3((real)-1, n)), cylinder_support(b, n));
    const Vec3 x = scale3((real)1 / rho_a, tangent_a), y = cross3(n, x);
    const Vec3 t = scale3((real)1 / rho_b, tangent_b);
    const real bend_a = a->radius / rho_a, bend_b = b->radius / rho_b;
    const real tx = dot3(x, t), ty = dot3(y, t), gx = dot3(x, across), gy = dot3(y, across);
    real xx = bend_a + bend_b * tx * tx + best.gap, yy = bend_b * ty * ty + best.gap;
    const real xy = bend_b * tx * ty;
    real det = xx * yy - xy * xy;
    if (!(det > (real)0) || !(xx > (real)0)) {  // not a hilltop: a step that leads up all the same
      xx = xx - (real)2 * best.gap;
      yy = yy - (real)2 * best.gap;
      det = xx * yy - xy * xy;
    }
    if (!(det > (real)0)) break;
    const real dx = share * (yy * gx - xy * gy) / det, dy = share * (xx * gy - xy * gx) / det;
    const real far = sqrt(dx * dx + dy * dy), most = (real)0.5;
    if (!(far > (real)1e-6)) break;  // arrived
    const real shorten = far > most ? most / far : (real)1;
    const Vec3 moved = add3(n, add3(scale3(shorten * dx, x), scale3(shorten * dy, y)));
    const CylinderBound next = cylinders_bound(a, b, scale3((real)1 / length3(moved), moved));
    const bool up = next.gap > best.gap;
    share = up ? (real)1 : (real)0.25 * share;
    if (up) best = next;
    if (!(share > (real)0.01)) break;  // on a ridge
  }
  return best;
}

// Across both rims at a point of a's rim and the nearest point of b's, if that separates them better.
CALLED CylinderBound cylinders_sample(const Cylinder* a, u32 end_a, const Cylinder* b, u32 end_b, u32 i, bool swapped,
                                      CylinderBound best) {
  const Vec3 direction = rim_direction(a, i);
  const Vec3 p = add3(cylinder_cap(a, end_a), scale3(a->radius, direction));
  const Vec3 q = rim_towards(b, end_b, p);
  const Vec3 normal = cross3(cross3(a->axes.z, direction), cross3(b->axes.z, sub3(q, cylinder_cap(b, end_b))));
  const real length = length3(normal);
  if (!(length > (real)1e-3 * b->radius)) return best;
  const Vec3 unit = scale3((real)1 / length, normal);
  const CylinderBound bound = swapped ? cylinders_bound(b, a, unit) : cylinders_bound(a, b, unit);
  return bound.gap > best.gap ? bound : best;
}

// Offers the top of a climb.
CALLED Meeting cylinders_try_top(const Cylinder* a, const Cylinder* b, Meeting best, const CylinderBound* from,
                                 real tolerance) {
  const CylinderBound top = cylinders_climb(a, b, *from);
  if (!(top.gap > best.gap + tolerance)) return best;
  const Vec3 on_a = cylinder_support(a, scale3((real)-1, top.normal));
  return meeting_offer(best, top.gap, top.normal, NORMAL_FIXED, on_a, cylinder_support(b, top.normal), tolerance);
}

// Whether one point of c reaches farther along a unit direction than the others, or a line on its side does.
static inline bool cylinder_points(const Cylinder* c, Vec3 direction, real tolerance) {
  const real along = c->half_length * dot3(c->axes.z, direction);
  return along > (real)50 * tolerance || along < (real)-50 * tolerance;
}

// Offers a unit normal across the axis of a (or of b): there the farthest point of the other one lies over that side.
CALLED Meeting cylinders_try_side(const Cylinder* a, const Cylinder* b, Meeting best, Vec3 normal, bool of_a,
                                  real tolerance) {
  const CylinderBound bound = cylinders_bound(a, b, normal);
  const Vec3 n = bound.normal, back = scale3((real)-1, n);
  if (of_a) {
    const Vec3 on_b = cylinder_support(b, n);
    const real along = clamp_to(dot3(a->axes.z, sub3(on_b, a->center)), a->half_length);
    const Vec3 at_a = sub3(add3(a->center, scale3(along, a->axes.z)), scale3(a->radius, n));
    const Vec3 at_b = cylinder_points(b, n, tolerance) ? on_b : sub3(at_a, scale3(bound.gap, n));
    return meeting_offer(best, bound.gap, n, NORMAL_FIXED, at_a, at_b, tolerance);
  }
  const Vec3 on_a = cylinder_support(a, back);
  const real along = clamp_to(dot3(b->axes.z, sub3(on_a, b->center)), b->half_length);
  const Vec3 at_b = add3(add3(b->center, scale3(along, b->axes.z)), scale3(b->radius, n));
  const Vec3 at_a = cylinder_points(a, back, tolerance) ? on_a : add3(at_b, scale3(bound.gap, n));
  return meeting_offer(best, bound.gap, n, NORMAL_FIXED, at_a, at_b, tolerance);
}

// Across the axis of c, towards the other one; anywhere across where their centres are in line.
static inline Vec3 cylinder_outwards(const Cylinder* c, Vec3 offset) {
  const Vec3 across = cylinder_across(c, offset);
  const real length = length3(across);
  return length > (real)0 ? scale3((real)1 / length, across) : c->axes.x;
}

// The better one of a bound and that along the normal of a rim.
static inline CylinderBound cylinders_better(const Cylinder* a, const Cylinder* b, CylinderBound best,
                                             const RimNearest* rim) {
  if (!rim->found) return best;
  const CylinderBound bound = cylinders_bound(a, b, rim->normal);
  return bound.gap > best.gap ? bound : best;
}

// The best normal: of a cap, across both axes, across one of them, or the shortest line between a rim and the other
// one's axis or rim. Where two rims nearly run along each other, deep inside, they have two such lines close together,
// and may have them between two sixteenths: climbing from the best of those sixteenths finds them.
CALLED Meeting cylinders_meet(const Cylinder* a, const Cylinder* b, real limit, real tolerance) {
  const Vec3 offset = sub3(a->center, b->center);
  Meeting best = cylinders_try(a, b, no_meeting(), a->axes.z, NORMAL_OF_A, tolerance);
  best = cylinders_try(a, b, best, b->axes.z, NORMAL_OF_B, tolerance);
  const Vec3 across = cross3(a->axes.z, b->axes.z);
  const real length = length3(across);
  if (length > (real)1e-5) best = cylinders_try(a, b, best, scale3((real)1 / length, across), NORMAL_FIXED, tolerance);
  best = cylinders_try_side(a, b, best, cylinder_outwards(a, offset), true, tolerance);
  best = cylinders_try_side(a, b, best, cylinder_outwards(b, offset), false, tolerance);
  if (best.gap > limit) return best;
  CylinderBound from;
  from.gap = (real)-1e30;
  from.normal = best.normal;
  for (u32 k = 0; k < 8; ++k) {  // one of a, then one of b
    const bool of_a = (k & 1) == 0;
    const Cylinder *c = of_a ? a : b, *other = of_a ? b : a;
    const RimNearest rim =
        rim_line(c, k >> 2, cylinder_cap(other, 0), other->axes.z, (real)2 * other->half_length, k >> 1 & 1);
    best = cylinders_try_rim(a, b, best, &rim, of_a, other->radius, tolerance);
    from = cylinders_better(a, b, from, &rim);
  }
  if (best.gap > limit) return best;
  // from either rim: one may see two places in a sixteenth of the other
  for (u32 k = 0; k < 128; ++k) {
    const bool of_a = (k & 1) == 0;
    const RimNearest rim = rim_rim(of_a ? a : b, k >> 6, of_a ? b : a, k >> 5 & 1, k >> 1 & 15);
    best = cylinders_try_rim(a, b, best, &rim, of_a, (real)0, tolerance);
    from = cylinders_better(a, b, from, &rim);
  }
  // a cap is no place to climb from, but the best normal may be close to it
  if (best.frame == NORMAL_FIXED) {
    from.gap = best.gap;
    from.normal = best.normal;
  }
  if (from.gap > (real)-1e29) best = cylinders_try_top(a, b, best, &from, tolerance);
  if (best.gap > (real)0) return best;
  from.gap = (real)-1e30;
  for (u32 k = 0; k < 128; ++k) {
    const bool of_a = (k & 1) == 0;
    from = cylinders_sample(of_a ? a : b, k >> 6, of_a ? b : a, k >> 5 & 1, k >> 1 & 15, !of_a, from);
  }
  if (!(from.gap > (real)-1e29)) return best;  // all tangents parallel
  return cylinders_try_top(a, b, best, &from, tolerance);
}

#endif
