// Box against box, LANES pairs at once. cpu_reference/shapes/box_box.hpp is the twin and says what is done; here every
// lane computes every case and selects. Codes, features and counts are small whole numbers held as reals, so that one
// kind of mask serves all.
#ifndef LOCKSTEP_BOX_BOX_H
#define LOCKSTEP_BOX_BOX_H

#include "lane_sides.h"
#include "shapes/axes.h"
#include "shapes/four_points.h"

// One box of each pair; centres are seen from those of a.
typedef struct LaneBox {
  Lane3 center, extents;
  LaneQuat rotation;
} LaneBox;

typedef struct BoxPair {
  LaneAxes r;
  Lane3 t;
} BoxPair;

// The separating axis: its code, and that of the best pair of edges.
typedef struct BoxAxis {
  lane separation, code, edges;
} BoxAxis;

static inline Lane3 lane_pick3(lane_mask first, lane_mask second, Lane3 a, Lane3 b, Lane3 c) {
  return lane_make3(BOX_PICK(first, second, a.x, b.x, c.x), BOX_PICK(first, second, a.y, b.y, c.y),
                    BOX_PICK(first, second, a.z, b.z, c.z));
}

LANE_INLINE BoxPair box_pair(const LaneBox* a, const LaneBox* b) {
  BoxPair pair;
  const LaneQuat back = lane_back(a->rotation);
  pair.r = lane_axes_of(lane_multiply4(back, b->rotation));
  pair.t = lane_rotate3(back, lane_sub3(b->center, a->center));
  return pair;
}

// By how much the faces of b have to be better than those of a, and edges than faces, in parts of the smallest half
// extent; and the squared sine below which two edges are parallel.
#define FACE_PREFERENCE 0.01
#define EDGE_PREFERENCE 0.03
#define PARALLEL_EDGES 1e-4

// ---- the separating axis -----------------------------------------------------------------------------------------

#define BOX_LARGER(best, code, separation, c) \
  {                                           \
    const lane s_ = separation;               \
    code = s_ > best ? LANE_OF(c) : code;     \
    best = s_ > best ? s_ : best;             \
  }

// An edge of a along an axis with an edge of b: their cross product has the parts nu and nv along the other two axes.
#define BOX_EDGE(nu_, nv_, tu, tv, au, av, o1u, o1v, o2u, o2v, h1, h2, c)                                         \
  {                                                                                                               \
    const lane nu = nu_, nv = nv_, length = nu * nu + nv * nv;                                                    \
    const lane p = fabs(nu * tu + nv * tv) - (fabs(nu) * au + fabs(nv) * av) -                                    \
                   (fabs(nu * o1u + nv * o1v) * h1 + fabs(nu * o2u + nv * o2v) * h2);                             \
    const lane square = p * fabs(p);                                                                              \
    const lane_mask better = (length >= LANE_OF(PARALLEL_EDGES)) & (square * edge_length > edge_square * length); \
    edge_square = better ? square : edge_square;                                                                  \
    edge_length = better ? length : edge_length;                                                                  \
    edge_code = better ? LANE_OF(c) : edge_code;                                                                  \
  }
#define BOX_EDGES_OF(i, U, V, sign_u, sign_v, tu, tv, au, av)                                           \
  BOX_EDGE(sign_u r.x.V, sign_v r.x.U, tu, tv, au, av, r.y.U, r.y.V, r.z.U, r.z.V, b.y, b.z, 6 + 3 * i) \
  BOX_EDGE(sign_u r.y.V, sign_v r.y.U, tu, tv, au, av, r.z.U, r.z.V, r.x.U, r.x.V, b.z, b.x, 7 + 3 * i) \
  BOX_EDGE(sign_u r.z.V, sign_v r.z.U, tu, tv, au, av, r.x.U, r.x.V, r.y.U, r.y.V, b.x, b.y, 8 + 3 * i)

static inline lane box_smallest(Lane3 v) { return lane_less(v.z, lane_less(v.y, v.x)); }
static inline lane box_least(const LaneBox* a, const LaneBox* b) {
  return lane_less(box_smallest(b->extents), box_smallest(a->extents));
}

