// Seams: where boxes, hulls and facets of several surfaces that do not move against each other lie flush they are one
// solid, and what one covers of another is not felt, so that bodies slide and roll over them as over one surface.
// cpu_reference/shapes/seams.hpp is the twin and says more.
#ifndef LOCKSTEP_SEAMS_H
#define LOCKSTEP_SEAMS_H

#include "shapes/facet.h"

#if FEATURE_SEAMS
// The planes that bound a polytope; of a facet both of its sides, then those across its edges.
static inline u32 bound_count(const Polytope* p) { return p->faces == 1u ? 5u : p->faces; }

CALLED Vec4 bound_plane(const Polytope* p, u32 f) {
  if (p->faces > 1u || f == 0u) return poly_own_plane(p, f);
  Vec4 plane = poly_own_plane(p, 0u);
  const Vec3 normal = make3(plane.x, plane.y, plane.z);
  if (f == 1u) {
    plane.x = -plane.x;
    plane.y = -plane.y;
    plane.z = -plane.z;
    plane.w = -plane.w;
    return plane;
  }
  const Vec3 start = poly_own_vertex(p, f - 2u), end = poly_own_vertex(p, f == 4u ? 0u : f - 1u);
  const Vec3 across = cross3(sub3(end, start), normal);
  const Vec3 out = scale3((real)1 / length3(across), across);
  plane.x = out.x;
  plane.y = out.y;
  plane.z = out.z;
  plane.w = dot3(out, start);
  return plane;
}

// Whether a polytope contains a point, own coordinates, or is no farther than the tolerance from it.
CALLED bool poly_contains(const Polytope* p, Vec3 point, real tolerance, real behind) {
  for (u32 f = 0u; f < bound_count(p); ++f) {
    const Vec4 plane = bound_plane(p, f);
    const real least = f == 1u && p->faces == 1u ? behind : tolerance;
    if (dot3(make3(plane.x, plane.y, plane.z), point) - plane.w > least) return false;
  }
  return true;
}

static inline real seam_tolerance(const Polytope* p, u32 k) { return p->tables->seams[p->first_seam + k].tolerance; }
static inline bool seam_has_gap(const Polytope* p, u32 k) { return p->tables->seams[p->first_seam + k].has_gap != 0u; }

// The k-th neighbour of p, in the frame of p.
static inline Polytope seam_neighbour(const Polytope* p, u32 k) {
  global const Seam* seam = p->tables->seams + p->first_seam + k;
  WorldShape shape;
  shape.center = make3(seam->offset[0], seam->offset[1], seam->offset[2]);
  shape.rotation = make4(seam->rotation[0], seam->rotation[1], seam->rotation[2], seam->rotation[3]);
  shape.size = make3(seam->size[0], seam->size[1], seam->size[2]);
  shape.hull = seam->hull;
  shape.alone = false;
  return polytope_of(seam->kind, &shape, p->tables);
}

// Whether a point is in the sphere around a neighbour: most are not.
static inline bool is_near_seam(const Polytope* p, u32 k, Vec3 point) {
  global const Seam* seam = p->tables->seams + p->first_seam + k;
  const Vec3 d = sub3(point, make3(seam->offset[0], seam->offset[1], seam->offset[2]));
  const real radius = length3(make3(seam->size[0], seam->size[1], seam->size[2])) + (real)2 * seam->tolerance;
  return dot3(d, d) <= radius * radius;
}

// Whether a neighbour contains a point and rises above it along a unit direction, or is a facet that this points into
// from behind; both in the frame of the shape.
CALLED bool neighbour_covers(const Polytope* neighbour, Vec3 point, Vec3 up, real tolerance) {
  const Vec3 at = into_frame(neighbour->axes, sub3(point, neighbour->center));
  if (!poly_contains(neighbour, at, tolerance, (real)500 * tolerance)) return false;
  const Vec3 own_up = into_frame(neighbour->axes, up);
  for (u32 i = 0u; i < neighbour->vertices; ++i) {
    const Vec3 d = sub3(poly_own_vertex(neighbour, i), at);
    if (dot3(own_up, d) > FACET_SLACK * length3(d) + tolerance) return true;
  }
  return neighbour->faces == 1u && dot3(own_up, poly_own_normal(neighbour, 0u)) < (real)-0.5;
}

CALLED bool some_neighbour_covers(const Polytope* p, Vec3 point, Vec3 up) {
  for (u32 k = 0u; k < p->seam_count; ++k) {
    if (seam_has_gap(p, k) || !is_near_seam(p, k, point)) continue;
    const Polytope neighbour = seam_neighbour(p, k);
    if (neighbour_covers(&neighbour, point, up, seam_tolerance(p, k))) return true;
  }
  return false;
}

// Whether a place beside a point of a face belongs to the face, and no neighbour covers it.
static inline bool seam_is_open_at(const Polytope* p, Vec3 point, Vec3 normal, real tolerance) {
  return poly_contains(p, point, (real)0.5 * tolerance, (real)0.5 * tolerance) &&
         !some_neighbour_covers(p, point, normal);
}

// Whether the face of p that looks along a unit direction goes on beside the point, out of all neighbours: out of each
// of those that cover the point, through the face of it that is there, or out of all of them at once.
CALLED bool face_goes_on(const Polytope* p, Vec3 point, Vec3 up) {
  u32 face = 0u;
  for (u32 f = 1u; f < p->faces; ++f)
    if (dot3(up, poly_own_normal(p, f)) > dot3(up, poly_own_normal(p, face))) face = f;
  const Vec3 normal = poly_own_normal(p, face);
  if (!(length3(sub3(up, normal)) < (real)2 * FACET_SLACK)) return false;
  Vec3 out_of_all = make3((real)0, (real)0, (real)0);
  real widest = (real)0;
  for (u32 k = 0u; k < p->seam_count; ++k) {
    if (seam_has_gap(p, k) || !is_near_seam(p, k, point)) continue;
    const real tolerance = seam_tolerance(p, k);
    const Polytope neighbour = seam_neighbour(p, k);
    if (!neighbour_covers(&neighbour, point, up, tolerance)) continue;
    const Vec3 at = into_frame(neighbour.axes, sub3(point, neighbour.center));
    for (u32 f = 0u; f < bound_count(&neighbour); ++f) {
      if (neighbour.faces == 1u && f == 1u) continue;  // a solid is behind a facet
      const Vec4 plane = bound_plane(&neighbour, f);
      const Vec3 side = make3(plane.x, plane.y, plane.z);
      if (dot3(side, at) - plane.w < -tolerance) continue;
      const Vec3 out = out_of_frame(neighbour.axes, side);
      const Vec3 along = sub3(out, scale3(dot3(out, normal), normal));
      const real square = dot3(along, along);
      if (!(square > (real)0.01)) continue;
      const Vec3 step = scale3((real)3 * tolerance / square, along);  // three tolerances away from the plane
      if (seam_is_open_at(p, add3(point, step), normal, tolerance)) return true;
      out_of_all = add3(out_of_all, step);
      widest = tolerance > widest ? tolerance : widest;
    }
  }
  return widest > (real)0 && seam_is_open_at(p, add3(point, out_of_all), normal, widest);
}

// Whether its neighbours cover a point of the surface of p against a contact whose unit normal points out of p, both in
// own coordinates.
CALLED bool seams_cover(const Polytope* p, Vec3 point, Vec3 up) {
  return some_neighbour_covers(p, point, up) && !face_goes_on(p, point, up);
}
#endif

#endif
