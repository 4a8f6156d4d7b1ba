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

// ---- the separating axis -----------------------------------------------------------------------------------------

#define BOX_LARGER(best, code, separation, c) \
  {                                           \
    const lane s_ = separation;               \
    code = s_ > best ? LANE_OF(c) : code;     \
    best = s_ > best ? s_ : best;             \
  }

// An edge of a along an axis with an edge of b: their cross product has the parts nu and nv along the other two axes.
#define BOX_EDGE(nu_, nv_, tu, tv, au, av, o1u, o1v, o2u, o2v, h1, h2, c)                               \
  {                                                                                                     \
    const lane nu = nu_, nv = nv_, length = nu * nu + nv * nv;                                          \
    const lane p = fabs(nu * tu + nv * tv) - (fabs(nu) * au + fabs(nv) * av) -                          \
                   (fabs(nu * o1u + nv * o1v) * h1 + fabs(nu * o2u + nv * o2v) * h2);                   \
    const lane square = p * fabs(p);                                                                    \
    const lane_mask better = (length >= LANE_OF(1e-4)) & (square * edge_length > edge_square * length); \
    edge_square = better ? square : edge_square;                                                        \
    edge_length = better ? length : edge_length;                                                        \
    edge_code = better ? LANE_OF(c) : edge_code;                                                        \
  }
#define BOX_EDGES_OF(i, U, V, sign_u, sign_v, tu, tv, au, av)                                           \
  BOX_EDGE(sign_u r.x.V, sign_v r.x.U, tu, tv, au, av, r.y.U, r.y.V, r.z.U, r.z.V, b.y, b.z, 6 + 3 * i) \
  BOX_EDGE(sign_u r.y.V, sign_v r.y.U, tu, tv, au, av, r.z.U, r.z.V, r.x.U, r.x.V, b.z, b.x, 7 + 3 * i) \
  BOX_EDGE(sign_u r.z.V, sign_v r.z.U, tu, tv, au, av, r.x.U, r.x.V, r.y.U, r.y.V, b.x, b.y, 8 + 3 * i)