// The code is 0 .. 2 for faces of a, 3 .. 5 for faces of b, 6 + 3 i + j for edges.
LANE_INLINE BoxAxis box_axis(const LaneBox* box_a, const LaneBox* box_b, const BoxPair* pair) {
  const LaneAxes r = pair->r;
  const Lane3 x = lane_absolute3(r.x), y = lane_absolute3(r.y), z = lane_absolute3(r.z);
  const Lane3 a = box_a->extents, b = box_b->extents, t = pair->t;
  lane on_a = fabs(t.x) - (a.x + (x.x * b.x + y.x * b.y + z.x * b.z)), code_a = LANE_OF(0);
  BOX_LARGER(on_a, code_a, fabs(t.y) - (a.y + (x.y * b.x + y.y * b.y + z.y * b.z)), 1)
  BOX_LARGER(on_a, code_a, fabs(t.z) - (a.z + (x.z * b.x + y.z * b.y + z.z * b.z)), 2)
  lane on_b = fabs(lane_dot3(t, r.x)) - (b.x + lane_dot3(x, a)), code_b = LANE_OF(3);
  BOX_LARGER(on_b, code_b, fabs(lane_dot3(t, r.y)) - (b.y + lane_dot3(y, a)), 4)
  BOX_LARGER(on_b, code_b, fabs(lane_dot3(t, r.z)) - (b.z + lane_dot3(z, a)), 5)
  lane edge_square = LANE_OF(-1e30), edge_length = LANE_OF(1), edge_code = LANE_OF(6);
  BOX_EDGES_OF(0, y, z, -, +, t.y, t.z, a.y, a.z)
  BOX_EDGES_OF(1, x, z, +, -, t.x, t.z, a.x, a.z)
  BOX_EDGES_OF(2, x, y, -, +, t.x, t.y, a.x, a.y)
  const lane root = sqrt(fabs(edge_square) / edge_length);
  const lane least = box_least(box_a, box_b);
  const lane_mask take_b = on_b > on_a + LANE_OF(FACE_PREFERENCE) * least;
  BoxAxis axis;
  axis.separation = take_b ? on_b : on_a;
  axis.code = take_b ? code_b : code_a;
  axis.edges = edge_code;
  const lane edge = (edge_square < LANE_OF(0) ? -root : root) - LANE_OF(EDGE_PREFERENCE) * least;
  const lane_mask take_edges = edge > axis.separation;
  axis.separation = take_edges ? edge : axis.separation;
  axis.code = take_edges ? edge_code : axis.code;
  return axis;
}

// The axis of a code, in the frame of a; of two edges as long as the sine of their angle.
LANE_INLINE Lane3 box_axis_along(const BoxPair* pair, lane code) {
  const lane zero = LANE_OF(0), one = LANE_OF(1), e = code - LANE_OF(6);
  const lane_mask is_edges = code >= LANE_OF(6), of_a = code < LANE_OF(3);
  const lane of_edge = e >= LANE_OF(6) ? LANE_OF(2) : (e >= LANE_OF(3) ? one : zero);
  const lane i = is_edges ? of_edge : code, j = is_edges ? e - LANE_OF(3) * of_edge : code - LANE_OF(3);
  const Lane3 column = lane_pick3(j == zero, j == one, pair->r.x, pair->r.y, pair->r.z);
  const Lane3 axis = lane_make3(i == zero ? one : zero, i == one ? one : zero, i == LANE_OF(2) ? one : zero);
  return lane_select3(of_a, axis, lane_select3(is_edges, lane_cross3(axis, column), column));
}

// The normal of a code, in the frame of a, towards b.
LANE_INLINE Lane3 box_normal(const BoxPair* pair, lane code) {
  const Lane3 axis = box_axis_along(pair, code);
  const lane side = lane_dot3(axis, pair->t) < LANE_OF(0) ? LANE_OF(-1) : LANE_OF(1);
  return lane_scale3(code < LANE_OF(6) ? side : side / lane_length3(axis), axis);
}

// ---- points on a face --------------------------------------------------------------------------------------------

