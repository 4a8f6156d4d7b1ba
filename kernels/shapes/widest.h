// Which four points of what two patches share enclose most.
// cpu_reference/shapes/widest.hpp is the twin.
#ifndef LOCKSTEP_SHAPE_WIDEST_H
#define LOCKSTEP_SHAPE_WIDEST_H

#include "shapes/corners.h"

// Twice the area of four points, in any order: diagonals have the largest product.
static inline real shared_area(Vec3 p, Vec3 q, Vec3 r, Vec3 s, Vec3 normal) {
  const real pq = dot3(normal, cross3(sub3(q, p), sub3(s, r))), pr = dot3(normal, cross3(sub3(r, p), sub3(s, q)));
  const real ps = dot3(normal, cross3(sub3(s, p), sub3(r, q)));
  const real area_pq = pq < (real)0 ? -pq : pq, area_pr = pr < (real)0 ? -pr : pr, area_ps = ps < (real)0 ? -ps : ps;
  const real larger = area_pq > area_pr ? area_pq : area_pr;
  return area_ps > larger ? area_ps : larger;
}

// The point of a disc's rim that is farthest along a direction across the normal.
CALLED SharedPoint shared_on_rim(const PatchPair* pair, bool of_first, Vec3 direction, u32 i) {
  SharedPoint none = {0};
  const Patch* p = of_first ? &pair->first : &pair->second;
  const Patch* q = of_first ? &pair->second : &pair->first;
  if (p->kind != PATCH_DISC) return none;
  const Vec3 across = sub3(direction, scale3(dot3(direction, p->plane), p->plane));
  const Vec3 x = add3(p->center, scale3(p->radius / length3(across), across));
  if (!patch_contains(q, pair->normal, x, pair->tolerance)) return none;
  const Vec3 other = patch_lift(q, pair->normal, x);
  return shared_point(pair, of_first ? x : other, of_first ? other : x, shared_name(of_first ? 4 : 5, 0, i));
}

// Directions along which the corners of what two patches share are compared.
#define SHARED_DIRECTIONS 16u
// Names of points of an outline: candidates, points of the rims along a direction, and its origin, NONE.
#define SHARED_FIRST_RIM 65536u
#define SHARED_SECOND_RIM 131072u

// The points of what two patches share that reach farthest along each direction across the normal, seen from the first
// that was chosen; behind them a deepest one.
typedef struct Outline {
  Vec3 origin, u, v;  // by u and v about as wide as long
  u32 at[SHARED_DIRECTIONS];
  real distance[SHARED_DIRECTIONS], x[SHARED_DIRECTIONS + 1], y[SHARED_DIRECTIONS + 1];
  bool deep[SHARED_DIRECTIONS + 1];  // as deep as the deepest
} Outline;

CALLED void outline_offer(Outline* outline, const SharedPoint* point, u32 at, u32 first_direction, u32 end_direction,
                          bool deep) {
  const Vec3 d = sub3(point->on_a, outline->origin);
  const real x = dot3(outline->u, d), y = dot3(outline->v, d);
  const Vec3 along_x = make3((real)1, (real)0, (real)0), along_y = make3((real)0, (real)1, (real)0);
  for (u32 i = first_direction; i < end_direction; ++i) {
    const Vec3 direction = around_sixteenth(along_x, along_y, i);
    const real distance = direction.x * x + direction.y * y;
    // one that comes later must be farther by a little
    if (!(distance > outline->distance[i] + (real)0.001)) continue;
    outline->distance[i] = distance;
    outline->at[i] = at;
    outline->x[i] = x;
    outline->y[i] = y;
    outline->deep[i] = deep;
  }
}

