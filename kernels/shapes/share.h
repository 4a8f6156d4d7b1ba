// The manifold of what two patches share (patch.hpp): up to four points that keep the depth and most of the area.
// cpu_reference/shapes/share.hpp is the twin.
#ifndef LOCKSTEP_SHARE_H
#define LOCKSTEP_SHARE_H

#include "shapes/patch.h"

// A corner of what two patches share: a point of each, in line along the normal.
typedef struct SharedPoint {
  bool valid;
  Vec3 on_a, on_b;
  real gap;
  u32 feature;
} SharedPoint;

// Two patches that face each other. The first one is a segment if there is one, else a polygon if there is one.
typedef struct PatchPair {
  Patch first, second;
  bool turned;  // the first one is of b
  Vec3 normal;
  real tolerance;
} PatchPair;

// Segments within this sine of each other share a line, others a point.
static inline bool segments_cross(Vec3 u, Vec3 v, Vec3 normal) {
  const real across = dot3(cross3(u, v), normal);
  return across * across > (real)1e-4 * dot3(u, u) * dot3(v, v);
}

static inline PatchPair patch_pair(const Patch* a, const Patch* b, Vec3 normal, real tolerance) {
  PatchPair pair;
  pair.turned = b->kind < a->kind;
  pair.first = pair.turned ? *b : *a;
  pair.second = pair.turned ? *a : *b;
  pair.normal = normal;
  pair.tolerance = tolerance;
  return pair;
}

static inline SharedPoint shared_point(const PatchPair* pair, Vec3 on_first, Vec3 on_second, u32 feature) {
  SharedPoint point;
  point.valid = true;
  point.on_a = pair->turned ? on_second : on_first;
  point.on_b = pair->turned ? on_first : on_second;
  point.gap = dot3(pair->normal, sub3(point.on_a, point.on_b));
  point.feature = feature;
  return point;
}

// Names: which of the kinds below, and up to two corners.
static inline u32 shared_name(u32 kind, u32 a, u32 b) { return kind << 24 | a << 12 | b; }

// The ends of what two segments share, or their crossing.
static inline SharedPoint shared_by_segments(const PatchPair* pair, u32 k) {
  const Vec3 p = pair->first.center, u = sub3(pair->first.end, p);
  const Vec3 q = pair->second.center, v = sub3(pair->second.end, q);
  const real vv = dot3(v, v), uu = dot3(u, u);
  SharedPoint none = {0};
  if (segments_cross(u, v, pair->normal)) {
    if (k > 0) return none;
    // in line along the normal: s u - t v + (p - q) has no part across it
    const Vec3 w = sub3(q, p);
    const real across = dot3(cross3(u, v), pair->normal);
    const real s = dot3(cross3(w, v), pair->normal) / across, t = dot3(cross3(w, u), pair->normal) / across;
    const real s1 = s < (real)0   ? (real)0
                    : s > (real)1 ? (real)1
                                  : s,
               t1 = t < (real)0   ? (real)0
                    : t > (real)1 ? (real)1
                                  : t;
    return shared_point(pair, add3(p, scale3(s1, u)), add3(q, scale3(t1, v)), shared_name(0, 0, 3));
  }
  Cut cut = {0, 1, NONE, NONE};
  if (vv > (real)0 && uu > (real)0) {
    const real at_start = dot3(v, sub3(p, q)), at_end = at_start + dot3(v, u);
    cut = cut_by_side(cut, at_start, at_end, (real)0, 0);
    cut = cut_by_side(cut, vv - at_start, vv - at_end, (real)0, 1);
  }
  if (cut.from > cut.to) return none;
  const Vec3 x = add3(p, scale3(k == 0 ? cut.from : cut.to, u));
  const real share = vv > (real)0 ? dot3(v, sub3(x, q)) / vv : (real)0;
  const real clamped = share < (real)0 ? (real)0 : share > (real)1 ? (real)1 : share;
  return shared_point(pair, x, add3(q, scale3(clamped, v)), shared_name(0, 0, 1 + k));
}

// Candidates: two a line of the first patch, then its own points where it has no lines, then those of the second.
static inline u32 shared_count(const PatchPair* pair) {
  if (pair->first.kind == PATCH_SEGMENT) return 2;
  const u32 own = pair->first.kind == PATCH_POLYGON ? 2 * pair->first.corners : patch_points(&pair->first) + 2;
  return own + patch_points(&pair->second);
}