// The axis behind and before k, and powers of two to name corners by.
static inline lane box_next(lane k) { return k == LANE_OF(2) ? LANE_OF(0) : k + LANE_OF(1); }
static inline lane box_last(lane k) { return k == LANE_OF(0) ? LANE_OF(2) : k - LANE_OF(1); }
static inline lane box_bit(lane k) {
  return BOX_PICK(k == LANE_OF(0), k == LANE_OF(1), LANE_OF(1), LANE_OF(2), LANE_OF(4));
}

static inline lane box_edge_name(lane i, lane side_1, lane side_2) {
  return LANE_OF(4) * i + side_1 + LANE_OF(2) * side_2;
}
static inline lane box_corner_name(lane k, lane side, lane side_1, lane side_2) {
  return side * box_bit(k) + side_1 * box_bit(box_next(k)) + side_2 * box_bit(box_last(k));
}
static inline lane box_crossing(lane_mask from_b, lane reference_edge, lane incident_edge) {
  const lane of_b = LANE_OF(16) + LANE_OF(12) * incident_edge + reference_edge;
  const lane of_a = LANE_OF(16) + LANE_OF(12) * reference_edge + incident_edge;
  return from_b ? of_b : of_a;
}

// The axis along which a vector is longest, the first of equals, and how long it is along it.
static inline lane box_longest_axis(Lane3 v, lane* length) {
  const lane x = fabs(v.x), y = fabs(v.y), z = fabs(v.z);
  const lane_mask past_x = y > x;
  const lane larger = past_x ? y : x;
  const lane_mask past_y = z > larger;
  *length = past_y ? z : larger;
  return past_y ? LANE_OF(2) : (past_x ? LANE_OF(1) : LANE_OF(0));
}