// Returns the separation; the code is 0 .. 2 for faces of a, 3 .. 5 for faces of b, 6 + 3 i + j for edges.
LANE_INLINE lane box_axis(const LaneBox* box_a, const LaneBox* box_b, const BoxPair* pair, lane* code) {
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
  const lane size = a.x + a.y + a.z + b.x + b.y + b.z;
  const lane_mask deep = on_a < LANE_OF(-0.01) * size;
  const lane_mask take_b = on_b > on_a + (deep ? LANE_OF(2.5e-6) : LANE_OF(1e-5)) * size;
  lane best = take_b ? on_b : on_a;
  *code = take_b ? code_b : code_a;
  const lane edge = (edge_square < LANE_OF(0) ? -root : root) - (deep ? LANE_OF(2.5e-6) : LANE_OF(1e-4)) * size;
  *code = edge > best ? edge_code : *code;
  return edge > best ? edge : best;
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

LANE_INLINE FacePair face_pair(const LaneBox* box_a, const LaneBox* box_b, const BoxPair* pair, lane code) {
  FacePair f;
  f.from_b = code >= LANE_OF(3);
  f.axis = f.from_b ? code - LANE_OF(3) : code;
  const lane_mask k0 = f.axis == LANE_OF(0), k1 = f.axis == LANE_OF(1);
  const LaneAxes r = pair->r;
  const Lane3 t = pair->t, back = lane_into_frame(r, t);
#define BOX_SIDE(a, b) (f.from_b ? (a) : (b))
  const Lane3 h = lane_make3(BOX_SIDE(box_b->extents.x, box_a->extents.x), BOX_SIDE(box_b->extents.y, box_a->extents.y),
                             BOX_SIDE(box_b->extents.z, box_a->extents.z));
  const Lane3 g = lane_make3(BOX_SIDE(box_a->extents.x, box_b->extents.x), BOX_SIDE(box_a->extents.y, box_b->extents.y),
                             BOX_SIDE(box_a->extents.z, box_b->extents.z));
  const Lane3 c = lane_make3(BOX_SIDE(LANE_OF(-1) * back.x, t.x), BOX_SIDE(LANE_OF(-1) * back.y, t.y),
                             BOX_SIDE(LANE_OF(-1) * back.z, t.z));
  const Lane3 row_x = lane_make3(BOX_SIDE(r.x.x, r.x.x), BOX_SIDE(r.x.y, r.y.x), BOX_SIDE(r.x.z, r.z.x));
  const Lane3 row_y = lane_make3(BOX_SIDE(r.y.x, r.x.y), BOX_SIDE(r.y.y, r.y.y), BOX_SIDE(r.y.z, r.z.y));
  const Lane3 row_z = lane_make3(BOX_SIDE(r.z.x, r.x.z), BOX_SIDE(r.z.y, r.y.z), BOX_SIDE(r.z.z, r.z.z));
#undef BOX_SIDE
  // of the reference axis and the next two
  const Lane3 x = lane_pick3(k0, k1, row_y, row_z, row_x), y = lane_pick3(k0, k1, row_z, row_x, row_y);
  Lane3 z = lane_pick3(k0, k1, row_x, row_y, row_z);
  f.hx = BOX_PICK(k0, k1, h.y, h.z, h.x);
  f.hy = BOX_PICK(k0, k1, h.z, h.x, h.y);
  f.hz = BOX_PICK(k0, k1, h.x, h.y, h.z);
  lane cz = BOX_PICK(k0, k1, c.x, c.y, c.z);
  const lane_mask down = cz < LANE_OF(0);
  f.top = down ? LANE_OF(0) : LANE_OF(1);
  cz = down ? -cz : cz;
  z = lane_make3(down ? -z.x : z.x, down ? -z.y : z.y, down ? -z.z : z.z);

  // the incident face opposes the normal most
  const lane_mask past_x = fabs(z.y) > fabs(z.x);
  const lane_mask past_y = fabs(z.z) > (past_x ? fabs(z.y) : fabs(z.x));
  f.incident = past_y ? LANE_OF(2) : (past_x ? LANE_OF(1) : LANE_OF(0));
  const lane_mask j0 = f.incident == LANE_OF(0), j1 = f.incident == LANE_OF(1);
  const lane fx = BOX_PICK(j0, j1, x.x, x.y, x.z), fy = BOX_PICK(j0, j1, y.x, y.y, y.z);
  const lane fz = BOX_PICK(j0, j1, z.x, z.y, z.z);
  const lane_mask up = !(fz > LANE_OF(0));
  f.side = up ? LANE_OF(1) : LANE_OF(0);
  const lane gj = BOX_PICK(j0, j1, g.x, g.y, g.z), signed_g = up ? gj : -gj;
  const lane gu = BOX_PICK(j0, j1, g.y, g.z, g.x), gv = BOX_PICK(j0, j1, g.z, g.x, g.y);
  f.cx = BOX_PICK(k0, k1, c.y, c.z, c.x) + signed_g * fx;
  f.cy = BOX_PICK(k0, k1, c.z, c.x, c.y) + signed_g * fy;
  f.ux = gu * BOX_PICK(j0, j1, x.y, x.z, x.x);
  f.uy = gu * BOX_PICK(j0, j1, y.y, y.z, y.x);
  f.vx = gv * BOX_PICK(j0, j1, x.z, x.x, x.y);
  f.vy = gv * BOX_PICK(j0, j1, y.z, y.x, y.y);
  const lane inverse = LANE_OF(1) / fz;
  f.sx = -(fx * inverse);
  f.sy = -(fy * inverse);
  f.s0 = cz + signed_g * fz - f.hz - f.sx * f.cx - f.sy * f.cy;
  return f;
}

LANE_INLINE void cut_edge(FacePoints* points, const FacePair* f, int slot, lane mx, lane my, lane ux, lane uy, lane ex,
                          lane ey, int ends, lane edge, lane corner_from, lane corner_to) {
  const lane tiny = LANE_OF(1e-9) * (f->hx + f->hy);
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

LANE_INLINE void face_corner(FacePoints* points, const FacePair* f, int slot, real side_x, real side_y, lane inverse) {
  const lane x = LANE_OF(side_x) * f->hx, y = LANE_OF(side_y) * f->hy, dx = x - f->cx, dy = y - f->cy;
  const lane p = (dx * f->vy - dy * f->vx) * inverse, q = (dy * f->ux - dx * f->uy) * inverse;
  points->x[slot] = x;
  points->y[slot] = y;
  points->taken[slot] = (fabs(p) < LANE_OF(0.9999)) & (fabs(q) < LANE_OF(0.9999));
  points->feature[slot] =
      (f->from_b ? LANE_OF(8) : LANE_OF(0)) +
      box_corner_name(f->axis, f->top, LANE_OF(side_x > (real)0 ? 1 : 0), LANE_OF(side_y > (real)0 ? 1 : 0));
}

LANE_INLINE void face_points(FacePoints* points, const FacePair* f) {
  const lane slop = LANE_OF(4e-5) * (f->hx + f->hy), ex = f->hx + slop, ey = f->hy + slop;
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
  const lane inverse = LANE_OF(1) / (f->ux * f->vy - f->uy * f->vx);
  face_corner(points, f, 8, (real)-1, (real)-1, inverse);
  face_corner(points, f, 9, (real)1, (real)-1, inverse);
  face_corner(points, f, 10, (real)1, (real)1, inverse);
  face_corner(points, f, 11, (real)-1, (real)1, inverse);
}

// A vector of the frame turned so that the reference axis is the third.
static inline Lane3 box_permuted_back(lane_mask k0, lane_mask k1, lane x, lane y, lane z) {
  return lane_make3(BOX_PICK(k0, k1, z, y, x), BOX_PICK(k0, k1, x, z, y), BOX_PICK(k0, k1, y, x, z));
}

LANE_INLINE LaneManifold box_faces(const LaneBox* a, const LaneBox* b, const BoxPair* pair, lane code, lane limit) {
  const FacePair f = face_pair(a, b, pair, code);
  FacePoints points;
  face_points(&points, &f);
  const FourPoints four = four_points(&points, &f, limit);
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
  m.normal = lane_out_of_frame(axes, box_permuted_back(k0, k1, zero, zero, f.from_b ? up : -up));
  m.frame = f.from_b ? LANE_OF(NORMAL_OF_B) : LANE_OF(NORMAL_OF_A);
  m.radius_a = m.radius_b = zero;
  for (int k = 0; k < 4; ++k) {
    const lane s = f.s0 + f.sx * four.x[k] + f.sy * four.y[k];
    const Lane3 on_face = box_permuted_back(k0, k1, four.x[k], four.y[k], up * f.hz);
    const Lane3 above = box_permuted_back(k0, k1, four.x[k], four.y[k], up * (f.hz + s));
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

// ---- two edges ---------------------------------------------------------------------------------------------------

#define BOX_SIGNED(sign, x) ((sign) < zero ? LANE_OF(-1) * (x) : LANE_OF(1) * (x))
#define BOX_POSITIVE(x) ((x) > zero ? LANE_OF(1) : zero)

LANE_INLINE LaneManifold box_edges(const LaneBox* a, const LaneBox* b, const BoxPair* pair, lane code) {
  const lane zero = LANE_OF(0), one = LANE_OF(1), e = code - LANE_OF(6);
  const lane i = e >= LANE_OF(6) ? LANE_OF(2) : (e >= LANE_OF(3) ? one : zero), j = e - LANE_OF(3) * i;
  const lane_mask i0 = i == zero, i1 = i == one, i2 = i == LANE_OF(2), j0 = j == zero, j1 = j == one;
  const lane_mask j2 = !(j0 | j1);
  const LaneAxes r = pair->r;
  const Lane3 column = lane_pick3(j0, j1, r.x, r.y, r.z), t = pair->t, ha = a->extents, hb = b->extents;
  const Lane3 axis = lane_make3(i0 ? one : zero, i1 ? one : zero, i2 ? one : zero);
  Lane3 n = lane_cross3(axis, column);
  const lane towards = lane_dot3(n, t) < zero ? LANE_OF(-1) : one;
  n = lane_scale3(-towards / sqrt(lane_dot3(n, n)), n);
  const Lane3 n_b = lane_into_frame(r, n);
  Lane3 on_a = lane_make3(i0 ? zero : BOX_SIGNED(n.x, -ha.x), i1 ? zero : BOX_SIGNED(n.y, -ha.y),
                          i2 ? zero : BOX_SIGNED(n.z, -ha.z));
  const Lane3 edge_b = lane_make3(j0 ? zero : BOX_SIGNED(n_b.x, hb.x), j1 ? zero : BOX_SIGNED(n_b.y, hb.y),
                                  j2 ? zero : BOX_SIGNED(n_b.z, hb.z));
  Lane3 on_b = lane_add3(t, lane_out_of_frame(r, edge_b));
  const lane a_next = BOX_PICK(i0, i1, on_a.y, on_a.z, on_a.x), a_last = BOX_PICK(i0, i1, on_a.z, on_a.x, on_a.y);
  const lane b_next = BOX_PICK(j0, j1, edge_b.y, edge_b.z, edge_b.x);
  const lane b_last = BOX_PICK(j0, j1, edge_b.z, edge_b.x, edge_b.y);
  const lane name_a = box_edge_name(i, BOX_POSITIVE(a_next), BOX_POSITIVE(a_last));
  const lane name_b = box_edge_name(j, BOX_POSITIVE(b_next), BOX_POSITIVE(b_last));
  const Lane3 w = lane_sub3(on_a, on_b);
  const lane cosine = BOX_PICK(i0, i1, column.x, column.y, column.z), wi = BOX_PICK(i0, i1, w.x, w.y, w.z);
  const lane wj = lane_dot3(w, column), square_sine = one - cosine * cosine;
  const lane s = lane_clamp_to((cosine * wj - wi) / square_sine, BOX_PICK(i0, i1, ha.x, ha.y, ha.z));
  const lane u = lane_clamp_to((wj - cosine * wi) / square_sine, BOX_PICK(j0, j1, hb.x, hb.y, hb.z));
  on_a = lane_make3(i0 ? s : on_a.x, i1 ? s : on_a.y, i2 ? s : on_a.z);
  on_b = lane_add3(on_b, lane_scale3(u, column));
  const LaneAxes axes = lane_axes_of(a->rotation);
  LaneManifold m;
  m.normal = lane_out_of_frame(axes, n);
  m.frame = LANE_OF(NORMAL_FIXED);
  m.radius_a = m.radius_b = zero;
  m.anchor_a[0] = lane_add3(a->center, lane_out_of_frame(axes, on_a));
  m.anchor_b[0] = lane_add3(a->center, lane_out_of_frame(axes, on_b));
  m.feature[0] = LANE_OF(16) + LANE_OF(12) * name_a + name_b;
  for (int k = 1; k < 4; ++k) {
    m.anchor_a[k] = lane_make3(zero, zero, zero);
    m.anchor_b[k] = lane_make3(zero, zero, zero);
    m.feature[k] = LANE_OF(LANE_NO_FEATURE);
  }
  return m;
}

// ---- one pair ----------------------------------------------------------------------------------------------------

static inline LaneBox box_in_all_lanes(WorldShape world_shape) {
  LaneBox box;
  box.center = lane_make3(LANE_OF(world_shape.center.x), LANE_OF(world_shape.center.y), LANE_OF(world_shape.center.z));
  box.extents = lane_make3(LANE_OF(world_shape.size.x), LANE_OF(world_shape.size.y), LANE_OF(world_shape.size.z));
  box.rotation.x = LANE_OF(world_shape.rotation.x);
  box.rotation.y = LANE_OF(world_shape.rotation.y);
  box.rotation.z = LANE_OF(world_shape.rotation.z);
  box.rotation.w = LANE_OF(world_shape.rotation.w);
  return box;
}

static inline Vec3 box_first3(Lane3 v) { return make3(LANE_FIRST(v.x), LANE_FIRST(v.y), LANE_FIRST(v.z)); }

static inline Manifold box_box(WorldShape shape_a, WorldShape shape_b, real limit) {
  const LaneBox a = box_in_all_lanes(shape_a), b = box_in_all_lanes(shape_b);
  const BoxPair pair = box_pair(&a, &b);
  lane code;
  const lane separation = box_axis(&a, &b, &pair, &code);
  if (LANE_FIRST(separation) > limit) return no_manifold();
  const LaneManifold found =
      LANE_FIRST(code) < (real)6 ? box_faces(&a, &b, &pair, code, LANE_OF(limit)) : box_edges(&a, &b, &pair, code);
  Manifold m = manifold_along(box_first3(found.normal), (u32)LANE_FIRST(found.frame), (real)0, (real)0);
  for (u32 k = 0u; k < 4u; ++k) {
    if (LANE_FIRST(found.feature[k]) < (real)LANE_NO_FEATURE)
      m = with_point(m, box_first3(found.anchor_a[k]), box_first3(found.anchor_b[k]),
                     (u32)LANE_FIRST(found.feature[k]));
  }
  return m;
}

#endif