// Where the rims of two discs cross, seen as circles; k is 0 or 1.
static inline SharedPoint shared_by_rims(const PatchPair* pair, u32 k) {
  SharedPoint none = {0};
  const Patch* p = &pair->first;
  const Patch* q = &pair->second;
  const Vec3 d = sub3(patch_lift(p, pair->normal, q->center), p->center);
  const real square = dot3(d, d);
  if (!(square > (real)0)) return none;
  const real along = (real)0.5 * (square + p->radius * p->radius - q->radius * q->radius) / square;
  const real height = p->radius * p->radius - along * along * square;
  if (!(height > (real)0)) return none;
  const real side = (k == 0 ? sqrt(height) : -sqrt(height)) / sqrt(square);
  const Vec3 x = add3(p->center, add3(scale3(along, d), scale3(side, cross3(p->plane, d))));
  // discs that are tilted against each other are no circles: such a point may be off
  if (!patch_holds(q, pair->normal, x, (real)10 * pair->tolerance)) return none;
  return shared_point(pair, x, patch_lift(q, pair->normal, x), shared_name(3, 4000, k));
}

static inline SharedPoint shared_candidate(const PatchPair* pair, u32 k) {
  SharedPoint none = {0};
  const Patch* first = &pair->first;
  const Patch* second = &pair->second;
  const Vec3 n = pair->normal;
  if (first->kind == PATCH_SEGMENT && second->kind == PATCH_SEGMENT) return shared_by_segments(pair, k);
  const u32 corner_kind = pair->turned ? 2 : 1, other_kind = pair->turned ? 1 : 2;
  if (first->kind == PATCH_SEGMENT) {
    const Cut cut = patch_cut(second, n, first->center, first->end, pair->tolerance);
    if (cut.from > cut.to) return none;
    const Vec3 x = add3(first->center, scale3(k == 0 ? cut.from : cut.to, sub3(first->end, first->center)));
    return shared_point(pair, x, patch_lift(second, n, x), shared_name(0, 0, 1 + k));
  }
  u32 i = k;
  if (first->kind == PATCH_POLYGON) {
    if (k < 2 * first->corners) {
      const u32 c = k >> 1, next = c + 1 == first->corners ? 0 : c + 1;
      const Vec3 start = patch_point(first, c), end = patch_point(first, next);
      const Cut cut = patch_cut(second, n, start, end, pair->tolerance);
      const bool ends = (k & 1) != 0;
      if (cut.from > cut.to || (ends && cut.out == NONE)) return none;
      const Vec3 x = add3(start, scale3(ends ? cut.to : cut.from, sub3(end, start)));
      const u32 cut_at = ends ? cut.out : cut.in, name = patch_name(first, c);
      return shared_point(pair, x, patch_lift(second, n, x),
                          cut_at == NONE ? shared_name(corner_kind, name, 0) : shared_name(3, name, cut_at));
    }
    i = k - 2 * first->corners;
  } else {
    const u32 own = patch_points(first);
    if (k < own) {
      const Vec3 x = patch_point(first, k);
      if (!patch_holds(second, n, x, pair->tolerance)) return none;
      return shared_point(pair, x, patch_lift(second, n, x), shared_name(corner_kind, patch_name(first, k), 0));
    }
    if (k < own + 2) return shared_by_rims(pair, k - own);
    i = k - own - 2;
  }
  const Vec3 x = patch_point(second, i);
  if (!patch_holds(first, n, x, pair->tolerance)) return none;
  return shared_point(pair, patch_lift(first, n, x), x, shared_name(other_kind, patch_name(second, i), 0));
}

// The deepest point of a tilted disc wanders: it counts where no other point is as deep, and for nothing else.
static inline bool shared_wanders(const PatchPair* pair, u32 k) {
  const u32 count = shared_count(pair);
  if (pair->first.kind == PATCH_SEGMENT) return false;
  if (pair->second.kind == PATCH_DISC && k + 1 == count) return true;
  return pair->first.kind == PATCH_DISC && k + 1 == DISC_POINTS;
}

typedef struct Chosen {
  u32 count;
  SharedPoint points[4];
} Chosen;

// How much a point adds to the chosen ones: nothing it has already; a length, then areas.
static inline real shared_gain(const Chosen* chosen, Vec3 normal, const SharedPoint* point) {
  const Vec3 p = chosen->points[0].on_a;
  const Vec3 x = sub3(point->on_a, p);
  if (chosen->count == 1) return length3(cross3(normal, x));
  const Vec3 q = sub3(chosen->points[1].on_a, p);
  const real beside_pq = dot3(normal, cross3(q, x));
  if (chosen->count == 2) return beside_pq < (real)0 ? -beside_pq : beside_pq;
  const Vec3 r = sub3(chosen->points[2].on_a, p);
  const real sense = dot3(normal, cross3(q, r)) > (real)0 ? (real)-1 : (real)1;  // outside is positive
  const real beside_qr = dot3(normal, cross3(sub3(r, q), sub3(x, q))), beside_rp = dot3(normal, cross3(x, r));
  real gain = sense * beside_pq;
  gain = sense * beside_qr > gain ? sense * beside_qr : gain;
  return sense * beside_rp > gain ? sense * beside_rp : gain;
}

