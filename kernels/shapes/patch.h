// Flat parts of two surfaces that lie against each other, and the manifold of what they share.
// cpu_reference/shapes/patch.hpp is the twin.
//
// Seen along the normal, a patch is a convex polygon (a face; a plane has no corners, hence no sides), a disc (the cap
// of a cylinder) or a segment (the core of a capsule, a line on the side of a cylinder). The corners of what two
// patches share are corners of one inside the other, and points where an edge crosses the outline of the other.
// Candidates are numbered, so that the four best can be picked in four passes without storing any. A candidate that
// comes later must be better by a little more than rounding: contacts at rest keep their features.
#ifndef LOCKSTEP_PATCH_H
#define LOCKSTEP_PATCH_H

#include "shapes/polytope.h"

enum PatchKind { PATCH_SEGMENT = 0, PATCH_POLYGON = 1, PATCH_DISC = 2 };

// Points on the rim of a disc that can become contacts: sixteen, the first of them along x.
#define DISC_POINTS 16u

typedef struct Patch {
  u32 kind;
  real sense;     // 1: faces along the normal (of b), -1: against it (of a)
  Vec3 center;    // any point of its plane; the centre of a disc; an end of a segment
  Vec3 plane;     // the normal of its plane, out of the shape
  real slope;     // 1 / (plane . normal)
  Vec3 end;       // the other end of a segment
  u32 corners;    // of a polygon
  u32 face;       // of the polytope
  Polytope poly;  // of a polygon
  Vec3 x, y;      // of a disc: across each other in its plane, as long as the radius
  real radius;
  u32 first_name;  // of a disc: its points are first_name ... + 15
} Patch;

// By how much less deep than the deepest point a point may be and stand for it. Bodies at rest tilt by rounding, and
// where contacts are soft by a share of their depth: which point is the deepest is then no matter.
static inline real depth_slack(real gap, real tolerance, real scale) {
  const real share = gap < (real)0 && gap > (real)-1e29 ? (real)-0.5 * gap : (real)0, most = (real)5e-3 * scale;
  return tolerance + (real)1e-4 * scale + (share < most ? share : most);
}

// The point of the patch's plane that is in line with x along the normal.
static inline Vec3 patch_lift(const Patch* patch, Vec3 normal, Vec3 x) {
  return add3(x, scale3(dot3(patch->plane, sub3(patch->center, x)) * patch->slope, normal));
}

static inline Patch patch_of(u32 kind, real sense, Vec3 center, Vec3 plane, Vec3 normal) {
  Patch patch = {0};
  patch.kind = kind;
  patch.sense = sense;
  patch.center = center;
  patch.plane = plane;
  patch.slope = (real)1 / dot3(plane, normal);
  patch.end = center;
  return patch;
}

// Of the faces at the vertex that reaches farthest towards the other shape, the one that looks there most directly;
// that vertex alone where all of them are steep.
static inline Patch polygon_patch(const Polytope* p, real sense, Vec3 normal, real tolerance) {
  const Vec3 own = into_frame(p->axes, scale3(sense, normal));
  const u32 vertex = poly_support(p, own);
  const Vec3 corner = poly_own_vertex(p, vertex);
  real most = (real)0.02;
  u32 face = NONE;
  for (u32 f = 0; f < p->faces; ++f) {
    const Vec4 plane = poly_own_plane(p, f);
    const Vec3 out = make3(plane.x, plane.y, plane.z);
    const real cosine = dot3(out, own);
    if (cosine > most && plane.w - dot3(out, corner) <= tolerance) {
      most = cosine;
      face = f;
    }
  }
  if (face == NONE) {
    const Vec3 point = poly_vertex(p, vertex);
    return patch_of(PATCH_SEGMENT, sense, point, scale3(sense, normal), normal);
  }
  const Vec3 out = out_of_frame(p->axes, poly_own_normal(p, face));
  Patch patch = patch_of(PATCH_POLYGON, sense, poly_vertex(p, poly_corner(p, face, 0)), out, normal);
  patch.corners = poly_corner_count(p, face);
  patch.face = face;
  patch.poly = *p;
  return patch;
}

static inline Patch plane_patch(Vec3 center, Vec3 normal) {
  return patch_of(PATCH_POLYGON, (real)1, center, normal, normal);
}

static inline Patch segment_patch(real sense, Vec3 start, Vec3 end, Vec3 normal) {
  Patch patch = patch_of(PATCH_SEGMENT, sense, start, scale3(sense, normal), normal);
  patch.end = end;
  return patch;
}

