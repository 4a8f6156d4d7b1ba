// Which four of the corners that two faces of boxes share become contacts, LANES pairs at once.
// cpu_reference/shapes/four_points.hpp is the twin and says more.
#ifndef LOCKSTEP_FOUR_POINTS_H
#define LOCKSTEP_FOUR_POINTS_H

#include "lane_sides.h"

#define BOX_PICK(is_0, is_1, a, b, c) ((is_0) ? (a) : ((is_1) ? (b) : (c)))
#define BOX_SLOTS 12
#define BOX_EACH_SLOT _Pragma("unroll") for (int i = 0; i < BOX_SLOTS; ++i)

typedef struct FacePair {
  lane hx, hy, hz, cx, cy, ux, uy, vx, vy, s0, sx, sy, kx, ky, mz, inverse_area, size;
  lane axis, incident, top, side;  // top, side: of the reference and the incident face, 1 the positive one
  lane_mask from_b;
} FacePair;

typedef struct FacePoints {
  lane x[BOX_SLOTS], y[BOX_SLOTS], feature[BOX_SLOTS];
  lane_mask taken[BOX_SLOTS];
} FacePoints;

// What is chosen.
typedef struct FourPoints {
  lane x[4], y[4], feature[4];
} FourPoints;

#define BOX_TAKE(k, gain)                      \
  best = take ? (gain) : best;                 \
  four.x[k] = take ? points->x[i] : four.x[k]; \
  four.y[k] = take ? points->y[i] : four.y[k]; \
  four.feature[k] = take ? points->feature[i] : four.feature[k];

// Twice the area of four points, in any order: diagonals have the largest product.
LANE_INLINE lane area_of_four(lane px, lane py, lane qx, lane qy, lane rx, lane ry, lane sx, lane sy) {
  const lane pq = fabs((qx - px) * (sy - ry) - (qy - py) * (sx - rx));
  const lane pr = fabs((rx - px) * (sy - qy) - (ry - py) * (sx - qx));
  const lane ps = fabs((sx - px) * (ry - qy) - (sy - py) * (rx - qx));
  const lane larger = pq > pr ? pq : pr;
  return ps > larger ? ps : larger;
}

// Twice the area of a triangle, positive where (x, y) is to the left of the way from p to q.
LANE_INLINE lane left_of(lane px, lane py, lane qx, lane qy, lane x, lane y) {
  return (qx - px) * (y - py) - (qy - py) * (x - px);
}

LANE_INLINE lane height_at(const FacePair* f, lane x, lane y) { return f->s0 + f->sx * x + f->sy * y; }

LANE_INLINE lane area_of_chosen(const FourPoints* four) {
  return area_of_four(four->x[0], four->y[0], four->x[1], four->y[1], four->x[2], four->y[2], four->x[3], four->y[3]);
}

#define BOX_WIDEN(k, allowed)                                                                                     \
  {                                                                                                               \
    const int q = (k + 1) & 3, r = (k + 2) & 3, t = (k + 3) & 3;                                                  \
    const lane area = area_of_four(x, y, four->x[q], four->y[q], four->x[r], four->y[r], four->x[t], four->y[t]); \
    const lane_mask better = (allowed) & (area > best);                                                           \
    best = better ? area : best;                                                                                  \
    slot = better ? LANE_OF(k) : slot;                                                                            \
  }
#define BOX_STORE(k)                                \
  four->x[k] = slot == LANE_OF(k) ? x : four->x[k]; \
  four->y[k] = slot == LANE_OF(k) ? y : four->y[k]; \
  four->feature[k] = slot == LANE_OF(k) ? feature : four->feature[k];