// Sorted by feature.
static inline void shared_sort(Chosen* chosen) {
  for (u32 i = 1; i < chosen->count; ++i) {
    for (u32 j = i; j > 0 && chosen->points[j].feature < chosen->points[j - 1].feature; --j) {
      const SharedPoint point = chosen->points[j];
      chosen->points[j] = chosen->points[j - 1];
      chosen->points[j - 1] = point;
    }
  }
}

// The candidates are gone through several times: a CPU device keeps them, a work-item of a GPU would have to keep them
// in memory far away and makes them anew.
#define SHARED_MOST 384u  // three a corner of the largest faces: hulls have at most 128 vertices (host/scene/hull.hpp)
static inline SharedPoint shared_at(const PatchPair* pair, const SharedPoint* kept, u32 k) {
#if LANES > 1
  return kept[k];
#else
  return shared_candidate(pair, k);
#endif
}

// Twice the area of four points, in any order: diagonals have the largest product.
static inline real shared_area(Vec3 p, Vec3 q, Vec3 r, Vec3 s, Vec3 normal) {
  const real pq = dot3(normal, cross3(sub3(q, p), sub3(s, r))), pr = dot3(normal, cross3(sub3(r, p), sub3(s, q)));
  const real ps = dot3(normal, cross3(sub3(s, p), sub3(r, q)));
  const real area_pq = pq < (real)0 ? -pq : pq, area_pr = pr < (real)0 ? -pr : pr, area_ps = ps < (real)0 ? -ps : ps;
  const real larger = area_pq > area_pr ? area_pq : area_pr;
  return area_ps > larger ? area_ps : larger;
}

static inline bool shared_has(const Chosen* chosen, u32 feature) {
  return chosen->points[0].feature == feature || chosen->points[1].feature == feature ||
         chosen->points[2].feature == feature || chosen->points[3].feature == feature;
}

static inline real shared_area_of(const Chosen* chosen, Vec3 normal) {
  const SharedPoint* at = chosen->points;
  return shared_area(at[0].on_a, at[1].on_a, at[2].on_a, at[3].on_a, normal);
}

// Takes points in the place of others where the four then enclose more: what was chosen depends on the first one,
// which may be any of those that are as deep. It gives way only to one of these: up to `least`.
static inline bool shared_widen(const PatchPair* pair, const SharedPoint* kept, u32 count, real limit, real least,
                                Chosen* chosen) {
  const SharedPoint* at = chosen->points;
  real best = (real)1.001 * shared_area_of(chosen, pair->normal);
  bool widened = false;
  for (u32 k = 0; k < count; ++k) {
    if (shared_wanders(pair, k)) continue;
    const SharedPoint point = shared_at(pair, kept, k);
    if (!point.valid || !(point.gap <= limit) || shared_has(chosen, point.feature)) continue;
    u32 place = 4;
    for (u32 i = point.gap <= least ? 0 : 1; i < 4; ++i) {
      const real area =
          shared_area(point.on_a, at[(i + 1) & 3].on_a, at[(i + 2) & 3].on_a, at[(i + 3) & 3].on_a, pair->normal);
      if (!(area > best)) continue;
      best = area;
      place = i;
    }
    if (place == 4) continue;
    best = (real)1.001 * best;
    chosen->points[place] = point;
    widened = true;
  }
  return widened;
}

// Twice the area of a triangle, positive where x is to the left of the way from p to q, seen from where the normal
// points.
static inline real shared_beside(Vec3 p, Vec3 q, Vec3 x, Vec3 normal) {
  return dot3(normal, cross3(sub3(q, p), sub3(x, p)));
}

// The same four, counter-clockwise: the last one goes where it is farthest outside of the triangle of the others.
static inline Chosen shared_ordered(const Chosen* chosen, Vec3 normal) {
  const SharedPoint* at = chosen->points;
  const bool clockwise = shared_beside(at[0].on_a, at[1].on_a, at[2].on_a, normal) < (real)0;
  const SharedPoint p = at[clockwise ? 2 : 1], q = at[clockwise ? 1 : 2];
  const real beside_0 = shared_beside(at[0].on_a, p.on_a, at[3].on_a, normal);
  const real beside_1 = shared_beside(p.on_a, q.on_a, at[3].on_a, normal);
  const real beside_2 = shared_beside(q.on_a, at[0].on_a, at[3].on_a, normal);
  const bool in_1 = beside_0 <= beside_1 && beside_0 <= beside_2, in_2 = !in_1 && beside_1 <= beside_2;
  Chosen ordered = *chosen;
  ordered.points[1] = in_1 ? at[3] : p;
  ordered.points[2] = in_1 ? p : in_2 ? at[3] : q;
  ordered.points[3] = in_1 || in_2 ? q : at[3];
  return ordered;
}

