// Parts that the pairs of a cylinder share: how far it reaches, and where its rims are nearest to a line and to another
// rim. cpu_reference/shapes/cylinder.hpp is the twin.
#ifndef LOCKSTEP_CYLINDER_H
#define LOCKSTEP_CYLINDER_H

#include "shapes/share.h"

typedef struct Cylinder {
  Vec3 center;
  Axes axes;  // z is the axis
  real radius, half_length;
} Cylinder;

static inline Cylinder cylinder_of(const WorldShape* shape) {
  Cylinder c;
  c.center = shape->center;
  c.axes = axes_of(shape->rotation);
  c.radius = shape->size.x;
  c.half_length = shape->size.y;
  return c;
}

// The part of a vector across the axis: across to the last digit, even where little is left of the vector.
static inline Vec3 cylinder_across(const Cylinder* c, Vec3 v) {
  return add3(scale3(dot3(c->axes.x, v), c->axes.x), scale3(dot3(c->axes.y, v), c->axes.y));
}

// How far the cylinder reaches from its centre along a unit direction.
static inline real cylinder_extent(const Cylinder* c, Vec3 direction) {
  const real along = dot3(c->axes.z, direction);
  return c->half_length * (along < (real)0 ? -along : along) + c->radius * length3(cylinder_across(c, direction));
}

// A point of the cylinder that is farthest along a direction.
static inline Vec3 cylinder_support(const Cylinder* c, Vec3 direction) {
  const Vec3 across = cylinder_across(c, direction);
  const real length = length3(across);
  const real side = dot3(c->axes.z, direction) > (real)0 ? c->half_length : -c->half_length;
  const Vec3 cap = add3(c->center, scale3(side, c->axes.z));
  return length > (real)0 ? add3(cap, scale3(c->radius / length, across)) : cap;
}

// The centre of the lower (0) or upper (1) cap.
static inline Vec3 cylinder_cap(const Cylinder* c, u32 end) {
  return add3(c->center, scale3(end == 0 ? -c->half_length : c->half_length, c->axes.z));
}

// The radius that a contact keeps from its anchor: a cylinder that rolls on its side keeps its anchor near the axis.
static inline real cylinder_rolls(const Cylinder* c, Vec3 normal) {
  const real cosine = dot3(c->axes.z, normal);
  return cosine * cosine < (real)0.01 ? c->radius : (real)0;
}

// Points of a rim and of a line or another rim whose distance is least nearby: the direction across both curves there.
typedef struct RimNearest {
  bool found;
  Vec3 normal;  // unit, of either sense
  Vec3 on_rim, on_other;
} RimNearest;

// From the two points and the tangents of the curves; where the sine of the angle between these is less than
// `least_sine`, the line between the points.
static inline RimNearest rim_nearest(Vec3 on_rim, Vec3 tangent, Vec3 on_other, Vec3 along, real least_sine) {
  RimNearest nearest;
  Vec3 normal = cross3(tangent, along);
  real length = length3(normal);
  if (!(length > least_sine * length3(tangent) * length3(along))) {
    normal = sub3(on_rim, on_other);
    length = length3(normal);
  }
  nearest.found = length > (real)0;
  nearest.normal = nearest.found ? scale3((real)1 / length, normal) : normal;
  nearest.on_rim = on_rim;
  nearest.on_other = on_other;
  return nearest;
}

// Steps of Newton's method from the far end of a branch: it doubles its digits once it is near.
#define RIM_STEPS 12u
// Halvings of a sixteenth of a turn.
#define RIM_HALVINGS 16u