// Rims have points along any direction: more of them than the fixed ones, which may all lie elsewhere.
CALLED Outline shared_outline(const PatchPair* pair, const SharedPoint* kept, u32 count, real limit, real least,
                              const SharedPoint* deepest, const Chosen* chosen) {
  Outline outline;
  outline.origin = chosen->points[0].on_a;
  const Vec3 d = sub3(chosen->points[1].on_a, outline.origin);
  const Vec3 across = sub3(d, scale3(dot3(pair->normal, d), pair->normal));
  const real length = length3(across);
  // corners of a narrow patch would be farthest in directions that are close to each other
  const Vec3 beside = cross3(pair->normal, across);
  const real h = dot3(beside, sub3(chosen->points[2].on_a, outline.origin)) / length, height = h < (real)0 ? -h : h;
  outline.u = scale3((real)1 / (length * length), across);
  outline.v = scale3((real)1 / (length * height), beside);
  for (u32 i = 0; i < SHARED_DIRECTIONS + 1; ++i) {
    outline.x[i] = outline.y[i] = (real)0;
    outline.deep[i] = chosen->points[0].gap <= least;
  }
  const Vec3 to_deepest = sub3(deepest->on_a, outline.origin);
  outline.x[SHARED_DIRECTIONS] = dot3(outline.u, to_deepest);
  outline.y[SHARED_DIRECTIONS] = dot3(outline.v, to_deepest);
  outline.deep[SHARED_DIRECTIONS] = true;
  for (u32 i = 0; i < SHARED_DIRECTIONS; ++i) {
    outline.at[i] = NONE;
    outline.distance[i] = (real)0;
  }
  for (u32 k = 0; k < count; ++k) {
    const SharedPoint point = shared_at(pair, kept, k);
    if (point.valid && point.gap <= limit) outline_offer(&outline, &point, k, 0, SHARED_DIRECTIONS, point.gap <= least);
  }
  for (u32 i = 0; i < SHARED_DIRECTIONS && pair->second.kind == PATCH_DISC; ++i) {
    for (u32 side = 0; side < 2; ++side) {
      const SharedPoint point = shared_on_rim(pair, side == 0, around_sixteenth(outline.u, outline.v, i), i);
      const u32 at = (side == 0 ? SHARED_FIRST_RIM : SHARED_SECOND_RIM) + i;
      if (point.valid && point.gap <= limit) outline_offer(&outline, &point, at, i, i + 1, point.gap <= least);
    }
  }
  return outline;
}

// Places in an outline, the last of them that of a deepest point. NONE where there is none.
typedef struct Widest {
  real area;  // twice
  u32 at[4];
} Widest;

// The four of them, one as deep as the deepest, that enclose most: on either side of a diagonal the farthest one.
static inline Widest outline_widest(const Outline* outline) {
  Widest widest = {(real)0, {NONE, NONE, NONE, NONE}};
  for (u32 i = 0; i < SHARED_DIRECTIONS; ++i) {
    if (i > 0 && outline->at[i] == outline->at[i - 1]) continue;
    for (u32 j = i + 1; j < SHARED_DIRECTIONS + 1; ++j) {
      if (j < SHARED_DIRECTIONS && outline->at[j] == outline->at[j - 1]) continue;
      const real dx = outline->x[j] - outline->x[i], dy = outline->y[j] - outline->y[i];
      real left = (real)0, right = (real)0, deep_left = (real)-1e30, deep_right = (real)-1e30;
      u32 at_left = NONE, at_right = NONE, at_deep_left = NONE, at_deep_right = NONE;
      for (u32 k = 0; k < SHARED_DIRECTIONS + 1; ++k) {
        const real beside = dx * (outline->y[k] - outline->y[i]) - dy * (outline->x[k] - outline->x[i]);
        if (beside > left) {
          left = beside;
          at_left = k;
        }
        if (-beside > right) {
          right = -beside;
          at_right = k;
        }
        if (outline->deep[k] && beside > deep_left) {
          deep_left = beside;
          at_deep_left = k;
        }
        if (outline->deep[k] && -beside > deep_right) {
          deep_right = -beside;
          at_deep_right = k;
        }
      }
      if (!outline->deep[i] && !outline->deep[j]) {
        const bool leftmost = deep_left + right > left + deep_right;
        left = leftmost ? deep_left : left;
        at_left = leftmost ? at_deep_left : at_left;
        right = leftmost ? right : deep_right;
        at_right = leftmost ? at_right : at_deep_right;
      }
      if (!(left + right > widest.area)) continue;
      widest.area = (real)1.001 * (left + right);
      widest.at[0] = i;
      widest.at[1] = j;
      widest.at[2] = at_left;
      widest.at[3] = at_right;
    }
  }
  return widest;
}

