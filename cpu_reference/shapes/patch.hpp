// Flat parts of two surfaces that lie against each other, and the manifold of what they share.
// kernels/shapes/patch.h is the twin.
//
// Seen along the normal, a patch is a convex polygon (a face; a plane has no corners, hence no sides), a disc (the cap
// of a cylinder) or a segment (the core of a capsule, a line on the side of a cylinder). The corners of what two
// patches share are corners of one inside the other, and points where an edge crosses the outline of the other.
// Candidates are numbered, so that the four best can be picked in four passes without storing any. A candidate that
// comes later must be better by a little more than rounding: contacts at rest keep their features.
#pragma once

#include "cpu_reference/shapes/polytope.hpp"

namespace lockstep::reference {

enum PatchKind { PATCH_SEGMENT = 0, PATCH_POLYGON = 1, PATCH_DISC = 2 };

/// Points on the rim of a disc that can become contacts: sixteen, the first of them along x.
inline constexpr u32 DISC_POINTS = 16;

template <class real>
struct Patch {
  u32 kind;
  real sense;           // 1: faces along the normal (of b), -1: against it (of a)
  Vec3<real> center;    // any point of its plane; the centre of a disc; an end of a segment
  Vec3<real> plane;     // the normal of its plane, out of the shape
  real slope;           // 1 / (plane . normal)
  Vec3<real> end;       // the other end of a segment
  u32 corners;          // of a polygon
  u32 face;             // of the polytope
  Polytope<real> poly;  // of a polygon
  Vec3<real> x, y;      // of a disc: across each other in its plane, as long as the radius
  real radius;
  u32 first_name;  // of a disc: its points are first_name ... + 15
};

/// By how much less deep than the deepest point a point may be and stand for it. Bodies at rest tilt by rounding, and
/// where contacts are soft by a share of their depth: which point is the deepest is then no matter.
template <class real>
real depth_slack(real gap, real tolerance, real scale) {
  const real share = gap < 0 && gap > real(-1e29) ? real(-0.5) * gap : real(0), most = real(5e-3) * scale;
  return tolerance + real(1e-4) * scale + (share < most ? share : most);
}

/// The point of the patch's plane that is in line with x along the normal.
template <class real>
Vec3<real> patch_lift(const Patch<real>& patch, Vec3<real> normal, Vec3<real> x) {
  return add3(x, scale3(dot3(patch.plane, sub3(patch.center, x)) * patch.slope, normal));
}

template <class real>
Patch<real> patch_of(u32 kind, real sense, Vec3<real> center, Vec3<real> plane, Vec3<real> normal) {
  Patch<real> patch = {};
  patch.kind = kind;
  patch.sense = sense;
  patch.center = center;
  patch.plane = plane;
  patch.slope = real(1) / dot3(plane, normal);
  patch.end = center;
  return patch;
}

/// Of the faces at the vertex that reaches farthest towards the other shape, the one that looks there most directly;
/// that vertex alone where all of them are steep.
template <class real>
Patch<real> polygon_patch(const Polytope<real>& p, real sense, Vec3<real> normal, real tolerance) {
  const Vec3<real> own = into_frame(p.axes, scale3(sense, normal));
  const u32 vertex = poly_support(p, own);
  const Vec3<real> corner = poly_own_vertex(p, vertex);
  real most = real(0.02);
  u32 face = NONE;
  for (u32 f = 0; f < p.faces; ++f) {
    const Vec4<real> plane = poly_own_plane(p, f);
    const Vec3<real> out = Vec3<real>{plane.x, plane.y, plane.z};
    const real cosine = dot3(out, own);
    if (cosine > most && plane.w - dot3(out, corner) <= tolerance) {
      most = cosine;
      face = f;
    }
  }
  if (face == NONE) {
    const Vec3<real> point = poly_vertex(p, vertex);
    return patch_of(PATCH_SEGMENT, sense, point, scale3(sense, normal), normal);
  }
  const Vec3<real> out = out_of_frame(p.axes, poly_own_normal(p, face));
  Patch<real> patch = patch_of(PATCH_POLYGON, sense, poly_vertex(p, poly_corner(p, face, 0)), out, normal);
  patch.corners = poly_corner_count(p, face);
  patch.face = face;
  patch.poly = p;
  return patch;
}

template <class real>
Patch<real> plane_patch(Vec3<real> center, Vec3<real> normal) {
  return patch_of(PATCH_POLYGON, real(1), center, normal, normal);
}

template <class real>
Patch<real> segment_patch(real sense, Vec3<real> start, Vec3<real> end, Vec3<real> normal) {
  Patch<real> patch = patch_of(PATCH_SEGMENT, sense, start, scale3(sense, normal), normal);
  patch.end = end;
  return patch;
}

/// The cap of a cylinder where it faces the other shape, else the line on its side that does. Of the points of a cap
/// four are along the axes of the body, until the deepest point of the rim is deeper by more than `slack`: then the
/// nearest of them comes nearer to that one with the square of the tilt, and the others are turned with it. So a tilt
/// that is little more than noise moves none, and a disc that rolls on its rim touches where it is deepest.
template <class real>
Patch<real> cylinder_patch(const WorldShape<real>& shape, const Axes<real>& axes, real sense, Vec3<real> normal,
                           real slack) {
  const real radius = shape.size.x, half_length = shape.size.y;
  const Vec3<real> down = scale3(sense, normal);
  const real cosine = dot3(axes.z, down);
  const real along_x = dot3(axes.x, down), along_y = dot3(axes.y, down);
  const Vec3<real> across = add3(scale3(along_x, axes.x), scale3(along_y, axes.y));
  const real sine = length3(across);
  const Vec3<real> rim = sine > 0 ? scale3(radius / sine, across) : scale3(radius, axes.x);
  if (cosine * cosine < real(0.5)) {
    const Vec3<real> on_side = add3(shape.center, rim);
    return segment_patch(sense, sub3(on_side, scale3(half_length, axes.z)), add3(on_side, scale3(half_length, axes.z)),
                         normal);
  }
  const real side = cosine > 0 ? real(1) : real(-1);
  const Vec3<real> cap = scale3(side, axes.z);
  Patch<real> patch = patch_of(PATCH_DISC, sense, add3(shape.center, scale3(half_length, cap)), cap, normal);
  patch.x = scale3(radius, axes.x);
  patch.y = scale3(radius, axes.y);
  const real deeper = real(0.3) * radius * sine;  // than the best of those four, at most
  if (deeper > slack) {
    const real share = slack / deeper, rest = share * share;
    const bool at_y = along_y * along_y > along_x * along_x;
    const real sign = (at_y ? along_y : along_x) < 0 ? real(-1) : real(1);
    const Vec3<real> to = add3(scale3(sign * rest, at_y ? patch.y : patch.x), scale3(real(1) - rest, rim));
    const Vec3<real> point = scale3(sign * radius / length3(to), to);
    patch.x = at_y ? cross3(point, axes.z) : point;
    patch.y = at_y ? point : cross3(axes.z, point);
  }
  patch.radius = radius;
  patch.first_name = cosine > 0 ? DISC_POINTS : 0;
  return patch;
}

/// Points of a patch that are corners of what it shares with a larger one.
template <class real>
u32 patch_points(const Patch<real>& patch) {
  return patch.kind == PATCH_POLYGON ? patch.corners : patch.kind == PATCH_DISC ? DISC_POINTS : 0;
}

template <class real>
Vec3<real> patch_point(const Patch<real>& patch, u32 i) {
  if (patch.kind == PATCH_POLYGON) return poly_vertex(patch.poly, poly_corner(patch.poly, patch.face, i));
  return add3(patch.center, around_sixteenth(patch.x, patch.y, i));
}

/// Opposite points of a rim are named one behind the other: points are solved in the order of their names, and sweeps
/// that go around a rim rock what stands on it.
template <class real>
u32 patch_name(const Patch<real>& patch, u32 i) {
  if (patch.kind == PATCH_POLYGON) return poly_corner(patch.poly, patch.face, i);
  return patch.first_name + (i < DISC_POINTS / 2 ? 2 * i : 2 * i - (DISC_POINTS - 1));
}

/// The part of a line between two points that a patch covers, by shares; `in` and `out` name the sides where it enters
/// and leaves, NONE where it starts or ends inside.
template <class real>
struct Cut {
  real from, to;
  u32 in, out;
};

/// Distances from a side, positive inside, at both ends; the tolerance is in the same measure.
template <class real>
Cut<real> cut_by_side(Cut<real> cut, real at_start, real at_end, real tolerance, u32 side) {
  if (at_start < -tolerance && at_end < -tolerance) {
    cut.from = 2;
    return cut;
  }
  if (at_start < -tolerance && at_end > at_start) {
    const real t = at_start / (at_start - at_end);
    const real share = t > 1 ? real(1) : t;
    if (share > cut.from) {
      cut.from = share;
      cut.in = side;
    }
  }
  if (at_end < -tolerance && at_start > at_end) {
    const real t = at_start / (at_start - at_end);
    const real share = t < 0 ? real(0) : t;
    if (share < cut.to) {
      cut.to = share;
      cut.out = side;
    }
  }
  return cut;
}

/// Inside the side of a polygon that starts at corner i: positive.
template <class real>
Vec3<real> patch_side(const Patch<real>& patch, Vec3<real> normal, Vec3<real> from, Vec3<real> to) {
  return cross3(scale3(patch.sense, normal), sub3(to, from));
}

template <class real>
Cut<real> patch_cut(const Patch<real>& patch, Vec3<real> normal, Vec3<real> start, Vec3<real> end, real tolerance) {
  Cut<real> cut = {0, 1, NONE, NONE};
  if (patch.kind == PATCH_DISC) {
    const Vec3<real> p = sub3(patch_lift(patch, normal, start), patch.center);
    const Vec3<real> d = sub3(sub3(patch_lift(patch, normal, end), patch.center), p);
    const real a = dot3(d, d), b = dot3(p, d), r = patch.radius + tolerance;
    const real c = dot3(p, p) - r * r;
    const real square = b * b - a * c;
    if (!(square > 0)) {
      cut.from = c > 0 ? real(2) : real(0);
      return cut;
    }
    const real root = std::sqrt(square);
    const real enter = (-b - root) / a, leave = (-b + root) / a;
    if (enter > 0) {
      cut.from = enter;
      cut.in = 0;
    }
    if (leave < 1) {
      cut.to = leave;
      cut.out = 1;
    }
    return cut;
  }
  Vec3<real> from = patch.corners > 0 ? patch_point(patch, patch.corners - 1) : patch.center;
  for (u32 i = 0; i < patch.corners; ++i) {
    const Vec3<real> to = patch_point(patch, i);
    const Vec3<real> side = patch_side(patch, normal, from, to);
    cut = cut_by_side(cut, dot3(side, sub3(start, from)), dot3(side, sub3(end, from)), tolerance * length3(side), i);
    from = to;
  }
  return cut;
}

template <class real>
bool patch_contains(const Patch<real>& patch, Vec3<real> normal, Vec3<real> x, real tolerance) {
  if (patch.kind == PATCH_DISC) {
    const Vec3<real> d = sub3(patch_lift(patch, normal, x), patch.center);
    const real r = patch.radius + tolerance;
    return dot3(d, d) <= r * r;
  }
  if (patch.corners == 0) return true;
  Vec3<real> from = patch_point(patch, patch.corners - 1);
  for (u32 i = 0; i < patch.corners; ++i) {
    const Vec3<real> to = patch_point(patch, i);
    const Vec3<real> side = patch_side(patch, normal, from, to);
    if (dot3(side, sub3(x, from)) < -tolerance * length3(side)) return false;
    from = to;
  }
  return true;
}

}  // namespace lockstep::reference