// The cap of a cylinder where it faces the other shape, else the line on its side that does. Of the points of a cap
// four are along the axes of the body, until the deepest point of the rim is deeper by more than `slack`: then the
// nearest of them comes nearer to that one with the square of the tilt, and the others are turned with it.
static inline Patch cylinder_patch(const WorldShape* shape, Axes axes, real sense, Vec3 normal, real slack) {
  const real radius = shape->size.x, half_length = shape->size.y;
  const Vec3 down = scale3(sense, normal);
  const real cosine = dot3(axes.z, down);
  const real along_x = dot3(axes.x, down), along_y = dot3(axes.y, down);
  const Vec3 across = add3(scale3(along_x, axes.x), scale3(along_y, axes.y));
  const real sine = length3(across);
  const Vec3 rim = sine > (real)0 ? scale3(radius / sine, across) : scale3(radius, axes.x);
  if (cosine * cosine < (real)0.5) {
    const Vec3 on_side = add3(shape->center, rim);
    return segment_patch(sense, sub3(on_side, scale3(half_length, axes.z)), add3(on_side, scale3(half_length, axes.z)),
                         normal);
  }
  const real side = cosine > (real)0 ? (real)1 : (real)-1;
  const Vec3 cap = scale3(side, axes.z);
  Patch patch = patch_of(PATCH_DISC, sense, add3(shape->center, scale3(half_length, cap)), cap, normal);
  patch.x = scale3(radius, axes.x);
  patch.y = scale3(radius, axes.y);
  const real deeper = (real)0.3 * radius * sine;  // than the best of those four, at most
  if (deeper > slack) {
    const real share = slack / deeper, rest = share * share;
    const bool at_y = along_y * along_y > along_x * along_x;
    const real sign = (at_y ? along_y : along_x) < (real)0 ? (real)-1 : (real)1;
    const Vec3 to = add3(scale3(sign * rest, at_y ? patch.y : patch.x), scale3((real)1 - rest, rim));
    const Vec3 point = scale3(sign * radius / length3(to), to);
    patch.x = at_y ? cross3(point, axes.z) : point;
    patch.y = at_y ? point : cross3(axes.z, point);
  }
  patch.radius = radius;
  patch.first_name = cosine > (real)0 ? DISC_POINTS : 0;
  return patch;
}

// Points of a patch that are corners of what it shares with a larger one.
static inline u32 patch_points(const Patch* patch) {
  return patch->kind == PATCH_POLYGON ? patch->corners : patch->kind == PATCH_DISC ? DISC_POINTS : 0;
}

CALLED Vec3 patch_point(const Patch* patch, u32 i) {
  if (patch->kind == PATCH_POLYGON) return poly_vertex(&patch->poly, poly_corner(&patch->poly, patch->face, i));
  return add3(patch->center, around_sixteenth(patch->x, patch->y, i));
}

static inline u32 patch_name(const Patch* patch, u32 i) {
  if (patch->kind == PATCH_POLYGON) return poly_corner(&patch->poly, patch->face, i);
  return patch->first_name + (i < DISC_POINTS / 2u ? 2u * i : 2u * i - (DISC_POINTS - 1u));
}

// The part of a line between two points that a patch covers, by shares; `in` and `out` name the sides where it enters
// and leaves, NONE where it starts or ends inside.
typedef struct Cut {
  real from, to;
  u32 in, out;
} Cut;

// Distances from a side, positive inside, at both ends; the tolerance is in the same measure.
static inline Cut cut_by_side(Cut cut, real at_start, real at_end, real tolerance, u32 side) {
  if (at_start < -tolerance && at_end < -tolerance) {
    cut.from = 2;
    return cut;
  }
  if (at_start < -tolerance && at_end > at_start) {
    const real t = at_start / (at_start - at_end);
    const real share = t > (real)1 ? (real)1 : t;
    if (share > cut.from) {
      cut.from = share;
      cut.in = side;
    }
  }
  if (at_end < -tolerance && at_start > at_end) {
    const real t = at_start / (at_start - at_end);
    const real share = t < (real)0 ? (real)0 : t;
    if (share < cut.to) {
      cut.to = share;
      cut.out = side;
    }
  }
  return cut;
}

// Inside the side of a polygon that starts at corner i: positive.
static inline Vec3 patch_side(const Patch* patch, Vec3 normal, Vec3 from, Vec3 to) {
  return cross3(scale3(patch->sense, normal), sub3(to, from));
}

CALLED Cut patch_cut(const Patch* patch, Vec3 normal, Vec3 start, Vec3 end, real tolerance) {
  Cut cut = {0, 1, NONE, NONE};
  if (patch->kind == PATCH_DISC) {
    const Vec3 p = sub3(patch_lift(patch, normal, start), patch->center);
    const Vec3 d = sub3(sub3(patch_lift(patch, normal, end), patch->center), p);
    const real a = dot3(d, d), b = dot3(p, d), r = patch->radius + tolerance;
    const real c = dot3(p, p) - r * r;
    const real square = b * b - a * c;
    if (!(square > (real)0)) {
      cut.from = c > (real)0 ? (real)2 : (real)0;
      return cut;
    }
    const real root = sqrt(square);
    const real enter = (-b - root) / a, leave = (-b + root) / a;
    if (enter > (real)0) {
      cut.from = enter;
      cut.in = 0;
    }
    if (leave < (real)1) {
      cut.to = leave;
      cut.out = 1;
    }
    return cut;
  }
  Vec3 from = patch->corners > 0 ? patch_point(patch, patch->corners - 1) : patch->center;
  for (u32 i = 0; i < patch->corners; ++i) {
    const Vec3 to = patch_point(patch, i);
    const Vec3 side = patch_side(patch, normal, from, to);
    cut = cut_by_side(cut, dot3(side, sub3(start, from)), dot3(side, sub3(end, from)), tolerance * length3(side), i);
    from = to;
  }
  return cut;
}

CALLED bool patch_contains(const Patch* patch, Vec3 normal, Vec3 x, real tolerance) {
  if (patch->kind == PATCH_DISC) {
    const Vec3 d = sub3(patch_lift(patch, normal, x), patch->center);
    const real r = patch->radius + tolerance;
    return dot3(d, d) <= r * r;
  }
  if (patch->corners == 0) return true;
  Vec3 from = patch_point(patch, patch->corners - 1);
  for (u32 i = 0; i < patch->corners; ++i) {
    const Vec3 to = patch_point(patch, i);
    const Vec3 side = patch_side(patch, normal, from, to);
    if (dot3(side, sub3(x, from)) < -tolerance * length3(side)) return false;
    from = to;
  }
  return true;
}

#endif
