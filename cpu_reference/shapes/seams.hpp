// Seams: where boxes, hulls and facets of several surfaces that do not move against each other lie flush they are one
// solid, and what one covers of another is not felt, so that bodies slide and roll over them as over one surface.
// kernels/shapes/seams.h is the twin.
//
// A neighbour covers a point of a shape against a direction if it contains the point and rises above it along the
// direction: then the two together have no such normal there. So does a facet that looks the other way. But a face that
// goes on out of all neighbours close to the point, as a wall does above the floor at its foot, is felt at its end too.
#pragma once

#include "cpu_reference/shapes/facet.hpp"

namespace lockstep::reference {

/// The planes that bound a polytope; of a facet both of its sides, then those across its edges.
template <class real>
u32 bound_count(const Polytope<real>& p) {
  return p.faces == 1 ? 5 : p.faces;
}

template <class real>
Vec4<real> bound_plane(const Polytope<real>& p, u32 f) {
  if (p.faces > 1 || f == 0) return poly_own_plane(p, f);
  const Vec4<real> face = poly_own_plane(p, 0);
  if (f == 1) return {-face.x, -face.y, -face.z, -face.w};
  const Vec3<real> start = poly_own_vertex(p, f - 2), end = poly_own_vertex(p, f == 4 ? 0 : f - 1);
  const Vec3<real> across = cross3(sub3(end, start), Vec3<real>{face.x, face.y, face.z});
  const Vec3<real> out = scale3(real(1) / length3(across), across);
  return {out.x, out.y, out.z, dot3(out, start)};
}

/// Whether a polytope contains a point, own coordinates, or is no farther than the tolerance from it; a facet no
/// farther than `behind` from one behind it.
template <class real>
bool poly_contains(const Polytope<real>& p, Vec3<real> point, real tolerance, real behind) {
  for (u32 f = 0; f < bound_count(p); ++f) {
    const Vec4<real> plane = bound_plane(p, f);
    const real least = f == 1 && p.faces == 1 ? behind : tolerance;
    if (dot3(Vec3<real>{plane.x, plane.y, plane.z}, point) - plane.w > least) return false;
  }
  return true;
}

/// The k-th neighbour of p, in the frame of p.
template <class real>
Polytope<real> seam_neighbour(const Polytope<real>& p, u32 k) {
  const Seam<real>& seam = p.tables.seams[p.first_seam + k];
  const Quat<real> rotation = {seam.rotation[0], seam.rotation[1], seam.rotation[2], seam.rotation[3]};
  return polytope_of(seam.kind, WorldShape<real>{vec3(seam.offset), rotation, vec3(seam.size), seam.hull}, p.tables);
}

/// Whether a point is in the sphere around a neighbour: most are not.
template <class real>
bool is_near_seam(const Seam<real>& seam, Vec3<real> point) {
  const Vec3<real> d = sub3(point, vec3(seam.offset));
  const real radius = length3(vec3(seam.size)) + real(2) * seam.tolerance;
  return dot3(d, d) <= radius * radius;
}

/// Whether a neighbour contains a point and rises above it along a unit direction, or is a facet that this points into
/// from behind; both in the frame of the shape.
template <class real>
bool neighbour_covers(const Polytope<real>& neighbour, Vec3<real> point, Vec3<real> up, real tolerance) {
  const Vec3<real> at = into_frame(neighbour.axes, sub3(point, neighbour.center));
  // what lies on a surface has sunk in by a little
  if (!poly_contains(neighbour, at, tolerance, real(500) * tolerance)) return false;
  const Vec3<real> own_up = into_frame(neighbour.axes, up);
  for (u32 i = 0; i < neighbour.vertices; ++i) {
    const Vec3<real> d = sub3(poly_own_vertex(neighbour, i), at);
    if (dot3(own_up, d) > facet_slack<real> * length3(d) + tolerance) return true;
  }
  return neighbour.faces == 1 && dot3(own_up, poly_own_normal(neighbour, 0)) < real(-0.5);
}

template <class real>
bool some_neighbour_covers(const Polytope<real>& p, Vec3<real> point, Vec3<real> up) {
  for (u32 k = 0; k < p.seam_count; ++k) {
    const Seam<real>& seam = p.tables.seams[p.first_seam + k];
    if (seam.has_gap == 0 && is_near_seam(seam, point) &&
        neighbour_covers(seam_neighbour(p, k), point, up, seam.tolerance))
      return true;
  }
  return false;
}

/// Whether a place beside a point of a face belongs to the face, and no neighbour covers it.
template <class real>
bool seam_is_open_at(const Polytope<real>& p, Vec3<real> point, Vec3<real> normal, real tolerance) {
  return poly_contains(p, point, real(0.5) * tolerance, real(0.5) * tolerance) &&
         !some_neighbour_covers(p, point, normal);
}

/// Whether the face of p that looks along a unit direction goes on beside the point, out of all neighbours: out of each
/// of those that cover the point, through the face of it that is there, or out of all of them at once.
template <class real>
bool face_goes_on(const Polytope<real>& p, Vec3<real> point, Vec3<real> up) {
  u32 face = 0;
  for (u32 f = 1; f < p.faces; ++f)
    if (dot3(up, poly_own_normal(p, f)) > dot3(up, poly_own_normal(p, face))) face = f;
  const Vec3<real> normal = poly_own_normal(p, face);
  if (!(length3(sub3(up, normal)) < real(2) * facet_slack<real>)) return false;
  Vec3<real> out_of_all = {0, 0, 0};
  real widest = 0;
  for (u32 k = 0; k < p.seam_count; ++k) {
    const Seam<real>& seam = p.tables.seams[p.first_seam + k];
    if (seam.has_gap != 0 || !is_near_seam(seam, point)) continue;
    const real tolerance = seam.tolerance;
    const Polytope<real> neighbour = seam_neighbour(p, k);
    if (!neighbour_covers(neighbour, point, up, tolerance)) continue;
    const Vec3<real> at = into_frame(neighbour.axes, sub3(point, neighbour.center));
    for (u32 f = 0; f < bound_count(neighbour); ++f) {
      if (neighbour.faces == 1 && f == 1) continue;  // a solid is behind a facet
      const Vec4<real> plane = bound_plane(neighbour, f);
      const Vec3<real> side = Vec3<real>{plane.x, plane.y, plane.z};
      if (dot3(side, at) - plane.w < -tolerance) continue;
      const Vec3<real> out = out_of_frame(neighbour.axes, side);
      const Vec3<real> along = sub3(out, scale3(dot3(out, normal), normal));
      const real square = dot3(along, along);
      if (!(square > real(0.01))) continue;
      const Vec3<real> step = scale3(real(3) * tolerance / square, along);  // three tolerances away from the plane
      if (seam_is_open_at(p, add3(point, step), normal, tolerance)) return true;
      out_of_all = add3(out_of_all, step);
      widest = tolerance > widest ? tolerance : widest;
    }
  }
  return widest > 0 && seam_is_open_at(p, add3(point, out_of_all), normal, widest);
}

/// Whether its neighbours cover a point of the surface of p against a contact whose unit normal points out of p, both
/// in own coordinates.
template <class real>
bool seams_cover(const Polytope<real>& p, Vec3<real> point, Vec3<real> up) {
  return some_neighbour_covers(p, point, up) && !face_goes_on(p, point, up);
}

}  // namespace lockstep::reference
