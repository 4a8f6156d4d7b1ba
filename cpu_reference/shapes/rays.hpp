// Where a ray first meets a shape from outside, in the shape's own frame: origin o, unit direction d. What starts
// inside of a shape does not meet it. kernels/shapes/rays.h is the twin.
#pragma once

#include <limits>

#include "cpu_reference/shapes/manifold.hpp"

namespace lockstep::reference {

/// The distance along the ray, negative where there is no hit, and the outward normal.
template <class real>
struct RayEntry {
  real distance;
  Vec3<real> normal;
};

template <class real>
RayEntry<real> no_entry() {
  return {real(-1), {0, 0, 0}};
}

/// The sphere about the origin. From the point of the ray that is nearest to the centre the two intersections are half
/// a chord away: no difference of large squares (Haines et al., Precision Improvements for Ray/Sphere Intersection,
/// 2019).
template <class real>
RayEntry<real> ray_sphere(Vec3<real> o, Vec3<real> d, real radius) {
  const real along = -dot3(o, d);
  const Vec3<real> nearest = add3(o, scale3(along, d));
  const real square = radius * radius - dot3(nearest, nearest);
  if (square < 0) return no_entry<real>();
  const real distance = along - std::sqrt(square);
  return {distance, scale3(real(1) / radius, add3(o, scale3(distance, d)))};
}

/// The solid is below z = 0.
template <class real>
RayEntry<real> ray_plane(Vec3<real> o, Vec3<real> d) {
  if (!(d.z < 0) || o.z < 0) return no_entry<real>();
  return {o.z / -d.z, {0, 0, 1}};
}

/// A convex solid is met where the ray has come through the last of the planes n . x = w that it enters by, before it
/// leaves by another. One plane after the other narrows the span.
template <class real>
struct RaySpan {
  real enter, leave;
  Vec3<real> normal;
};

template <class real>
RaySpan<real> cut_span(RaySpan<real> span, Vec3<real> o, Vec3<real> d, Vec3<real> n, real w) {
  const real speed = dot3(n, d), gap = dot3(n, o) - w;
  if (speed < 0) {
    const real at = gap / -speed;
    if (at > span.enter) span = {at, span.leave, n};
  } else if (speed > 0) {
    const real at = -gap / speed;
    if (at < span.leave) span.leave = at;
  } else if (gap > 0) {
    span.leave = real(-1);
  }
  return span;
}

template <class real>
RaySpan<real> whole_ray() {
  return {real(-1), std::numeric_limits<real>::max(), {0, 0, 0}};
}

template <class real>
RayEntry<real> entry_of(const RaySpan<real>& span) {
  if (span.enter > span.leave) return no_entry<real>();
  return {span.enter, span.normal};
}

template <class real>
RayEntry<real> ray_box(Vec3<real> o, Vec3<real> d, Vec3<real> half) {
  RaySpan<real> span = whole_ray<real>();
  span = cut_span(span, o, d, Vec3<real>{1, 0, 0}, half.x);
  span = cut_span(span, o, d, Vec3<real>{-1, 0, 0}, half.x);
  span = cut_span(span, o, d, Vec3<real>{0, 1, 0}, half.y);
  span = cut_span(span, o, d, Vec3<real>{0, -1, 0}, half.y);
  span = cut_span(span, o, d, Vec3<real>{0, 0, 1}, half.z);
  span = cut_span(span, o, d, Vec3<real>{0, 0, -1}, half.z);
  return entry_of(span);
}

template <class real>
RayEntry<real> ray_hull(Vec3<real> o, Vec3<real> d, const Hull& hull, const Vec4<real>* planes) {
  RaySpan<real> span = whole_ray<real>();
  for (u32 f = 0; f < hull.face_count; ++f) {
    const Vec4<real> plane = planes[hull.first_face + f];
    span = cut_span(span, o, d, Vec3<real>{plane.x, plane.y, plane.z}, plane.w);
  }
  return entry_of(span);
}

/// A facet is met from its front. What runs through an edge meets one of its facets at least, whatever rounding says.
template <class real>
RayEntry<real> ray_facet(Vec3<real> o, Vec3<real> d, const Facet<real>& facet) {
  const Vec3<real> normal = vec3(facet.normal);
  const real speed = dot3(normal, d), gap = dot3(normal, o) - facet.height;
  if (!(speed < 0) || gap < 0) return no_entry<real>();
  const real distance = gap / -speed;
  const Vec3<real> at = add3(o, scale3(distance, d));
  for (u32 k = 0; k < 3; ++k) {
    const Vec3<real> start = facet_vertex(facet, k), along = sub3(facet_vertex(facet, k == 2 ? 0 : k + 1), start);
    if (dot3(cross3(normal, along), sub3(at, start)) < real(-1e-5) * dot3(along, along)) return no_entry<real>();
  }
  return {distance, normal};
}

/// The round side of a cylinder along z, between its ends. `inside`: the ray runs within the endless cylinder or into
/// it; where not, it meets nothing that is within.
template <class real>
struct RaySide {
  bool inside;
  RayEntry<real> entry;
};

template <class real>
RaySide<real> ray_side(Vec3<real> o, Vec3<real> d, real radius, real half_length) {
  const real across = d.x * d.x + d.y * d.y;
  const real along = across > 0 ? -(o.x * d.x + o.y * d.y) / across : real(0);
  const real x = o.x + along * d.x, y = o.y + along * d.y;
  const real square = radius * radius - (x * x + y * y);
  if (square < 0) return {false, no_entry<real>()};
  if (!(across > 0)) return {true, no_entry<real>()};
  const real distance = along - std::sqrt(square / across);
  if (!(std::fabs(o.z + distance * d.z) <= half_length)) return {true, no_entry<real>()};
  return {true, {distance, {(o.x + distance * d.x) / radius, (o.y + distance * d.y) / radius, 0}}};
}

/// The end of a capsule at z = `end`: of its sphere only what is beyond.
template <class real>
RayEntry<real> ray_cap(Vec3<real> o, Vec3<real> d, real radius, real end) {
  const RayEntry<real> entry = ray_sphere(Vec3<real>{o.x, o.y, o.z - end}, d, radius);
  const bool beyond = end < 0 ? entry.normal.z <= 0 : entry.normal.z >= 0;
  return beyond ? entry : no_entry<real>();
}

template <class real>
RayEntry<real> ray_capsule(Vec3<real> o, Vec3<real> d, real radius, real half_length) {
  const RaySide<real> side = ray_side(o, d, radius, half_length);
  if (!side.inside || side.entry.distance >= 0) return side.entry;
  const RayEntry<real> low = ray_cap(o, d, radius, -half_length), high = ray_cap(o, d, radius, half_length);
  if (!(high.distance >= 0)) return low;
  return low.distance >= 0 && low.distance <= high.distance ? low : high;
}

template <class real>
RayEntry<real> ray_cylinder(Vec3<real> o, Vec3<real> d, real radius, real half_length) {
  const RaySide<real> side = ray_side(o, d, radius, half_length);
  if (!side.inside || side.entry.distance >= 0) return side.entry;
  const real end = d.z < 0 ? real(1) : real(-1);  // the one that can be entered by
  const real gap = end * o.z - half_length;
  if (gap < 0 || !(d.z != 0)) return no_entry<real>();
  const real distance = gap / std::fabs(d.z);
  const real x = o.x + distance * d.x, y = o.y + distance * d.y;
  if (x * x + y * y > radius * radius) return no_entry<real>();
  return {distance, {0, 0, end}};
}

template <class real>
RayEntry<real> ray_shape(u32 kind, Vec3<real> o, Vec3<real> d, Vec3<real> size, u32 hull,
                         const HullTables<real>& tables) {
  switch (kind) {
    case SHAPE_SPHERE: return ray_sphere(o, d, size.x);
    case SHAPE_CAPSULE: return ray_capsule(o, d, size.x, size.y);
    case SHAPE_BOX: return ray_box(o, d, size);
    case SHAPE_CYLINDER: return ray_cylinder(o, d, size.x, size.y);
    case SHAPE_HULL:
      return (hull & HULL_IS_FACET) != 0 ? ray_facet(o, d, tables.facets[hull & ~HULL_IS_FACET])
                                         : ray_hull(o, d, tables.hulls[hull], tables.planes);
    case SHAPE_PLANE: return ray_plane(o, d);
    default: return no_entry<real>();
  }
}

}  // namespace lockstep::reference
