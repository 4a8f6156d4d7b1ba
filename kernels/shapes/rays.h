// Where a ray first meets a shape from outside. cpu_reference/shapes/rays.hpp is the twin and says more.
#ifndef LOCKSTEP_RAYS_H
#define LOCKSTEP_RAYS_H

#include "shapes/manifold.h"

#if REAL_IS_DOUBLE
#define RAY_FAR DBL_MAX
#else
#define RAY_FAR FLT_MAX
#endif

typedef struct RayEntry {
  real distance;
  Vec3 normal;
} RayEntry;

static inline RayEntry ray_entry(real distance, Vec3 normal) {
  RayEntry entry;
  entry.distance = distance;
  entry.normal = normal;
  return entry;
}
static inline RayEntry no_entry(void) { return ray_entry((real)-1, make3((real)0, (real)0, (real)0)); }

static inline RayEntry ray_sphere(Vec3 o, Vec3 d, real radius) {
  const real along = -dot3(o, d);
  const Vec3 nearest = add3(o, scale3(along, d));
  const real square = radius * radius - dot3(nearest, nearest);
  if (square < (real)0) return no_entry();
  const real distance = along - sqrt(square);
  return ray_entry(distance, scale3((real)1 / radius, add3(o, scale3(distance, d))));
}

static inline RayEntry ray_plane(Vec3 o, Vec3 d) {
  if (!(d.z < (real)0) || o.z < (real)0) return no_entry();
  return ray_entry(o.z / -d.z, make3((real)0, (real)0, (real)1));
}

typedef struct RaySpan {
  real enter, leave;
  Vec3 normal;
} RaySpan;

static inline void cut_span(RaySpan* span, Vec3 o, Vec3 d, Vec3 n, real w) {
  const real speed = dot3(n, d), gap = dot3(n, o) - w;
  if (speed < (real)0) {
    const real at = gap / -speed;
    if (at > span->enter) {
      span->enter = at;
      span->normal = n;
    }
  } else if (speed > (real)0) {
    const real at = -gap / speed;
    if (at < span->leave) span->leave = at;
  } else if (gap > (real)0) {
    span->leave = (real)-1;
  }
}

static inline RaySpan whole_ray(void) {
  RaySpan span;
  span.enter = (real)-1;
  span.leave = (real)RAY_FAR;
  span.normal = make3((real)0, (real)0, (real)0);
  return span;
}

static inline RayEntry entry_of(RaySpan span) {
  if (span.enter > span.leave) return no_entry();
  return ray_entry(span.enter, span.normal);
}

static inline RayEntry ray_box(Vec3 o, Vec3 d, Vec3 half_size) {
  RaySpan span = whole_ray();
  cut_span(&span, o, d, make3((real)1, (real)0, (real)0), half_size.x);
  cut_span(&span, o, d, make3((real)-1, (real)0, (real)0), half_size.x);
  cut_span(&span, o, d, make3((real)0, (real)1, (real)0), half_size.y);
  cut_span(&span, o, d, make3((real)0, (real)-1, (real)0), half_size.y);
  cut_span(&span, o, d, make3((real)0, (real)0, (real)1), half_size.z);
  cut_span(&span, o, d, make3((real)0, (real)0, (real)-1), half_size.z);
  return entry_of(span);
}

static inline RayEntry ray_hull(Vec3 o, Vec3 d, Hull hull, global const Vec4* planes) {
  RaySpan span = whole_ray();
  for (u32 f = 0u; f < hull.face_count; ++f) {
    const Vec4 plane = planes[hull.first_face + f];
    cut_span(&span, o, d, make3(plane.x, plane.y, plane.z), plane.w);
  }
  return entry_of(span);
}