// The point of an outline at one of these slots.
static inline SharedPoint outline_point(const PatchPair* pair, const SharedPoint* kept, const Outline* outline,
                                        const SharedPoint* origin, const SharedPoint* deepest, u32 slot) {
  if (slot >= SHARED_DIRECTIONS) return *deepest;
  const u32 at = outline->at[slot];
  if (at == NONE) return *origin;
  if (at < SHARED_FIRST_RIM) return shared_at(pair, kept, at);
  const u32 i = at & (SHARED_DIRECTIONS - 1);
  return shared_on_rim(pair, at < SHARED_SECOND_RIM, around_sixteenth(outline->u, outline->v, i), i);
}

// Rounds of moving points along rims: each brings those of an arc four times nearer to where they enclose most.
#define RIM_ROUNDS 6u

// Moves corners of four along the rims that they are on, in turns the two beside either diagonal, to where they are
// farthest from it. One that is as deep as the deepest stays so.
static inline Chosen shared_along_rims(const PatchPair* pair, real limit, real least, Chosen four) {
  for (u32 round = 0; round < RIM_ROUNDS && pair->second.kind == PATCH_DISC; ++round) {
    const u32 from = 2 * (round & 1), beside = 2 - from;
    const Vec3 start = four.points[from].on_a, d = sub3(four.points[from + 1].on_a, start);
    const Vec3 left = cross3(pair->normal, d);
    const real length = length3(left);
    if (!(length > (real)0)) continue;
    const real h0 = dot3(left, sub3(four.points[beside].on_a, start));
    const real h1 = dot3(left, sub3(four.points[beside + 1].on_a, start));
    // a corner that is there twice is on either side
    const bool first_left = h0 > h1;
    for (u32 k = 0; k < 4; ++k) {
      const u32 slot = beside + (k >> 1);
      const real sense = (k < 2) == first_left ? (real)1 : (real)-1;
      const Vec3 direction = scale3(sense / length, left);
      const SharedPoint point = shared_on_rim(pair, (k & 1) == 0, direction, SHARED_DIRECTIONS + slot);
      if (!point.valid || !(point.gap <= limit)) continue;
      if (four.points[slot].gap <= least && !(point.gap <= least)) continue;
      if (!(dot3(direction, sub3(point.on_a, four.points[slot].on_a)) > (real)0.001 * length)) continue;
      four.points[slot] = point;
    }
  }
  return four;
}

// Takes the widest four of an outline in the place of the chosen ones, if they enclose more, or none of those is deep:
// what was chosen depends on the first one, and of an octagon many fours are such that no single point in the place of
// another helps. Little is not worth that contacts lose their features.
CALLED void shared_widen(const PatchPair* pair, const SharedPoint* kept, u32 count, real limit, real least,
                         const SharedPoint* deepest, Chosen* chosen) {
  const Outline outline = shared_outline(pair, kept, count, limit, least, deepest, chosen);
  const SharedPoint origin = chosen->points[0];
  const Widest widest = outline_widest(&outline);
  Chosen four = *chosen;
  for (u32 k = 0; k < 4; ++k)  // a triangle has its first corner twice
    four.points[k] =
        outline_point(pair, kept, &outline, &origin, deepest, widest.at[k] == NONE ? widest.at[0] : widest.at[k]);
  four = shared_along_rims(pair, limit, least, four);
  const Vec3 last = chosen->points[chosen->count == 4 ? 3 : 0].on_a;
  const real area = shared_area(origin.on_a, chosen->points[1].on_a, chosen->points[2].on_a, last, pair->normal);
  const real wider =
      shared_area(four.points[0].on_a, four.points[1].on_a, four.points[2].on_a, four.points[3].on_a, pair->normal);
  bool deep = false;
  for (u32 k = 0; k < chosen->count; ++k) deep = deep || chosen->points[k].gap <= least;
  if (deep && !(wider > (real)1.02 * area)) return;
  *chosen = four;
  chosen->count = 0;
  for (u32 k = 0; k < 4; ++k) {
    bool fresh = true;
    for (u32 i = 0; i < chosen->count; ++i) fresh = fresh && chosen->points[i].feature != four.points[k].feature;
    if (!fresh) continue;
    chosen->points[chosen->count] = four.points[k];
    chosen->count = chosen->count + 1;
  }
}

#endif