LANE_INLINE FacePair face_pair(const LaneBox* box_a, const LaneBox* box_b, const BoxPair* pair, lane code) {
  FacePair f;
  const LaneAxes r = pair->r;
  const lane zero = LANE_OF(0), one = LANE_OF(1);
  const lane_mask is_face = code < LANE_OF(6);
  const Lane3 n_a = box_normal(pair, code), n_b = lane_into_frame(r, n_a);
  lane cosine_a, cosine_b, length;
  const lane axis_a = box_longest_axis(n_a, &cosine_a), axis_b = box_longest_axis(n_b, &cosine_b);
  f.from_b = (code >= LANE_OF(3)) & (is_face | (cosine_b > cosine_a + LANE_OF(1e-3)));
  f.axis = f.from_b ? axis_b : axis_a;
  const lane_mask k0 = f.axis == zero, k1 = f.axis == one;
  const Lane3 t = pair->t;
  const Lane3 h = lane_select3(f.from_b, box_b->extents, box_a->extents);
  const Lane3 g = lane_select3(f.from_b, box_a->extents, box_b->extents);
  const Lane3 c = lane_select3(f.from_b, lane_scale3(LANE_OF(-1), lane_into_frame(r, t)), t);
  const Lane3 m = lane_select3(f.from_b, lane_scale3(LANE_OF(-1), n_b), n_a);
  const Lane3 row_x = lane_select3(f.from_b, r.x, lane_make3(r.x.x, r.y.x, r.z.x));
  const Lane3 row_y = lane_select3(f.from_b, r.y, lane_make3(r.x.y, r.y.y, r.z.y));
  const Lane3 row_z = lane_select3(f.from_b, r.z, lane_make3(r.x.z, r.y.z, r.z.z));
  // of the reference axis and the next two
  const Lane3 x = lane_pick3(k0, k1, row_y, row_z, row_x), y = lane_pick3(k0, k1, row_z, row_x, row_y);
  f.hx = BOX_PICK(k0, k1, h.y, h.z, h.x);
  f.hy = BOX_PICK(k0, k1, h.z, h.x, h.y);
  f.hz = BOX_PICK(k0, k1, h.x, h.y, h.z);
  const lane m_k = BOX_PICK(k0, k1, m.x, m.y, m.z);
  const lane_mask down = m_k < zero;
  f.top = down ? zero : one;
  const lane up = down ? LANE_OF(-1) : one, cz = up * BOX_PICK(k0, k1, c.x, c.y, c.z);
  const Lane3 z = lane_scale3(up, lane_pick3(k0, k1, row_x, row_y, row_z));
  f.mz = is_face ? one : up * m_k;
  f.kx = is_face ? zero : BOX_PICK(k0, k1, m.y, m.z, m.x) / f.mz;
  f.ky = is_face ? zero : BOX_PICK(k0, k1, m.z, m.x, m.y) / f.mz;

  const Lane3 against = lane_select3(f.from_b, n_a, n_b);
  const lane of_face = box_longest_axis(z, &length), of_edges = box_longest_axis(against, &length);
  f.incident = is_face ? of_face : of_edges;
  const lane_mask j0 = f.incident == zero, j1 = f.incident == one;
  const lane against_j = BOX_PICK(j0, j1, against.x, against.y, against.z);
  const lane_mask side = (f.from_b ? against_j : -against_j) > zero;
  f.side = side ? one : zero;
  const lane g_j = BOX_PICK(j0, j1, g.x, g.y, g.z), g_signed = side ? g_j : -g_j;
  const lane gu = BOX_PICK(j0, j1, g.y, g.z, g.x), gv = BOX_PICK(j0, j1, g.z, g.x, g.y);
  const lane hc = cz + g_signed * BOX_PICK(j0, j1, z.x, z.y, z.z) - f.hz;
  const lane hu = gu * BOX_PICK(j0, j1, z.y, z.z, z.x), hv = gv * BOX_PICK(j0, j1, z.z, z.x, z.y);
  f.cx = BOX_PICK(k0, k1, c.y, c.z, c.x) + g_signed * BOX_PICK(j0, j1, x.x, x.y, x.z) - f.kx * hc;
  f.cy = BOX_PICK(k0, k1, c.z, c.x, c.y) + g_signed * BOX_PICK(j0, j1, y.x, y.y, y.z) - f.ky * hc;
  f.ux = gu * BOX_PICK(j0, j1, x.y, x.z, x.x) - f.kx * hu;
  f.uy = gu * BOX_PICK(j0, j1, y.y, y.z, y.x) - f.ky * hu;
  f.vx = gv * BOX_PICK(j0, j1, x.z, x.x, x.y) - f.kx * hv;
  f.vy = gv * BOX_PICK(j0, j1, y.z, y.x, y.y) - f.ky * hv;
  f.inverse_area = one / (f.ux * f.vy - f.uy * f.vx);
  f.sx = (hu * f.vy - hv * f.uy) * f.inverse_area;
  f.sy = (hv * f.ux - hu * f.vx) * f.inverse_area;
  f.s0 = hc - f.sx * f.cx - f.sy * f.cy;
  f.size = lane_less(f.hx + f.hy, gu + gv);
  return f;
}

LANE_INLINE void cut_edge(FacePoints* points, const FacePair* f, int slot, lane mx, lane my, lane ux, lane uy, lane ex,
                          lane ey, int ends, lane edge, lane corner_from, lane corner_to) {
  const lane tiny = LANE_OF(1e-9) * f->size;
  const lane rx = LANE_OF(1) / (fabs(ux) < tiny ? tiny : ux), ry = LANE_OF(1) / (fabs(uy) < tiny ? tiny : uy);
  const lane x1 = (-ex - mx) * rx, x2 = (ex - mx) * rx, y1 = (-ey - my) * ry, y2 = (ey - my) * ry;
  const lane low_x = x1 < x2 ? x1 : x2, high_x = x1 < x2 ? x2 : x1;
  const lane low_y = y1 < y2 ? y1 : y2, high_y = y1 < y2 ? y2 : y1;
  const lane k1 = box_next(f->axis), k2 = box_last(f->axis), zero = LANE_OF(0), one = LANE_OF(1);
  const lane_mask right = rx > zero, ahead = ry > zero;
  const lane enter_x = box_edge_name(k2, f->top, right ? zero : one);
  const lane leave_x = box_edge_name(k2, f->top, right ? one : zero);
  const lane enter_y = box_edge_name(k1, ahead ? zero : one, f->top);
  const lane leave_y = box_edge_name(k1, ahead ? one : zero, f->top);
  lane from = LANE_OF(-1), to = one;
  const lane others = f->from_b ? zero : LANE_OF(8);  // corners of the incident box
  const lane_mask from_x = low_x > from;
  from = from_x ? low_x : from;
  const lane_mask from_y = low_y > from;
  from = from_y ? low_y : from;
  const lane_mask to_x = high_x < to;
  to = to_x ? high_x : to;
  const lane_mask to_y = high_y < to;
  to = to_y ? high_y : to;
  const lane_mask there = from <= to;
  const lane cut_from = box_crossing(f->from_b, from_y ? enter_y : enter_x, edge);
  const lane cut_to = box_crossing(f->from_b, to_y ? leave_y : leave_x, edge);
  points->x[slot] = mx + from * ux;
  points->y[slot] = my + from * uy;
  points->feature[slot] = (from_x | from_y) ? cut_from : others + corner_from;
  points->taken[slot] = ends ? there : (there & (from_x | from_y));
  points->x[slot + 1] = mx + to * ux;
  points->y[slot + 1] = my + to * uy;
  points->feature[slot + 1] = (to_x | to_y) ? cut_to : others + corner_to;
  points->taken[slot + 1] = ends ? there : (there & (to_x | to_y));
}

