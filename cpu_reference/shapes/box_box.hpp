// Box against box: 15 separating axes, then what two faces share, seen along the best of them. kernels/shapes/box_box.h
// is the twin.
//
// Axes (Gottschalk, Lin, Manocha, OBBTree, 1996): the faces of a, the faces of b, each edge of a with each of b. The
// one on which the boxes overlap least is the normal. The face that looks along it most, of either box, is cut to the
// face of the other box that looks against it most, both seen along the normal: a rectangle and a parallelogram, whose
// overlap has its corners in 12 fixed places, both ends of the four edges cut by two slabs and the four corners of the
// rectangle. So edges that cross give a point, and edges that are parallel, or lie on a face, both ends of the line.
// Features name what crosses, whichever box the face belongs to: corner v of a: v; corner of b: 8 + v; edge i of a with
// edge j of b: 16 + 12 i + j.
#pragma once

#include "cpu_reference/shapes/box_round.hpp"
#include "cpu_reference/shapes/four_points.hpp"

namespace lockstep::reference {

/// Squared sine of the angle under which two edges count as parallel: their cross product would be noise.
template <class real>
real parallel_edges() {
  return real(1e-4);
}

/// By how much the faces of b have to be better than those of a, and edges than faces, in parts of the smallest half
/// extent: boxes that rest on each other, a little tilted, are separated almost as well by other axes, and would change
/// between them from step to step.
template <class real>
real face_preference() {
  return real(0.01);
}
template <class real>
real edge_preference() {
  return real(0.03);
}

/// b in the frame of a.
template <class real>
struct BoxPair {
  Vec3<real> half_a, half_b;
  Axes<real> r;  // axes of b in the frame of a
  Vec3<real> t;  // centre of b in the frame of a
};

/// The separating axis: 0 .. 2 faces of a, 3 .. 5 faces of b, 6 + 3 i + j edge i of a with edge j of b. Faces are taken
/// unless an edge pair separates clearly better, and those of a before those of b.
template <class real>
struct BoxAxis {
  real separation;
  u32 code;
  u32 edges;  // the best pair of edges
};

template <class real>
BoxPair<real> box_pair(const WorldShape<real>& a, const WorldShape<real>& b) {
  BoxPair<real> pair;
  const Quat<real> back = {-a.rotation.x, -a.rotation.y, -a.rotation.z, a.rotation.w};
  pair.half_a = a.size;
  pair.half_b = b.size;
  pair.r = axes_of(multiply4(back, b.rotation));
  pair.t = rotate3(back, sub3(b.center, a.center));
  return pair;
}

template <class real>
BoxAxis<real> larger(BoxAxis<real> best, real separation, u32 code) {
  if (separation > best.separation) {
    best.separation = separation;
    best.code = code;
  }
  return best;
}

/// The edges of a along axis i with the three of b; `best` holds signed squares p |p| and the squared lengths l of
/// their axes: without roots, q l' > q' l compares p / sqrt(l).
template <class real>
struct EdgeAxis {
  real square, length;
  u32 code;
};

template <class real>
EdgeAxis<real> edge_axis(EdgeAxis<real> best, const BoxPair<real>& pair, u32 i, Vec3<real> column, Vec3<real> other_1,
                         Vec3<real> other_2, real half_1, real half_2, u32 code) {
  // e_i x column, in the frame of a: no part along e_i, and none along the column
  const Vec3<real> n = cross3(along_axis(real(1), i), column);
  const real length = dot3(n, n);
  const real p = std::abs(dot3(n, pair.t)) - dot3(absolute3(n), pair.half_a) -
                 (std::abs(dot3(n, other_1)) * half_1 + std::abs(dot3(n, other_2)) * half_2);
  const real square = p * std::abs(p);
  if (length >= parallel_edges<real>() && square * best.length > best.square * length) {
    best.square = square;
    best.length = length;
    best.code = code;
  }
  return best;
}

template <class real>
real smaller_of(real a, real b) {
  return a < b ? a : b;
}

template <class real>
real smallest_extent(const BoxPair<real>& pair) {
  const Vec3<real> a = pair.half_a, b = pair.half_b;
  return smaller_of(smaller_of(smaller_of(a.x, a.y), a.z), smaller_of(smaller_of(b.x, b.y), b.z));
}

template <class real>
BoxAxis<real> box_axis(const BoxPair<real>& pair) {
  const Axes<real> r = pair.r;
  const Vec3<real> x = absolute3(r.x), y = absolute3(r.y), z = absolute3(r.z);
  const Vec3<real> a = pair.half_a, b = pair.half_b, t = pair.t;
  BoxAxis<real> on_a, on_b;
  on_a.separation = std::abs(t.x) - (a.x + (x.x * b.x + y.x * b.y + z.x * b.z));
  on_a.code = 0;
  on_a = larger(on_a, std::abs(t.y) - (a.y + (x.y * b.x + y.y * b.y + z.y * b.z)), 1);
  on_a = larger(on_a, std::abs(t.z) - (a.z + (x.z * b.x + y.z * b.y + z.z * b.z)), 2);
  on_b.separation = std::abs(dot3(t, r.x)) - (b.x + dot3(x, a));
  on_b.code = 3;
  on_b = larger(on_b, std::abs(dot3(t, r.y)) - (b.y + dot3(y, a)), 4);
  on_b = larger(on_b, std::abs(dot3(t, r.z)) - (b.z + dot3(z, a)), 5);
  EdgeAxis<real> edge;
  edge.square = real(-1e30);
  edge.length = real(1);
  edge.code = 6;
  for (u32 i = 0; i < 3; ++i) {
    edge = edge_axis(edge, pair, i, r.x, r.y, r.z, b.y, b.z, 6 + 3 * i);
    edge = edge_axis(edge, pair, i, r.y, r.z, r.x, b.z, b.x, 7 + 3 * i);
    edge = edge_axis(edge, pair, i, r.z, r.x, r.y, b.x, b.y, 8 + 3 * i);
  }
  const real root = std::sqrt(std::abs(edge.square) / edge.length);
  const real least = smallest_extent(pair);
  BoxAxis<real> best = on_a;
  if (on_b.separation > best.separation + face_preference<real>() * least) best = on_b;
  best.edges = edge.code;
  return larger(best, (edge.square < real(0) ? -root : root) - edge_preference<real>() * least, edge.code);
}

/// The edge of a box along axis i on these sides of the next two axes.
inline u32 edge_name(u32 i, u32 side_1, u32 side_2) { return 4 * i + side_1 + 2 * side_2; }
inline u32 next_axis(u32 k) { return k == 2 ? 0 : k + 1; }
inline u32 last_axis(u32 k) { return k == 0 ? 2 : k - 1; }

inline u32 corner_feature(u32 from_b, u32 corner) { return from_b ? 8 + corner : corner; }
/// An edge of the reference box crosses one of the incident box.
inline u32 crossing_feature(u32 from_b, u32 reference_edge, u32 incident_edge) {
  return from_b ? 16 + 12 * incident_edge + reference_edge : 16 + 12 * reference_edge + incident_edge;
}
/// A corner by its sides along axis k and the next two.
inline u32 corner_name(u32 k, u32 side, u32 side_1, u32 side_2) {
  return (side << k) | (side_1 << next_axis(k)) | (side_2 << last_axis(k));
}

/// The axis along which a vector is longest, the first of equals.
template <class real>
u32 longest_axis(Vec3<real> v) {
  const u32 k = std::abs(v.y) > std::abs(v.x) ? 1 : 0;
  return std::abs(v.z) > std::abs(along(v, k)) ? 2 : k;
}

/// The axis of a code, in the frame of a; of two edges as long as the sine of their angle.
template <class real>
Vec3<real> box_axis_along(const BoxPair<real>& pair, u32 code) {
  if (code < 3) return along_axis(real(1), code);
  if (code < 6) return axis_of(pair.r, code - 3);
  const u32 i = (code - 6) / 3, j = code - 6 - 3 * i;
  return cross3(along_axis(real(1), i), axis_of(pair.r, j));
}

/// The normal of a code, in the frame of a, towards b.
template <class real>
Vec3<real> box_normal(const BoxPair<real>& pair, u32 code) {
  const Vec3<real> axis = box_axis_along(pair, code);
  const real side = sign_of(dot3(axis, pair.t));
  return scale3(code < 6 ? side : side / length3(axis), axis);
}

/// The faces that look at each other along the normal of a code. A face of b is the reference where it looks along the
/// normal better than those of a do, by more than rounding.
template <class real>
FacePair<real> face_pair(const BoxPair<real>& pair, u32 code) {
  const Axes<real> r = pair.r;
  const Vec3<real> n_a = box_normal(pair, code), n_b = into_frame(r, n_a);
  const u32 axis_a = longest_axis(n_a), axis_b = longest_axis(n_b);
  FacePair<real> f;
  const bool better_b = std::abs(along(n_b, axis_b)) > std::abs(along(n_a, axis_a)) + real(1e-3);
  f.from_b = code >= 3 && (code < 6 || better_b) ? 1 : 0;
  f.axis = f.from_b ? axis_b : axis_a;
  const u32 k = f.axis, k1 = next_axis(k), k2 = last_axis(k);
  const Vec3<real> extents = f.from_b ? pair.half_b : pair.half_a, other = f.from_b ? pair.half_a : pair.half_b;
  // the incident box in the frame of the reference box: its centre, and row k1, k2, k of its axes; and the normal,
  // towards it
  const Vec3<real> c = f.from_b ? scale3(real(-1), into_frame(r, pair.t)) : pair.t;
  const Vec3<real> m = f.from_b ? scale3(real(-1), n_b) : n_a;
  const Axes<real> rows = f.from_b ? r : transposed(r);
  const Vec3<real> x = axis_of(rows, k1), y = axis_of(rows, k2);
  Vec3<real> z = axis_of(rows, k);
  f.hx = along(extents, k1);
  f.hy = along(extents, k2);
  f.hz = along(extents, k);
  f.down = along(m, k) < real(0) ? 1 : 0;
  const real up = f.down ? real(-1) : real(1), cz = up * along(c, k);
  z = scale3(up, z);
  const bool is_face = code < 6;
  f.mz = is_face ? real(1) : up * along(m, k);
  f.kx = is_face ? real(0) : along(m, k1) / f.mz;
  f.ky = is_face ? real(0) : along(m, k2) / f.mz;

  const Vec3<real> against = f.from_b ? n_a : n_b;
  const u32 j = is_face ? longest_axis(z) : longest_axis(against), j1 = next_axis(j), j2 = last_axis(j);
  f.incident = j;
  f.up = (f.from_b ? along(against, j) : -along(against, j)) > real(0) ? 1 : 0;
  const real g = f.up ? along(other, j) : -along(other, j), gu = along(other, j1), gv = along(other, j2);
  const real hc = cz + g * along(z, j) - f.hz, hu = gu * along(z, j1), hv = gv * along(z, j2);
  f.cx = along(c, k1) + g * along(x, j) - f.kx * hc;
  f.cy = along(c, k2) + g * along(y, j) - f.ky * hc;
  f.ux = gu * along(x, j1) - f.kx * hu;
  f.uy = gu * along(y, j1) - f.ky * hu;
  f.vx = gv * along(x, j2) - f.kx * hv;
  f.vy = gv * along(y, j2) - f.ky * hv;
  f.inverse_area = real(1) / (f.ux * f.vy - f.uy * f.vx);
  f.sx = (hu * f.vy - hv * f.uy) * f.inverse_area;
  f.sy = (hv * f.ux - hu * f.vx) * f.inverse_area;
  f.s0 = hc - f.sx * f.cx - f.sy * f.cy;
  f.size = smaller_of(f.hx + f.hy, gu + gv);
  return f;
}

/// Both ends of the edge m + t u, -1 <= t <= 1, of the incident face, cut to the rectangle. `ends`: an end that is not
/// cut counts too; of the two edges that meet in a corner one says so. `edge`, `corner_from`, `corner_to`: names of the
/// edge and of the corners at t = -1 and 1.
template <class real>
FacePoints<real> cut_edge(FacePoints<real> points, FacePair<real> f, u32 slot, real mx, real my, real ux, real uy,
                          real ex, real ey, u32 ends, u32 edge, u32 corner_from, u32 corner_to) {
  const real tiny = real(1e-9) * f.size;
  const real rx = real(1) / (std::abs(ux) < tiny ? tiny : ux), ry = real(1) / (std::abs(uy) < tiny ? tiny : uy);
  const real x1 = (-ex - mx) * rx, x2 = (ex - mx) * rx, y1 = (-ey - my) * ry, y2 = (ey - my) * ry;
  const real low_x = x1 < x2 ? x1 : x2, high_x = x1 < x2 ? x2 : x1;
  const real low_y = y1 < y2 ? y1 : y2, high_y = y1 < y2 ? y2 : y1;
  // edges of the reference face at -x, +x, -y, +y, as they are met on the way from t = -1 to 1
  const u32 k1 = next_axis(f.axis), k2 = last_axis(f.axis), top = f.down ? 0 : 1;
  const u32 enter_x = edge_name(k2, top, rx > real(0) ? 0 : 1), leave_x = edge_name(k2, top, rx > real(0) ? 1 : 0);
  const u32 enter_y = edge_name(k1, ry > real(0) ? 0 : 1, top), leave_y = edge_name(k1, ry > real(0) ? 1 : 0, top);
  real from = real(-1), to = real(1);
  u32 at_from = corner_feature(1 - f.from_b, corner_from), at_to = corner_feature(1 - f.from_b, corner_to);
  u32 cut_from = 0, cut_to = 0;
  if (low_x > from) {
    from = low_x;
    at_from = crossing_feature(f.from_b, enter_x, edge);
    cut_from = 1;
  }
  if (low_y > from) {
    from = low_y;
    at_from = crossing_feature(f.from_b, enter_y, edge);
    cut_from = 1;
  }
  if (high_x < to) {
    to = high_x;
    at_to = crossing_feature(f.from_b, leave_x, edge);
    cut_to = 1;
  }
  if (high_y < to) {
    to = high_y;
    at_to = crossing_feature(f.from_b, leave_y, edge);
    cut_to = 1;
  }
  const u32 there = from <= to ? 1 : 0;
  points.at[slot].x = mx + from * ux;
  points.at[slot].y = my + from * uy;
  points.at[slot].feature = at_from;
  points.at[slot].taken = there & (ends | cut_from);
  points.at[slot + 1].x = mx + to * ux;
  points.at[slot + 1].y = my + to * uy;
  points.at[slot + 1].feature = at_to;
  points.at[slot + 1].taken = there & (ends | cut_to);
  return points;
}

/// A corner of the reference face strictly inside the incident one: (p, q) are its coordinates along u and v.
template <class real>
FacePoint<real> face_corner(FacePair<real> f, real side_x, real side_y, real inverse) {
  FacePoint<real> point;
  point.x = side_x * f.hx;
  point.y = side_y * f.hy;
  const real dx = point.x - f.cx, dy = point.y - f.cy;
  const real p = (dx * f.vy - dy * f.vx) * inverse, q = (dy * f.ux - dx * f.uy) * inverse;
  point.taken = std::abs(p) < real(0.9999) && std::abs(q) < real(0.9999) ? 1 : 0;
  point.feature =
      corner_feature(f.from_b, corner_name(f.axis, f.down ? 0 : 1, side_x > real(0) ? 1 : 0, side_y > real(0) ? 1 : 0));
  return point;
}

template <class real>
FacePoints<real> face_points(FacePair<real> f) {
  FacePoints<real> points;
  // an edge along the border stays whole when noise tilts it
  const real slop = real(4e-5) * f.size, ex = f.hx + slop, ey = f.hy + slop;
  const u32 j = f.incident, j1 = next_axis(j), j2 = last_axis(j), side = f.up;
  const u32 corner_00 = corner_name(j, side, 0, 0), corner_10 = corner_name(j, side, 1, 0);
  const u32 corner_01 = corner_name(j, side, 0, 1), corner_11 = corner_name(j, side, 1, 1);
  // edges along u = axis j1 have the sides of j2 and j; along v = axis j2 those of j and j1
  points = cut_edge(points, f, 0, f.cx - f.vx, f.cy - f.vy, f.ux, f.uy, ex, ey, 1, edge_name(j1, 0, side), corner_00,
                    corner_10);
  points = cut_edge(points, f, 2, f.cx + f.vx, f.cy + f.vy, f.ux, f.uy, ex, ey, 1, edge_name(j1, 1, side), corner_01,
                    corner_11);
  points = cut_edge(points, f, 4, f.cx - f.ux, f.cy - f.uy, f.vx, f.vy, ex, ey, 0, edge_name(j2, side, 0), corner_00,
                    corner_01);
  points = cut_edge(points, f, 6, f.cx + f.ux, f.cy + f.uy, f.vx, f.vy, ex, ey, 0, edge_name(j2, side, 1), corner_10,
                    corner_11);
  points.at[8] = face_corner(f, real(-1), real(-1), f.inverse_area);
  points.at[9] = face_corner(f, real(1), real(-1), f.inverse_area);
  points.at[10] = face_corner(f, real(1), real(1), f.inverse_area);
  points.at[11] = face_corner(f, real(-1), real(1), f.inverse_area);
  return points;
}

/// A vector of the frame of the reference box: its parts along the axes of the face and along the face's own.
template <class real>
Vec3<real> face_vector(const FacePair<real>& f, real x, real y, real z) {
  return with_along(with_along(along_axis(z, f.axis), next_axis(f.axis), x), last_axis(f.axis), y);
}

/// The points that the faces share, seen along the normal of a code.
template <class real>
Manifold<real> box_faces(const WorldShape<real>& a, const WorldShape<real>& b, const BoxPair<real>& pair, u32 code,
                         real limit) {
  const FacePair<real> f = face_pair(pair, code);
  const FacePoints<real> points = face_points(f);
  const FourPoints four = four_points(f, points, limit * f.mz);
  const Axes<real> axes = axes_of(f.from_b ? b.rotation : a.rotation);
  const Vec3<real> center = f.from_b ? b.center : a.center;
  const real up = f.down ? real(-1) : real(1);
  // the normal of the face looks from the reference box to the other
  const Vec3<real> outward = face_vector(f, f.kx * f.mz, f.ky * f.mz, up * f.mz);
  const Vec3<real> normal = out_of_frame(axes, scale3(f.from_b ? real(1) : real(-1), outward));
  const u32 frame = code >= 6 ? NORMAL_FIXED : f.from_b ? NORMAL_OF_B : NORMAL_OF_A;
  Manifold<real> m = manifold_along(normal, frame, real(0), real(0));
  for (u32 i = 0; i < four.count; ++i) {
    const FacePoint<real> point = points.at[four.at[i]];
    const real s = f.s0 + f.sx * point.x + f.sy * point.y;
    const Vec3<real> on_face = face_vector(f, point.x, point.y, up * f.hz);
    const Vec3<real> above = face_vector(f, point.x + f.kx * s, point.y + f.ky * s, up * (f.hz + s));
    const Vec3<real> reference = add3(center, out_of_frame(axes, on_face));
    const Vec3<real> incident = add3(center, out_of_frame(axes, above));
    m = with_point(m, f.from_b ? incident : reference, f.from_b ? reference : incident, point.feature);
  }
  return m;
}

/// The axis on which boxes that are apart begin to overlap last, while b moves by a displacement in the frame of a, and
/// the share of it after which they do; above 1: they do not meet.
template <class real>
struct LastAxis {
  real time;
  u32 code;
};

template <class real>
LastAxis<real> last_axis_entered(const BoxPair<real>& pair, Vec3<real> displacement) {
  LastAxis<real> last = {real(0), 0};
  for (u32 code = 0; code < 15; ++code) {
    const Vec3<real> axis = box_axis_along(pair, code);
    const real side = sign_of(dot3(axis, pair.t)), approach = -(side * dot3(axis, displacement));
    const real gap = std::abs(dot3(axis, pair.t)) - dot3(absolute3(axis), pair.half_a) -
                     dot3(absolute3(into_frame(pair.r, axis)), pair.half_b);
    const real time = approach > gap ? gap / approach : real(2);
    if (!(gap > real(0)) || dot3(axis, axis) < parallel_edges<real>() || !(time > last.time)) continue;
    last.time = time;
    last.code = code;
  }
  return last;
}

/// Whether the points of two faces tell how the boxes meet: where these overlap, and a face was preferred to edges,
/// all that the faces share may be apart.
template <class real>
bool faces_meet(const Manifold<real>& m, const BoxPair<real>& pair, const BoxAxis<real>& axis) {
  real closest = real(1e30);
  for (u32 k = 0; k < m.count; ++k) closest = smaller_of(closest, gap_at(m, k));
  const real preferred = (face_preference<real>() + edge_preference<real>()) * smallest_extent(pair);
  return closest <= preferred || (m.count > 0 && axis.separation > real(0));
}

/// Boxes whose faces do not meet, seen along their best axis. Where they overlap it is two edges that do. Where they
/// are apart, they meet where they begin to overlap on the last axis, if they do in the step.
template <class real>
Manifold<real> box_corners(const WorldShape<real>& a, const WorldShape<real>& b, const BoxPair<real>& pair,
                           const BoxAxis<real>& axis, real limit) {
  const Vec3<real> displacement = sub3(b.displacement, a.displacement);
  const bool overlap = !(axis.separation > real(0));
  const LastAxis<real> last = last_axis_entered(pair, into_frame(axes_of(a.rotation), displacement));
  if (!overlap && last.time > real(1)) return no_manifold<real>();
  const Vec3<real> moved = scale3(overlap ? real(0) : last.time, displacement);
  WorldShape<real> moved_b = b;
  moved_b.center = add3(b.center, moved);
  const BoxPair<real> moved_pair = box_pair(a, moved_b);
  Manifold<real> m = box_faces(a, moved_b, moved_pair, overlap ? axis.edges : last.code, limit);
  for (u32 k = 0; k < m.count; ++k) m.points[k].anchor_b = sub3(m.points[k].anchor_b, moved);
  if (!overlap) m.frame = NORMAL_OF_IMPACT;
  return m;
}

template <class real>
Manifold<real> box_box(const WorldShape<real>& a, const WorldShape<real>& b, real limit) {
  const BoxPair<real> pair = box_pair(a, b);
  const BoxAxis<real> axis = box_axis(pair);
  if (axis.separation > limit) return no_manifold<real>();
  const Manifold<real> m = box_faces(a, b, pair, axis.code, limit);
  return faces_meet(m, pair, axis) ? m : box_corners(a, b, pair, axis, limit);
}

}  // namespace lockstep::reference