// Takes points in the place of others where the four then enclose more, in the lanes of `which`. Says in which.
LANE_INLINE lane_mask widen_four(FourPoints* four, const FacePoints* points, const FacePair* f, lane least,
                                 lane_mask which) {
  const lane nowhere = LANE_OF(4);
  lane widened = LANE_OF(0);
  lane best = LANE_OF(1.001) * area_of_chosen(four);
  BOX_EACH_SLOT {
    const lane x = points->x[i], y = points->y[i], feature = points->feature[i];
    const lane_mask fresh = which & points->taken[i] & (feature != four->feature[0]) & (feature != four->feature[1]) &
                            (feature != four->feature[2]) & (feature != four->feature[3]);
    lane slot = nowhere;
    BOX_WIDEN(0, fresh & (height_at(f, x, y) <= least))
    BOX_WIDEN(1, fresh)
    BOX_WIDEN(2, fresh)
    BOX_WIDEN(3, fresh)
    BOX_STORE(0)
    BOX_STORE(1)
    BOX_STORE(2)
    BOX_STORE(3)
    best = slot == nowhere ? best : LANE_OF(1.001) * best;
    widened = slot == nowhere ? widened : LANE_OF(1);
  }
  return widened > LANE_OF(0);
}

// The same four, counter-clockwise.
LANE_INLINE FourPoints ordered_four(const FourPoints* four) {
  const lane *x = four->x, *y = four->y, *feature = four->feature;
  const lane_mask clockwise = left_of(x[0], y[0], x[1], y[1], x[2], y[2]) < LANE_OF(0);
  const lane px = clockwise ? x[2] : x[1], py = clockwise ? y[2] : y[1];
  const lane qx = clockwise ? x[1] : x[2], qy = clockwise ? y[1] : y[2];
  const lane p = clockwise ? feature[2] : feature[1], q = clockwise ? feature[1] : feature[2];
  const lane beside_0 = left_of(x[0], y[0], px, py, x[3], y[3]), beside_1 = left_of(px, py, qx, qy, x[3], y[3]);
  const lane beside_2 = left_of(qx, qy, x[0], y[0], x[3], y[3]);
  const lane_mask in_1 = (beside_0 <= beside_1) & (beside_0 <= beside_2), in_2 = beside_1 <= beside_2;
  FourPoints ordered;
  ordered.x[0] = x[0];
  ordered.y[0] = y[0];
  ordered.feature[0] = feature[0];
  ordered.x[1] = in_1 ? x[3] : px;
  ordered.y[1] = in_1 ? y[3] : py;
  ordered.feature[1] = in_1 ? feature[3] : p;
  ordered.x[2] = BOX_PICK(in_1, in_2, px, x[3], qx);
  ordered.y[2] = BOX_PICK(in_1, in_2, py, y[3], qy);
  ordered.feature[2] = BOX_PICK(in_1, in_2, p, feature[3], q);
  ordered.x[3] = (in_1 | in_2) ? qx : x[3];
  ordered.y[3] = (in_1 | in_2) ? qy : y[3];
  ordered.feature[3] = (in_1 | in_2) ? q : feature[3];
  return ordered;
}

// Takes, in the place of all four, the points farthest outside of their sides, where those enclose more and one of them
// is as deep, in the lanes of `which`. Says in which.
LANE_INLINE lane_mask replace_four(FourPoints* four, const FacePoints* points, const FacePair* f, lane least,
                                   lane_mask which) {
  const FourPoints old = ordered_four(four);
  FourPoints outer = old;
  _Pragma("unroll") for (int k = 0; k < 4; ++k) {
    const int next = (k + 1) & 3;
    lane farthest = LANE_OF(0);
    BOX_EACH_SLOT {
      const lane x = points->x[i], y = points->y[i];
      const lane beside = left_of(old.x[k], old.y[k], old.x[next], old.y[next], x, y);
      const lane_mask take = points->taken[i] & (beside < farthest);
      farthest = take ? beside : farthest;
      outer.x[k] = take ? x : outer.x[k];
      outer.y[k] = take ? y : outer.y[k];
      outer.feature[k] = take ? points->feature[i] : outer.feature[k];
    }
  }
  lane_mask wider = which & (area_of_chosen(&outer) > LANE_OF(1.001) * area_of_chosen(four));
  // rounding may have one point outside of two sides
  for (int k = 0; k < 4; ++k) wider &= outer.feature[k] != outer.feature[(k + 1) & 3];
  // the deepest one stays the first
  lane_mask deep = height_at(f, outer.x[0], outer.y[0]) <= least;
  _Pragma("unroll") for (int k = 1; k < 4; ++k) {
    const lane x = outer.x[0], y = outer.y[0], feature = outer.feature[0];
    outer.x[0] = deep ? x : outer.x[k];
    outer.y[0] = deep ? y : outer.y[k];
    outer.feature[0] = deep ? feature : outer.feature[k];
    outer.x[k] = deep ? outer.x[k] : x;
    outer.y[k] = deep ? outer.y[k] : y;
    outer.feature[k] = deep ? outer.feature[k] : feature;
    deep = height_at(f, outer.x[0], outer.y[0]) <= least;
  }
  const lane_mask take = wider & deep;
  for (int k = 0; k < 4; ++k) {
    four->x[k] = take ? outer.x[k] : four->x[k];
    four->y[k] = take ? outer.y[k] : four->y[k];
    four->feature[k] = take ? outer.feature[k] : four->feature[k];
  }
  return take;
}

