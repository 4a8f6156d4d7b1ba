// When within the step two shapes meet: conservative advancement (Mirtich 1996; survey 1.1). Both bodies are moved on
// by the time that their gap takes to close at the highest speed at which it could, until it is closed or the step is
// over. kernels/shapes/advance.h is the twin.
#pragma once

#include "cpu_reference/rigid_body.hpp"
#include "cpu_reference/shapes/manifold.hpp"

namespace lockstep::reference {

/// More rounds than bodies that turn need; one for a sphere against a plane.
constexpr u32 advance_rounds = 32;

/// One of the two: how its body moves, and how far a point of the shape can be from the centre of mass and still be
/// carried along by the rotation. A sphere's own rotation moves no surface.
template <class real>
struct Mover {
  Pose<real> pose;
  Vec3<real> v, w;
  real radius;
  bool unbounded;  // a plane: what it carries along is as far out as the other shape
};

template <class real>
Mover<real> make_mover(const ShapeInfo& info, const Shape<real>& shape, const Motion<real>& motion,
                       const Pose<real>& pose) {
  const real arm = length3(vec3(shape.offset));
  return {pose, vec3(motion.v), vec3(motion.w), info.kind == SHAPE_SPHERE ? arm : arm + shape.bounding_radius,
          info.kind == SHAPE_PLANE};
}

/// The pose after a time at the present velocity.
template <class real>
Pose<real> advance_pose(const Mover<real>& m, real time) {
  return {add3(m.pose.position, scale3(time, m.v)), integrate_orientation(m.pose.orientation, m.w, time)};
}

/// No gap along the normal from b to a closes faster in the step. Where a plane turns, the normal does, and the part of
/// the velocity that counts with it: then all of it.
template <class real>
real closing_speed(const Mover<real>& a, const Mover<real>& b, Vec3<real> normal, real h) {
  const Vec3<real> v = sub3(b.v, a.v);
  const real angular_speed_a = length3(a.w), angular_speed_b = length3(b.w);
  if ((a.unbounded && angular_speed_a > 0) || (b.unbounded && angular_speed_b > 0)) {
    const real speed = length3(v);
    const real far = length3(sub3(a.pose.position, b.pose.position)) + h * speed;
    return speed + angular_speed_a * (a.unbounded ? far + b.radius : a.radius) +
           angular_speed_b * (b.unbounded ? far + a.radius : b.radius);
  }
  return dot3(normal, v) + angular_speed_a * a.radius + angular_speed_b * b.radius;
}

/// The smallest gap of a manifold that has points.
template <class real>
real closest_gap(const Manifold<real>& m) {
  real gap = gap_at(m, 0);
  for (u32 k = 1; k < m.count; ++k) {
    const real other = gap_at(m, k);
    gap = other < gap ? other : gap;
  }
  return gap;
}

/// One round: the time from which to look on, `h` where the shapes do not meet before.
template <class real>
real advance_time(real time, real gap, real speed, real h) {
  if (!(speed > 0)) return h;
  const real next = time + gap / speed;
  return next < h ? next : h;
}

/// The largest sphere about the origin of a shape that is known to be inside of it; below 0 where there is none.
template <class real>
real core_radius(u32 kind, Vec3<real> size, u32 hull, const HullTables<real>& tables) {
  if (kind == SHAPE_CAPSULE) return size.x;
  if (kind == SHAPE_CYLINDER) return size.x < size.y ? size.x : size.y;
  if (kind == SHAPE_BOX) {
    const real least = size.x < size.y ? size.x : size.y;
    return least < size.z ? least : size.z;
  }
  if (kind != SHAPE_HULL || (hull & HULL_IS_FACET) != 0) return real(-1);
  real radius = size.x;
  for (u32 f = 0; f < tables.hulls[hull].face_count; ++f) {
    const real distance = tables.planes[tables.hulls[hull].first_face + f].w;
    radius = distance < radius ? distance : radius;
  }
  return radius;
}

/// The point of the smallest gap, the first of equals.
template <class real>
u32 nearest_point(const Manifold<real>& m) {
  u32 nearest = 0;
  for (u32 k = 1; k < m.count; ++k) {
    if (gap_at(m, k) < gap_at(m, nearest)) nearest = k;
  }
  return nearest;
}

/// From the middle of side a (`of_a`) or b to the tangent plane of the other side; the anchors are seen from the
/// centres of their shapes, and `center_b` from that of a.
template <class real>
real middle_gap(const Manifold<real>& m, bool of_a, Vec3<real> center_b) {
  const ManifoldPoint<real>& point = m.points[nearest_point(m)];
  if (of_a) return dot3(m.normal, scale3(real(-1), add3(point.anchor_b, center_b))) - m.radius_b;
  return dot3(m.normal, sub3(point.anchor_a, center_b)) - m.radius_a;
}

/// A body that is hit at a corner gives way by turning, and its middle goes on: far through a wall, in a long step. So
/// the core of side a (`of_a`) or b is kept out of the other's tangent plane as well. It takes the place of the point
/// that is farthest where there are four; it never bounces (prepare_contacts).
template <class real>
void add_core(Manifold<real>& m, bool of_a, real radius) {
  u32 farthest = 0;
  for (u32 k = 1; k < m.count; ++k) {
    if (gap_at(m, k) > gap_at(m, farthest)) farthest = k;
  }
  ManifoldPoint<real> point = m.points[nearest_point(m)];
  if (of_a) {
    point.anchor_a = {0, 0, 0};
    point.anchor_b = add3(point.anchor_b, scale3(radius - m.radius_a, m.normal));
  } else {
    point.anchor_b = {0, 0, 0};
    point.anchor_a = sub3(point.anchor_a, scale3(radius - m.radius_b, m.normal));
  }
  point.feature = CORE_FEATURE;
  if (m.count == 4) {
    for (u32 k = farthest; k + 1 < m.count; ++k) m.points[k] = m.points[k + 1];
    --m.count;
  }
  m.points[m.count++] = point;
}

/// A manifold at the impact, seen from the start of the step: its points are where the bodies carry them now, and its
/// normal stays that of the impact.
template <class real>
void bring_back(Manifold<real>& m, const Mover<real>& a, const Mover<real>& b, real time) {
  const Quat<real> later_a = integrate_orientation(a.pose.orientation, a.w, time),
                   later_b = integrate_orientation(b.pose.orientation, b.w, time);
  for (u32 k = 0; k < m.count; ++k) {
    m.points[k].anchor_a = carry3(later_a, a.pose.orientation, m.points[k].anchor_a);
    m.points[k].anchor_b = carry3(later_b, b.pose.orientation, m.points[k].anchor_b);
  }
  m.frame = NORMAL_OF_IMPACT;
}

}  // namespace lockstep::reference
