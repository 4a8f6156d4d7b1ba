// Boxes against spheres, capsules and planes. kernels/shapes/box_round.h is the twin.
#pragma once

#include "cpu_reference/shapes/axes.hpp"
#include "cpu_reference/shapes/sphere_plane.hpp"

namespace lockstep::reference {

template <class real>
real sign_of(real x) {
  return x < real(0) ? real(-1) : real(1);
}

/// The coordinate of v along axis k.
template <class real>
real along(Vec3<real> v, u32 k) {
  return k == 0 ? v.x : k == 1 ? v.y : v.z;
}

/// The unit vector along axis k, times s.
template <class real>
Vec3<real> along_axis(real s, u32 k) {
  return Vec3<real>{k == 0 ? s : real(0), k == 1 ? s : real(0), k == 2 ? s : real(0)};
}

/// v with its coordinate along axis k replaced.
template <class real>
Vec3<real> with_along(Vec3<real> v, u32 k, real x) {
  return Vec3<real>{k == 0 ? x : v.x, k == 1 ? x : v.y, k == 2 ? x : v.z};
}

template <class real>
Vec3<real> clamp_into_box(Vec3<real> p, Vec3<real> extents) {
  return Vec3<real>{clamp_to(p.x, extents.x), clamp_to(p.y, extents.y), clamp_to(p.z, extents.z)};
}

/// The face that a point inside is closest to, or the one face that it is outside of: the largest |p_k| - h_k.
template <class real>
u32 box_face_at(Vec3<real> p, Vec3<real> extents) {
  const real x = std::abs(p.x) - extents.x, y = std::abs(p.y) - extents.y, z = std::abs(p.z) - extents.z;
  u32 k = y > x ? 1 : 0;
  return z > (k == 0 ? x : y) ? 2 : k;
}

/// How many coordinates of a point are outside of the box: one where it is over a face, none where it is inside.
template <class real>
u32 coordinates_outside(Vec3<real> p, Vec3<real> extents) {
  return (std::abs(p.x) > extents.x ? 1 : 0) + (std::abs(p.y) > extents.y ? 1 : 0) +
         (std::abs(p.z) > extents.z ? 1 : 0);
}

/// a is the sphere. Over a face, or inside, the normal is that of the face; over an edge or corner it points from
/// there.
template <class real>
Manifold<real> sphere_box(const WorldShape<real>& a, const WorldShape<real>& b) {
  const Axes<real> axes = axes_of(b.rotation);
  const Vec3<real> p = into_frame(axes, sub3(a.center, b.center));
  const u32 outside = coordinates_outside(p, b.size);
  if (outside > 1) {
    const Vec3<real> core = add3(b.center, out_of_frame(axes, clamp_into_box(p, b.size)));
    // along an edge the sphere rolls: only a corner is a point that the normal turns about
    return manifold_at(direction_between(a.center, core, real(0), axes.z), outside > 2 ? NORMAL_BETWEEN : NORMAL_FIXED,
                       a.center, a.size.x, core, real(0), 0);
  }
  const u32 k = box_face_at(p, b.size);
  const real side = sign_of(along(p, k));
  const Vec3<real> foot = with_along(p, k, side * along(b.size, k));
  return manifold_at(out_of_frame(axes, along_axis(side, k)), NORMAL_OF_B, a.center, a.size.x,
                     add3(b.center, out_of_frame(axes, foot)), real(0), 0);
}

/// The four corners of the face of the box that looks into the plane most.
template <class real>
Manifold<real> box_plane(const WorldShape<real>& a, const WorldShape<real>& b) {
  const Axes<real> axes = axes_of(a.rotation);
  const Vec3<real> normal = plane_normal(b.rotation);
  const Vec3<real> n = into_frame(axes, normal);
  u32 k = std::abs(n.y) > std::abs(n.x) ? 1 : 0;
  k = std::abs(n.z) > std::abs(along(n, k)) ? 2 : k;
  const u32 k1 = k == 2 ? 0 : k + 1, k2 = k == 0 ? 2 : k - 1;
  const real down = -sign_of(along(n, k));
  Manifold<real> m = manifold_along(normal, NORMAL_OF_B, real(0), real(0));
  for (u32 corner = 0; corner < 4; ++corner) {
    const real side_1 = corner == 1 || corner == 2 ? real(1) : real(-1), side_2 = corner >= 2 ? real(1) : real(-1);
    Vec3<real> p = along_axis(down * along(a.size, k), k);
    p = with_along(p, k1, side_1 * along(a.size, k1));
    p = with_along(p, k2, side_2 * along(a.size, k2));
    const u32 feature = (p.x > real(0) ? 1 : 0) + (p.y > real(0) ? 2 : 0) + (p.z > real(0) ? 4 : 0);
    m = with_point(m, add3(a.center, out_of_frame(axes, p)), b.center, feature);
  }
  return m;
}

}  // namespace lockstep::reference