// The distance of the line point + t u (u unit) from a rim is least where F(t) = A + t - r d rho/dt = 0 and rises, rho
// the distance from the axis. d rho/dt is a sigmoid about the point t0 nearest to the axis, so that F is concave
// before t0 and convex behind: on either side (0: before, 1: behind) at most one zero at which F rises, to which
// Newton's method runs without turning back from where |d rho/dt| would have its bound. A line across the axis has it
// at t0 itself, which rounding may pass. What lies outside of 0 <= t <= t_max is none.
CALLED RimNearest rim_line(const Cylinder* c, u32 end, Vec3 point, Vec3 u, real t_max, u32 branch) {
  RimNearest none = {0};
  const Vec3 middle = cylinder_cap(c, end), w = sub3(point, middle);
  const Vec3 w_across = cylinder_across(c, w), u_across = cylinder_across(c, u);
  const real a = dot3(u_across, u_across), start = dot3(w, u);
  const real sense = branch == 0 ? (real)-1 : (real)1;
  const real bound = c->radius * sqrt(a);
  real t = sense * bound - start;
  const bool leans = a > (real)1e-12;
  const real nearest = leans ? -dot3(w_across, u_across) / a : t;  // t0
  if (!leans && branch == 0) return none;                          // parallel to the axis: one place
  if (leans && !(sense * (t - nearest) > (real)0)) return none;
  for (u32 k = 0; k < RIM_STEPS && leans; ++k) {
    const Vec3 across = add3(w_across, scale3(t, u_across));
    const real square = dot3(across, across), rho = sqrt(square);
    if (!(rho > (real)0)) break;
    const real sigma = dot3(across, u_across) / rho;
    const real slope = (real)1 - c->radius * (a - sigma * sigma) / rho;
    if (!(slope > (real)0)) return none;  // past the turning point: no zero on this side
    const real next = t - (start + t - c->radius * sigma) / slope;
    const bool passed = !(sense * (next - nearest) > (real)0);
    const bool stays = next == t;
    t = passed ? nearest : next;
    if (passed || stays) break;
  }
  if (!(t > (real)-0.001 * t_max) || !(t < (real)1.001 * t_max)) return none;
  const Vec3 across = add3(w_across, scale3(t, u_across));
  const real rho = length3(across);
  if (!(rho > (real)0)) return none;
  const real left = start + t - c->radius * dot3(across, u_across) / rho;
  if (!(left < (real)1e-3 * c->radius) || !(left > (real)-1e-3 * c->radius)) return none;
  const Vec3 on_rim = add3(middle, scale3(c->radius / rho, across));
  const real inside = t < (real)0 ? (real)0 : t > t_max ? t_max : t;
  const Vec3 on_line = add3(point, scale3(inside, u));
  // a product of directions that are nearly parallel has few digits; the way between points that are apart has more
  const real least_sine = length3(sub3(on_rim, on_line)) > (real)0.1 * c->radius ? (real)0.05 : (real)1e-3;
  return rim_nearest(on_rim, cross3(c->axes.z, across), on_line, u, least_sine);
}

// The point of c's rim in the direction of v from its middle; v is not along the axis.
static inline Vec3 rim_towards(const Cylinder* c, u32 end, Vec3 v) {
  const Vec3 middle = cylinder_cap(c, end);
  const Vec3 across = cylinder_across(c, sub3(v, middle));
  const real length = length3(across);
  return length > (real)0 ? add3(middle, scale3(c->radius / length, across))
                          : add3(middle, scale3(c->radius, c->axes.x));
}

// Sixteenths of a turn, in the plane of the caps, of length 1.
static inline Vec3 rim_direction(const Cylinder* c, u32 i) { return around_sixteenth(c->axes.x, c->axes.y, i); }

// Half the change, along rim a, of the squared distance from rim b; `direction` is from the middle of rim a.
static inline real rim_slope(const Cylinder* a, Vec3 middle, Vec3 direction, const Cylinder* b, u32 end_b) {
  const Vec3 p = add3(middle, scale3(a->radius, direction));
  return dot3(cross3(a->axes.z, direction), sub3(p, rim_towards(b, end_b, p)));
}

// Between the i-th and the next sixteenth of rim a: a point where the distance from rim b is least nearby, if it falls
// at the first and rises at the second.
CALLED RimNearest rim_rim(const Cylinder* a, u32 end_a, const Cylinder* b, u32 end_b, u32 i) {
  RimNearest none = {0};
  const Vec3 middle = cylinder_cap(a, end_a);
  Vec3 low = rim_direction(a, i), high = rim_direction(a, (i + 1) & 15);
  if (!(rim_slope(a, middle, low, b, end_b) < (real)0) || rim_slope(a, middle, high, b, end_b) < (real)0) return none;
  for (u32 k = 0; k < RIM_HALVINGS; ++k) {
    const Vec3 sum = add3(low, high);
    const Vec3 between = scale3((real)1 / length3(sum), sum);
    if (rim_slope(a, middle, between, b, end_b) < (real)0)
      low = between;
    else
      high = between;
  }
  const Vec3 p = add3(middle, scale3(a->radius, high)), q = rim_towards(b, end_b, p);
  return rim_nearest(p, cross3(a->axes.z, high), q, cross3(b->axes.z, sub3(q, cylinder_cap(b, end_b))), (real)1e-3);
}

#endif