LANE_INLINE FourPoints four_points(FacePoints* points, const FacePair* f, lane limit) {
  FourPoints four;
  const lane zero = LANE_OF(0), none = LANE_OF(LANE_NO_FEATURE);
  for (int k = 0; k < 4; ++k) four.x[k] = zero, four.y[k] = zero, four.feature[k] = none;
  const lane least = LANE_OF(1e-8) * f->size * f->size;
  lane best = limit;
  BOX_EACH_SLOT {
    const lane s = f->s0 + f->sx * points->x[i] + f->sy * points->y[i];
    points->taken[i] = points->taken[i] & (s <= limit);
    const lane_mask take = points->taken[i] & ((s < best) | (four.feature[0] == none));
    BOX_TAKE(0, s)
  }
  best = least;
  BOX_EACH_SLOT {
    const lane dx = points->x[i] - four.x[0], dy = points->y[i] - four.y[0], d = dx * dx + dy * dy;
    const lane_mask take = points->taken[i] & (d > best);
    BOX_TAKE(1, d)
  }
  const lane_mask two = four.feature[1] != none;
  const lane wx = two ? four.x[1] - four.x[0] : zero, wy = two ? four.y[1] - four.y[0] : zero;
  lane area = zero;
  best = least;
  BOX_EACH_SLOT {
    const lane w = wx * (points->y[i] - four.y[0]) - wy * (points->x[i] - four.x[0]);
    const lane_mask take = points->taken[i] & (fabs(w) > best);
    area = take ? w : area;
    BOX_TAKE(2, fabs(w))
  }
  const lane_mask three = four.feature[2] != none, clockwise = area < zero;
  const lane ax = four.x[0], ay = four.y[0];
  const lane px = clockwise ? four.x[2] : four.x[1], py = clockwise ? four.y[2] : four.y[1];
  const lane qx = clockwise ? four.x[1] : four.x[2], qy = clockwise ? four.y[1] : four.y[2];
  best = least;
  BOX_EACH_SLOT {
    const lane x = points->x[i], y = points->y[i];
    const lane w0 = (py - ay) * (x - ax) - (px - ax) * (y - ay);
    const lane w1 = (qy - py) * (x - px) - (qx - px) * (y - py);
    const lane w2 = (ay - qy) * (x - qx) - (ax - qx) * (y - qy);
    lane w = w0 > w1 ? w0 : w1;
    w = w2 > w ? w2 : w;
    const lane_mask take = points->taken[i] & three & (w > best);
    BOX_TAKE(3, w)
  }
  lane corners = zero;
  BOX_EACH_SLOT corners = points->taken[i] ? corners + LANE_OF(1) : corners;
  const lane_mask choice = (four.feature[3] != none) & (corners > LANE_OF(4));
  if (!LANE_ANY(choice)) return four;
  const lane as_deep = height_at(f, four.x[0], four.y[0]) + LANE_OF(1e-6) * f->size;
  lane_mask changed = widen_four(&four, points, f, as_deep, choice);
  changed |= replace_four(&four, points, f, as_deep, choice);
  if (LANE_ANY(changed)) widen_four(&four, points, f, as_deep, changed);
  return four;
}

#endif
