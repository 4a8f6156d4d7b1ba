// Which four of the corners that two faces of boxes share become contacts: such that they keep the depth and most of
// the area. kernels/shapes/four_points.h is the twin.
#pragma once

#include "cpu_reference/math.hpp"

namespace lockstep::reference {

/// A corner of the overlap over the reference face: place, feature.
template <class real>
struct FacePoint {
  real x, y;
  u32 feature, taken;
};

template <class real>
struct FacePoints {
  FacePoint<real> at[12];
};

/// The reference face, normal up, in the frame of its box turned so that x and y lie in it: half extents hx, hy. The
/// incident face, seen along the normal, is the parallelogram c +- u +- v; it lies s0 + sx x + sy y above the reference
/// face. The normal is mz (kx, ky, 1). Tolerances follow `size`, that of the smaller face.
template <class real>
struct FacePair {
  real hx, hy, hz;
  real cx, cy, ux, uy, vx, vy;
  real s0, sx, sy, kx, ky, mz;
  real inverse_area, size;
  u32 axis, incident;  // of the reference face in its box, of the incident face in its own
  u32 down, up;        // the reference face, the incident face is the one on the negative, the positive side
  u32 from_b;          // the reference face belongs to b
};

/// Which of the points are kept.
struct FourPoints {
  u32 count, at[4];
};

/// Twice the area of four points, in any order: diagonals have the largest product.
template <class real>
real area_of_four(real px, real py, real qx, real qy, real rx, real ry, real sx, real sy) {
  const real pq = std::abs((qx - px) * (sy - ry) - (qy - py) * (sx - rx));
  const real pr = std::abs((rx - px) * (sy - qy) - (ry - py) * (sx - qx));
  const real ps = std::abs((sx - px) * (ry - qy) - (sy - py) * (rx - qx));
  const real larger = pq > pr ? pq : pr;
  return ps > larger ? ps : larger;
}

/// Twice the area of a triangle, positive where x is to the left of the way from p to q.
template <class real>
real left_of(const FacePoint<real>& p, const FacePoint<real>& q, const FacePoint<real>& x) {
  return (q.x - p.x) * (x.y - p.y) - (q.y - p.y) * (x.x - p.x);
}

template <class real>
real height_at(const FacePair<real>& f, const FacePoint<real>& p) {
  return f.s0 + f.sx * p.x + f.sy * p.y;
}

template <class real>
real area_of_four(const FourPoints& four, const FacePoints<real>& points) {
  const FacePoint<real>&p = points.at[four.at[0]], &q = points.at[four.at[1]];
  const FacePoint<real>&r = points.at[four.at[2]], &s = points.at[four.at[3]];
  return area_of_four(p.x, p.y, q.x, q.y, r.x, r.y, s.x, s.y);
}

/// Takes points in the place of others where the four then enclose more: what was chosen depends on the first one,
/// which may be any of those that are as deep. It gives way only to one of these: up to `least`.
template <class real>
bool widen_four(FourPoints& four, const FacePair<real>& f, const FacePoints<real>& points, real least) {
  bool widened = false;
  real best = real(1.001) * area_of_four(four, points);
  for (u32 i = 0; i < 12; ++i) {
    const FacePoint<real> p = points.at[i];
    bool fresh = p.taken != 0;
    for (u32 k = 0; k < 4; ++k) fresh = fresh && p.feature != points.at[four.at[k]].feature;
    if (!fresh) continue;
    u32 slot = 4;
    for (u32 k = height_at(f, p) <= least ? 0 : 1; k < 4; ++k) {
      const FacePoint<real>&q = points.at[four.at[(k + 1) & 3]], &r = points.at[four.at[(k + 2) & 3]];
      const FacePoint<real>& t = points.at[four.at[(k + 3) & 3]];
      const real area = area_of_four(p.x, p.y, q.x, q.y, r.x, r.y, t.x, t.y);
      if (!(area > best)) continue;
      best = area;
      slot = k;
    }
    if (slot == 4) continue;
    best = real(1.001) * best;
    four.at[slot] = i;
    widened = true;
  }
  return widened;
}

/// The same four, counter-clockwise: the last one goes where it is farthest outside of the triangle of the others.
template <class real>
FourPoints ordered_four(const FourPoints& four, const FacePoints<real>& points) {
  const FacePoint<real>&first = points.at[four.at[0]], &last = points.at[four.at[3]];
  const bool clockwise = left_of(first, points.at[four.at[1]], points.at[four.at[2]]) < real(0);
  const u32 p = four.at[clockwise ? 2 : 1], q = four.at[clockwise ? 1 : 2];
  const real beside_0 = left_of(first, points.at[p], last), beside_1 = left_of(points.at[p], points.at[q], last);
  const real beside_2 = left_of(points.at[q], first, last);
  if (beside_0 <= beside_1 && beside_0 <= beside_2) return {4, {four.at[0], four.at[3], p, q}};
  if (beside_1 <= beside_2) return {4, {four.at[0], p, four.at[3], q}};
  return {4, {four.at[0], p, q, four.at[3]}};
}

/// Takes, in the place of all four, the points farthest outside of their sides, where those enclose more and one of
/// them is as deep. Of an octagon, which two equal boxes make that are twisted about their centres, the four narrow
/// corners and the four wide ones are both such that no single point in the place of another encloses more.
template <class real>
bool replace_four(FourPoints& four, const FacePair<real>& f, const FacePoints<real>& points, real least) {
  const FourPoints old = ordered_four(four, points);
  FourPoints outer = old;
  for (u32 k = 0; k < 4; ++k) {
    const FacePoint<real>&p = points.at[old.at[k]], &q = points.at[old.at[(k + 1) & 3]];
    real farthest = real(0);
    for (u32 i = 0; i < 12; ++i) {
      const real beside = left_of(p, q, points.at[i]);
      if (!points.at[i].taken || !(beside < farthest)) continue;
      farthest = beside;
      outer.at[k] = i;
    }
  }
  for (u32 k = 0; k < 4; ++k)  // rounding may have one point outside of two sides
    if (points.at[outer.at[k]].feature == points.at[outer.at[(k + 1) & 3]].feature) return false;
  if (!(area_of_four(outer, points) > real(1.001) * area_of_four(four, points))) return false;
  // the deepest one stays the first
  for (u32 k = 1; k < 4 && !(height_at(f, points.at[outer.at[0]]) <= least); ++k) {
    const u32 kept = outer.at[0];
    outer.at[0] = outer.at[k];
    outer.at[k] = kept;
  }
  if (!(height_at(f, points.at[outer.at[0]]) <= least)) return false;
  four = outer;
  return true;
}

/// The deepest, the farthest from it, the farthest from their line, the farthest outside of the triangle; then those in
/// whose place they enclose more.
template <class real>
FourPoints four_points(FacePair<real> f, FacePoints<real> points, real limit) {
  FourPoints four;
  four.count = 0;
  const real least = real(1e-8) * f.size * f.size;
  real best = limit;
  for (u32 i = 0; i < 12; ++i) {
    const real s = f.s0 + f.sx * points.at[i].x + f.sy * points.at[i].y;
    points.at[i].taken = points.at[i].taken && s <= limit ? 1 : 0;
    if (points.at[i].taken && (s < best || four.count == 0)) {
      best = s;
      four.at[0] = i;
      four.count = 1;
    }
  }
  if (four.count == 0) return four;
  const real ax = points.at[four.at[0]].x, ay = points.at[four.at[0]].y;
  best = least;
  for (u32 i = 0; i < 12; ++i) {
    const real dx = points.at[i].x - ax, dy = points.at[i].y - ay, d = dx * dx + dy * dy;
    if (points.at[i].taken && d > best) {
      best = d;
      four.at[1] = i;
      four.count = 2;
    }
  }
  if (four.count == 1) return four;
  const real wx = points.at[four.at[1]].x - ax, wy = points.at[four.at[1]].y - ay;
  real area = real(0);
  best = least;
  for (u32 i = 0; i < 12; ++i) {
    const real w = wx * (points.at[i].y - ay) - wy * (points.at[i].x - ax);
    if (points.at[i].taken && std::abs(w) > best) {
      best = std::abs(w);
      area = w;
      four.at[2] = i;
      four.count = 3;
    }
  }
  if (four.count == 2) return four;
  // the triangle a p q is counter-clockwise
  const u32 at_p = area < real(0) ? four.at[2] : four.at[1], at_q = area < real(0) ? four.at[1] : four.at[2];
  const real px = points.at[at_p].x, py = points.at[at_p].y, qx = points.at[at_q].x, qy = points.at[at_q].y;
  best = least;
  for (u32 i = 0; i < 12; ++i) {
    const real x = points.at[i].x, y = points.at[i].y;
    const real w0 = (py - ay) * (x - ax) - (px - ax) * (y - ay);
    const real w1 = (qy - py) * (x - px) - (qx - px) * (y - py);
    const real w2 = (ay - qy) * (x - qx) - (ax - qx) * (y - qy);
    real w = w0 > w1 ? w0 : w1;
    w = w2 > w ? w2 : w;
    if (points.at[i].taken && w > best) {
      best = w;
      four.at[3] = i;
      four.count = 4;
    }
  }
  if (four.count < 4) return four;
  const real as_deep = height_at(f, points.at[four.at[0]]) + real(1e-6) * f.size;
  const bool widened = widen_four(four, f, points, as_deep);
  if (replace_four(four, f, points, as_deep) || widened) widen_four(four, f, points, as_deep);
  return four;
}

}  // namespace lockstep::reference