// Takes, in the place of all four, the points farthest outside of their sides, where those enclose more and one of
// them is as deep: of an octagon, two fours may both be such that no single point in the place of another helps.
static inline bool shared_turn(const PatchPair* pair, const SharedPoint* kept, u32 count, real limit, real least,
                               Chosen* chosen) {
  const Chosen old = shared_ordered(chosen, pair->normal);
  Chosen turned = old;
  real farthest[4] = {0};
  for (u32 k = 0; k < count; ++k) {
    if (shared_wanders(pair, k)) continue;
    const SharedPoint point = shared_at(pair, kept, k);
    if (!point.valid || !(point.gap <= limit)) continue;
    for (u32 i = 0; i < 4; ++i) {
      const real beside = shared_beside(old.points[i].on_a, old.points[(i + 1) & 3].on_a, point.on_a, pair->normal);
      if (!(beside < farthest[i])) continue;
      farthest[i] = beside;
      turned.points[i] = point;
    }
  }
  for (u32 i = 0; i < 4; ++i)  // rounding may have one point outside of two sides
    if (turned.points[i].feature == turned.points[(i + 1) & 3].feature) return false;
  if (!(shared_area_of(&turned, pair->normal) > (real)1.001 * shared_area_of(chosen, pair->normal))) return false;
  // the deepest one stays the first
  for (u32 i = 1; i < 4 && !(turned.points[0].gap <= least); ++i) {
    const SharedPoint kept = turned.points[0];
    turned.points[0] = turned.points[i];
    turned.points[i] = kept;
  }
  if (!(turned.points[0].gap <= least)) return false;
  *chosen = turned;
  return true;
}

// Up to four points: the deepest, the farthest from it, the farthest from their line, the farthest outside of the
// triangle; then those in whose place they enclose more. `meeting` is the deepest point where the patches show none as
// deep. `scale` is the size of the smaller shape.
static inline Manifold share_patches(const Patch* a, const Patch* b, real radius_a, real radius_b,
                                     const Meeting* meeting, real limit, real tolerance, real scale) {
  const PatchPair pair = patch_pair(a, b, meeting->normal, tolerance);
  const u32 count = shared_count(&pair);
#if LANES > 1
  SharedPoint kept[SHARED_MOST];
  for (u32 k = 0; k < count; ++k) kept[k] = shared_candidate(&pair, k);
#else
  const SharedPoint* kept = 0;
#endif
  Chosen chosen = {0};
  real deepest = (real)1e30;
  u32 valid = 0;
  for (u32 k = 0; k < count; ++k) {
    const SharedPoint point = shared_at(&pair, kept, k);
    if (!point.valid) continue;
    ++valid;
    if (!(point.gap < deepest - tolerance)) continue;
    deepest = point.gap;
    chosen.points[0] = point;
  }
  // the farthest point of a shape need not lie over the face that it is farthest behind: other points come first
  const bool sure = meeting->frame == NORMAL_FIXED || meeting->place > (real)-1e29;
  if (valid == 0 || (sure && meeting->gap < deepest - (real)2 * tolerance)) {
    chosen.points[0].on_a = meeting->at_a;
    chosen.points[0].on_b = meeting->at_b;
    chosen.points[0].gap = meeting->gap;
    chosen.points[0].feature = 0;
  }
  chosen.count = 1;
  for (u32 pass = 1; pass < 4 && chosen.count == pass; ++pass) {
    bool found = false;
    real best = (real)0.001 * scale;
    if (pass > 1) best = best * length3(sub3(chosen.points[1].on_a, chosen.points[0].on_a));
    for (u32 k = 0; k < count; ++k) {
      if (shared_wanders(&pair, k)) continue;
      const SharedPoint point = shared_at(&pair, kept, k);
      if (!point.valid || !(point.gap <= limit)) continue;
      const real gain = shared_gain(&chosen, meeting->normal, &point);
      if (!(gain > best)) continue;
      best = gain * (real)1.001;
      chosen.points[pass] = point;
      found = true;
    }
    if (found) chosen.count = pass + 1;
  }
  if (chosen.count == 4 && valid > 4) {
    const real least = chosen.points[0].gap + tolerance;
    const bool widened = shared_widen(&pair, kept, count, limit, least, &chosen);
    if (shared_turn(&pair, kept, count, limit, least, &chosen) || widened)
      shared_widen(&pair, kept, count, limit, least, &chosen);
  }
  shared_sort(&chosen);
  Manifold m = manifold_along(meeting->normal, meeting->frame, radius_a, radius_b);
  for (u32 k = 0; k < chosen.count; ++k) {
    m = with_point(m, add3(chosen.points[k].on_a, scale3(radius_a, meeting->normal)),
                   sub3(chosen.points[k].on_b, scale3(radius_b, meeting->normal)), chosen.points[k].feature);
  }
  return m;
}

#endif
