// Boxes against spheres, capsules and planes. cpu_reference/shapes/box_round.hpp is the twin and says more.
#ifndef LOCKSTEP_BOX_ROUND_H
#define LOCKSTEP_BOX_ROUND_H

#include "shapes/axes.h"
#include "shapes/sphere_plane.h"

static inline real sign_of(real x) { return x < (real)0 ? -(real)1 : (real)1; }

// The coordinate of v along axis k.
static inline real along(Vec3 v, u32 k) { return k == 0 ? v.x : k == 1 ? v.y : v.z; }

// The unit vector along axis k, times s.
static inline Vec3 along_axis(real s, u32 k) {
  return make3(k == 0 ? s : (real)0, k == 1 ? s : (real)0, k == 2 ? s : (real)0);
}

// v with its coordinate along axis k replaced.
static inline Vec3 with_along(Vec3 v, u32 k, real x) {
  return make3(k == 0 ? x : v.x, k == 1 ? x : v.y, k == 2 ? x : v.z);
}

static inline Vec3 clamp_into_box(Vec3 p, Vec3 extents) {
  return make3(clamp_to(p.x, extents.x), clamp_to(p.y, extents.y), clamp_to(p.z, extents.z));
}

// The face that a point inside is closest to, or the one face that it is outside of: the largest |p_k| - h_k.
static inline u32 box_face_at(Vec3 p, Vec3 extents) {
  const real x = fabs(p.x) - extents.x, y = fabs(p.y) - extents.y, z = fabs(p.z) - extents.z;
  u32 k = y > x ? 1 : 0;
  return z > (k == 0 ? x : y) ? 2 : k;
}

// How many coordinates of a point are outside of the box: one where it is over a face, none where it is inside.
static inline u32 coordinates_outside(Vec3 p, Vec3 extents) {
  return (fabs(p.x) > extents.x ? 1 : 0) + (fabs(p.y) > extents.y ? 1 : 0) + (fabs(p.z) > extents.z ? 1 : 0);
}

// a is the sphere. Over a face, or inside, the normal is that of the face; over an edge or corner it points from there.
static inline Manifold sphere_box(const WorldShape* a, const WorldShape* b) {
  const Axes axes = axes_of(b->rotation);
  const Vec3 p = into_frame(axes, sub3(a->center, b->center));
  const u32 outside = coordinates_outside(p, b->size);
  if (outside > 1) {
    const Vec3 core = add3(b->center, out_of_frame(axes, clamp_into_box(p, b->size)));
    // along an edge the sphere rolls: only a corner is a point that the normal turns about
    return manifold_at(direction_between(a->center, core, (real)0, axes.z), outside > 2 ? NORMAL_BETWEEN : NORMAL_FIXED,
                       a->center, a->size.x, core, (real)0, 0);
  }
  const u32 k = box_face_at(p, b->size);
  const real side = sign_of(along(p, k));
  const Vec3 foot = with_along(p, k, side * along(b->size, k));
  return manifold_at(out_of_frame(axes, along_axis(side, k)), NORMAL_OF_B, a->center, a->size.x,
                     add3(b->center, out_of_frame(axes, foot)), (real)0, 0);
}

// The four corners of the face of the box that looks into the plane most.
static inline Manifold box_plane(const WorldShape* a, const WorldShape* b) {
  const Axes axes = axes_of(a->rotation);
  const Vec3 normal = plane_normal(b->rotation);
  const Vec3 n = into_frame(axes, normal);
  u32 k = fabs(n.y) > fabs(n.x) ? 1 : 0;
  k = fabs(n.z) > fabs(along(n, k)) ? 2 : k;
  const u32 k1 = k == 2 ? 0 : k + 1, k2 = k == 0 ? 2 : k - 1;
  const real down = -sign_of(along(n, k));
  Manifold m = manifold_along(normal, NORMAL_OF_B, (real)0, (real)0);
  for (u32 corner = 0; corner < 4; ++corner) {
    const real side_1 = corner == 1 || corner == 2 ? (real)1 : -(real)1, side_2 = corner >= 2 ? (real)1 : -(real)1;
    Vec3 p = along_axis(down * along(a->size, k), k);
    p = with_along(p, k1, side_1 * along(a->size, k1));
    p = with_along(p, k2, side_2 * along(a->size, k2));
    const u32 feature = (p.x > (real)0 ? 1 : 0) + (p.y > (real)0 ? 2 : 0) + (p.z > (real)0 ? 4 : 0);
    m = with_point(m, add3(a->center, out_of_frame(axes, p)), b->center, feature);
  }
  return m;
}

#endif