LANE_INLINE void face_corner(FacePoints* points, const FacePair* f, int slot, real side_x, real side_y) {
  const lane x = LANE_OF(side_x) * f->hx, y = LANE_OF(side_y) * f->hy, dx = x - f->cx, dy = y - f->cy;
  const lane p = (dx * f->vy - dy * f->vx) * f->inverse_area, q = (dy * f->ux - dx * f->uy) * f->inverse_area;
  points->x[slot] = x;
  points->y[slot] = y;
  points->taken[slot] = (fabs(p) < LANE_OF(0.9999)) & (fabs(q) < LANE_OF(0.9999));
  points->feature[slot] =
      (f->from_b ? LANE_OF(8) : LANE_OF(0)) +
      box_corner_name(f->axis, f->top, LANE_OF(side_x > (real)0 ? 1 : 0), LANE_OF(side_y > (real)0 ? 1 : 0));
}

LANE_INLINE void face_points(FacePoints* points, const FacePair* f) {
  const lane slop = LANE_OF(4e-5) * f->size, ex = f->hx + slop, ey = f->hy + slop;
  const lane j = f->incident, j1 = box_next(j), j2 = box_last(j), side = f->side, zero = LANE_OF(0), one = LANE_OF(1);
  const lane corner_00 = box_corner_name(j, side, zero, zero), corner_10 = box_corner_name(j, side, one, zero);
  const lane corner_01 = box_corner_name(j, side, zero, one), corner_11 = box_corner_name(j, side, one, one);
  cut_edge(points, f, 0, f->cx - f->vx, f->cy - f->vy, f->ux, f->uy, ex, ey, 1, box_edge_name(j1, zero, side),
           corner_00, corner_10);
  cut_edge(points, f, 2, f->cx + f->vx, f->cy + f->vy, f->ux, f->uy, ex, ey, 1, box_edge_name(j1, one, side), corner_01,
           corner_11);
  cut_edge(points, f, 4, f->cx - f->ux, f->cy - f->uy, f->vx, f->vy, ex, ey, 0, box_edge_name(j2, side, zero),
           corner_00, corner_01);
  cut_edge(points, f, 6, f->cx + f->ux, f->cy + f->uy, f->vx, f->vy, ex, ey, 0, box_edge_name(j2, side, one), corner_10,
           corner_11);
  face_corner(points, f, 8, (real)-1, (real)-1);
  face_corner(points, f, 9, (real)1, (real)-1);
  face_corner(points, f, 10, (real)1, (real)1);
  face_corner(points, f, 11, (real)-1, (real)1);
}

// A vector of the frame turned so that the reference axis is the third.
static inline Lane3 box_permuted_back(lane_mask k0, lane_mask k1, lane x, lane y, lane z) {
  return lane_make3(BOX_PICK(k0, k1, z, y, x), BOX_PICK(k0, k1, x, z, y), BOX_PICK(k0, k1, y, x, z));
}