#if FEATURE_FACETS
static inline RayEntry ray_facet(Vec3 o, Vec3 d, global const Facet* facet) {
  const Vec3 normal = make3(facet->normal[0], facet->normal[1], facet->normal[2]);
  const real speed = dot3(normal, d), gap = dot3(normal, o) - facet->height;
  if (!(speed < (real)0) || gap < (real)0) return no_entry();
  const real distance = gap / -speed;
  const Vec3 at = add3(o, scale3(distance, d));
  for (u32 k = 0u; k < 3u; ++k) {
    const Vec3 start = facet_vertex(facet, k), along = sub3(facet_vertex(facet, k == 2u ? 0u : k + 1u), start);
    if (dot3(cross3(normal, along), sub3(at, start)) < (real)-1e-5 * dot3(along, along)) return no_entry();
  }
  return ray_entry(distance, normal);
}
#endif

// False where the ray runs outside of the endless cylinder: then it meets nothing that is within.
static inline bool ray_side(Vec3 o, Vec3 d, real radius, real half_length, RayEntry* entry) {
  const real across = d.x * d.x + d.y * d.y;
  const real along = across > (real)0 ? -(o.x * d.x + o.y * d.y) / across : (real)0;
  const real x = o.x + along * d.x, y = o.y + along * d.y;
  const real square = radius * radius - (x * x + y * y);
  *entry = no_entry();
  if (square < (real)0) return false;
  if (!(across > (real)0)) return true;
  const real distance = along - sqrt(square / across);
  if (!(fabs(o.z + distance * d.z) <= half_length)) return true;
  *entry = ray_entry(distance, make3((o.x + distance * d.x) / radius, (o.y + distance * d.y) / radius, (real)0));
  return true;
}

static inline RayEntry ray_cap(Vec3 o, Vec3 d, real radius, real end) {
  const RayEntry entry = ray_sphere(make3(o.x, o.y, o.z - end), d, radius);
  const bool beyond = end < (real)0 ? entry.normal.z <= (real)0 : entry.normal.z >= (real)0;
  if (beyond) return entry;
  return no_entry();
}

static inline RayEntry ray_capsule(Vec3 o, Vec3 d, real radius, real half_length) {
  RayEntry side;
  if (!ray_side(o, d, radius, half_length, &side) || side.distance >= (real)0) return side;
  const RayEntry low = ray_cap(o, d, radius, -half_length), high = ray_cap(o, d, radius, half_length);
  if (!(high.distance >= (real)0)) return low;
  if (low.distance >= (real)0 && low.distance <= high.distance) return low;
  return high;
}

static inline RayEntry ray_cylinder(Vec3 o, Vec3 d, real radius, real half_length) {
  RayEntry side;
  if (!ray_side(o, d, radius, half_length, &side) || side.distance >= (real)0) return side;
  const real end = d.z < (real)0 ? (real)1 : (real)-1;
  const real gap = end * o.z - half_length;
  if (gap < (real)0 || !(d.z != (real)0)) return no_entry();
  const real distance = gap / fabs(d.z);
  const real x = o.x + distance * d.x, y = o.y + distance * d.y;
  if (x * x + y * y > radius * radius) return no_entry();
  return ray_entry(distance, make3((real)0, (real)0, end));
}

static inline RayEntry ray_shape(u32 kind, Vec3 o, Vec3 d, Vec3 size, u32 hull, const HullTables* tables) {
  switch (kind) {
    case SHAPE_SPHERE: return ray_sphere(o, d, size.x);
    case SHAPE_CAPSULE: return ray_capsule(o, d, size.x, size.y);
    case SHAPE_BOX: return ray_box(o, d, size);
    case SHAPE_CYLINDER: return ray_cylinder(o, d, size.x, size.y);
    case SHAPE_HULL:
#if FEATURE_FACETS
      if ((hull & HULL_IS_FACET) != 0u) return ray_facet(o, d, tables->facets + (hull & ~HULL_IS_FACET));
#endif
      return ray_hull(o, d, tables->hulls[hull], tables->planes);
    case SHAPE_PLANE: return ray_plane(o, d);
    default: return no_entry();
  }
}

#endif