LANE_CALLED LaneManifold box_faces(const LaneBox* a, const LaneBox* b, const BoxPair* pair, lane code, lane limit) {
  const FacePair f = face_pair(a, b, pair, code);
  FacePoints points;
  face_points(&points, &f);
  const FourPoints four = four_points(&points, &f, limit * f.mz);
  LaneQuat q;
  q.x = f.from_b ? b->rotation.x : a->rotation.x;
  q.y = f.from_b ? b->rotation.y : a->rotation.y;
  q.z = f.from_b ? b->rotation.z : a->rotation.z;
  q.w = f.from_b ? b->rotation.w : a->rotation.w;
  const LaneAxes axes = lane_axes_of(q);
  const Lane3 center = lane_make3(f.from_b ? b->center.x : a->center.x, f.from_b ? b->center.y : a->center.y,
                                  f.from_b ? b->center.z : a->center.z);
  const lane zero = LANE_OF(0), up = f.top == zero ? LANE_OF(-1) : LANE_OF(1);
  const lane_mask k0 = f.axis == zero, k1 = f.axis == LANE_OF(1);
  LaneManifold m;
  const Lane3 outward = box_permuted_back(k0, k1, f.kx * f.mz, f.ky * f.mz, up * f.mz);
  m.normal = lane_out_of_frame(axes, lane_scale3(f.from_b ? LANE_OF(1) : LANE_OF(-1), outward));
  m.frame = code >= LANE_OF(6) ? LANE_OF(NORMAL_FIXED) : (f.from_b ? LANE_OF(NORMAL_OF_B) : LANE_OF(NORMAL_OF_A));
  m.radius_a = m.radius_b = zero;
  for (int k = 0; k < 4; ++k) {
    const lane s = f.s0 + f.sx * four.x[k] + f.sy * four.y[k];
    const Lane3 on_face = box_permuted_back(k0, k1, four.x[k], four.y[k], up * f.hz);
    const Lane3 above = box_permuted_back(k0, k1, four.x[k] + f.kx * s, four.y[k] + f.ky * s, up * (f.hz + s));
    const Lane3 reference = lane_add3(center, lane_out_of_frame(axes, on_face));
    const Lane3 incident = lane_add3(center, lane_out_of_frame(axes, above));
    m.anchor_a[k] = lane_make3(f.from_b ? incident.x : reference.x, f.from_b ? incident.y : reference.y,
                               f.from_b ? incident.z : reference.z);
    m.anchor_b[k] = lane_make3(f.from_b ? reference.x : incident.x, f.from_b ? reference.y : incident.y,
                               f.from_b ? reference.z : incident.z);
    m.feature[k] = four.feature[k];
  }
  return m;
}

// Whether the points of two faces tell how the boxes meet.
LANE_INLINE lane_mask faces_meet(const LaneManifold* m, const LaneBox* a, const LaneBox* b, lane separation) {
  const lane none = LANE_OF(1e30);
  lane closest = none;
  for (int k = 0; k < 4; ++k) {
    const lane gap = lane_dot3(m->normal, lane_sub3(m->anchor_a[k], m->anchor_b[k])) - m->radius_a - m->radius_b;
    closest = ((m->feature[k] < LANE_OF(LANE_NO_FEATURE)) & (gap < closest)) ? gap : closest;
  }
  const lane preferred = (LANE_OF(FACE_PREFERENCE) + LANE_OF(EDGE_PREFERENCE)) * box_least(a, b);
  return (closest <= preferred) | ((closest < none) & (separation > LANE_OF(0)));
}

// ---- faces that do not meet -----------------------------------------------------------------------------------------

// The axis entered last by boxes that are apart: its code, and the share of the displacement after which it is.
LANE_INLINE lane box_last_axis(const LaneBox* a, const LaneBox* b, const BoxPair* pair, Lane3 displacement,
                               lane* time) {
  const lane zero = LANE_OF(0);
  lane last = zero;
  *time = zero;
  for (int c = 0; c < 15; ++c) {
    const Lane3 axis = box_axis_along(pair, LANE_OF(c));
    const lane side = lane_dot3(axis, pair->t) < zero ? LANE_OF(-1) : LANE_OF(1);
    const lane approach = -(side * lane_dot3(axis, displacement));
    const lane gap = fabs(lane_dot3(axis, pair->t)) - lane_dot3(lane_absolute3(axis), a->extents) -
                     lane_dot3(lane_absolute3(lane_into_frame(pair->r, axis)), b->extents);
    const lane entered = approach > gap ? gap / approach : LANE_OF(2);
    const lane_mask later = (gap > zero) & (lane_dot3(axis, axis) >= LANE_OF(PARALLEL_EDGES)) & (entered > *time);
    last = later ? LANE_OF(c) : last;
    *time = later ? entered : *time;
  }
  return last;
}

LANE_INLINE LaneManifold box_corners(const LaneBox* a, const LaneBox* b, const BoxPair* pair, BoxAxis axis,
                                     Lane3 displacement, lane limit) {
  const lane_mask overlap = !(axis.separation > LANE_OF(0));
  lane time;
  const lane last = box_last_axis(a, b, pair, lane_into_frame(lane_axes_of(a->rotation), displacement), &time);
  const Lane3 moved = lane_scale3(overlap ? LANE_OF(0) : time, displacement);
  LaneBox moved_b = *b;
  moved_b.center = lane_add3(b->center, moved);
  const BoxPair moved_pair = box_pair(a, &moved_b);
  LaneManifold m = box_faces(a, &moved_b, &moved_pair, overlap ? axis.edges : last, limit);
  m.frame = overlap ? m.frame : LANE_OF(NORMAL_OF_IMPACT);
  const lane_mask none = !overlap & (time > LANE_OF(1));
  for (int k = 0; k < 4; ++k) {
    m.anchor_b[k] = lane_sub3(m.anchor_b[k], moved);
    m.feature[k] = none ? LANE_OF(LANE_NO_FEATURE) : m.feature[k];
  }
  return m;
}

// ---- one pair ----------------------------------------------------------------------------------------------------

LANE_INLINE Lane3 box_in_all_lanes3(Vec3 v) { return lane_make3(LANE_OF(v.x), LANE_OF(v.y), LANE_OF(v.z)); }

static inline LaneBox box_in_all_lanes(const WorldShape* world_shape) {
  LaneBox box;
  box.center = box_in_all_lanes3(world_shape->center);
  box.extents = box_in_all_lanes3(world_shape->size);
  box.rotation.x = LANE_OF(world_shape->rotation.x);
  box.rotation.y = LANE_OF(world_shape->rotation.y);
  box.rotation.z = LANE_OF(world_shape->rotation.z);
  box.rotation.w = LANE_OF(world_shape->rotation.w);
  return box;
}

static inline Vec3 box_first3(Lane3 v) { return make3(LANE_FIRST(v.x), LANE_FIRST(v.y), LANE_FIRST(v.z)); }

static inline Manifold box_box(const WorldShape* shape_a, const WorldShape* shape_b, real limit) {
  const LaneBox a = box_in_all_lanes(shape_a), b = box_in_all_lanes(shape_b);
  const BoxPair pair = box_pair(&a, &b);
  const BoxAxis axis = box_axis(&a, &b, &pair);
  if (LANE_FIRST(axis.separation) > limit) return no_manifold();
  LaneManifold found = box_faces(&a, &b, &pair, axis.code, LANE_OF(limit));
  if ((LANE_BITS(faces_meet(&found, &a, &b, axis.separation)) & 1u) == 0u) {
    const Lane3 displacement = box_in_all_lanes3(sub3(shape_b->displacement, shape_a->displacement));
    found = box_corners(&a, &b, &pair, axis, displacement, LANE_OF(limit));
  }
  Manifold m = manifold_along(box_first3(found.normal), (u32)LANE_FIRST(found.frame), (real)0, (real)0);
  for (u32 k = 0u; k < 4u; ++k) {
    if (LANE_FIRST(found.feature[k]) < (real)LANE_NO_FEATURE)
      m = with_point(m, box_first3(found.anchor_a[k]), box_first3(found.anchor_b[k]),
                     (u32)LANE_FIRST(found.feature[k]));
  }
  return m;
}

#endif
