// The corners of what two patches share (patch.h).
// cpu_reference/shapes/corners.hpp is the twin.
#ifndef LOCKSTEP_SHAPE_CORNERS_H
#define LOCKSTEP_SHAPE_CORNERS_H

#include "shapes/patch.h"

// A corner of what two patches share: a point of each, in line along the normal.
typedef struct SharedPoint {
  bool valid;
  Vec3 on_a, on_b;
  real gap;
  u32 feature;
} SharedPoint;

// Two patches that face each other. The first one is a segment if there is one, else a polygon if there is one.
// `width`: by how much two lines may pass each other by and touch there. `displacement`: of the first shape past the
// second one until contacts are evaluated (lagging_displacement).
typedef struct PatchPair {
  Patch first, second;
  bool swapped;  // the first one is of b
  Vec3 normal;
  real tolerance, width;
  Vec3 displacement;
} PatchPair;

// Segments within this sine of each other share a line, others a point.
static inline bool segments_cross(Vec3 u, Vec3 v, Vec3 normal) {
  const real across = dot3(cross3(u, v), normal);
  return across * across > (real)0.0025 * dot3(u, u) * dot3(v, v);
}

// The edge of a polygon in its place, for a line along u that meets it along a normal that is not that of its face:
// rounding would say which part of the line is over the face. The polygon itself where the line only crosses an edge
// of a face that is nearly flat, or meets a corner.
CALLED Patch edge_of_patch(const Patch* patch, Vec3 normal, Vec3 u) {
  const Vec3 out = scale3(patch->sense, normal);
  const real cosine = dot3(patch->plane, out);
  if (cosine > (real)1 - (real)5e-7 || patch->corners == 0) return *patch;
  Vec3 start = patch->center, end = start, from = patch_point(patch, patch->corners - 1);
  real most = (real)-1e30;
  for (u32 i = 0; i < patch->corners; ++i) {
    const Vec3 to = patch_point(patch, i);
    const real at_from = dot3(out, sub3(from, patch->center)), at_to = dot3(out, sub3(to, patch->center));
    const real lower = at_from < at_to ? at_from : at_to;
    if (lower > most) {
      most = lower;
      start = from;
      end = to;
    }
    from = to;
  }
  const Vec3 d = sub3(end, start);
  const real square = dot3(d, d), rise = dot3(out, d);
  if (rise * rise > (real)0.0025 * square) return *patch;
  if (segments_cross(u, d, normal) && cosine > (real)0.9) return *patch;
  return segment_patch(patch->sense, start, end, normal);
}

static inline PatchPair patch_pair(const Patch* a, const Patch* b, Vec3 normal, real tolerance, real width,
                                   Vec3 displacement) {
  PatchPair pair;
  pair.swapped = b->kind < a->kind;
  pair.first = pair.swapped ? *b : *a;
  pair.second = pair.swapped ? *a : *b;
  pair.normal = normal;
  pair.tolerance = tolerance;
  pair.width = width;
  pair.displacement = pair.swapped ? scale3((real)-1, displacement) : displacement;
  return pair;
}

static inline SharedPoint shared_point(const PatchPair* pair, Vec3 on_first, Vec3 on_second, u32 feature) {
  SharedPoint point;
  point.valid = true;
  point.on_a = pair->swapped ? on_second : on_first;
  point.on_b = pair->swapped ? on_first : on_second;
  point.gap = dot3(pair->normal, sub3(point.on_a, point.on_b));
  point.feature = feature;
  return point;
}

// Names: which of the kinds below, and up to two corners.
static inline u32 shared_name(u32 kind, u32 a, u32 b) { return kind << 24 | a << 12 | b; }

// The ends of what two segments share, or their crossing. Where they cross at a small angle they share what is no
// farther aside than the width: all of it where they are parallel.
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
    const CrossingShift shift = crossing_shift(u, v, pair->normal, pair->displacement);
    const real s = dot3(cross3(w, v), pair->normal) / across, t = dot3(cross3(w, u), pair->normal) / across;
    if (!within_share(s) || !within_share(t)) return none;
    return shared_point(pair, add3(p, scale3(clamp_share(s + shift.along_first), u)),
                        add3(q, scale3(clamp_share(t + shift.along_second), v)), shared_name(0, 0, 3));
  }
  Cut cut = {0, 1, NONE, NONE};
  if (vv > (real)0 && uu > (real)0) {
    const real at_start = dot3(v, sub3(p, q)), at_end = at_start + dot3(v, u);
    cut = cut_by_side(cut, at_start, at_end, (real)0, 0);
    cut = cut_by_side(cut, vv - at_start, vv - at_end, (real)0, 1);
    if (cut.from > cut.to) return none;
    const Vec3 side = cross3(pair->normal, v);
    const real beside = dot3(side, sub3(p, q)), change = dot3(side, u), width = pair->width * length3(side);
    Cut near = cut_by_side(cut, beside + width, beside + change + width, (real)0, 0);
    near = cut_by_side(near, width - beside, width - beside - change, (real)0, 1);
    if (near.from > near.to) {  // as far aside everywhere: the nearer end
      const real first = beside + cut.from * change, last = beside + cut.to * change;
      near.from = first * first < last * last ? cut.from : cut.to;
      near.to = near.from;
    }
    cut = near;
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
  if (!patch_contains(q, pair->normal, x, (real)10 * pair->tolerance)) return none;
  return shared_point(pair, x, patch_lift(q, pair->normal, x), shared_name(3, 4000, k));
}

CALLED SharedPoint shared_candidate(const PatchPair* pair, u32 k) {
  SharedPoint none = {0};
  const Patch* first = &pair->first;
  const Patch* second = &pair->second;
  const Vec3 n = pair->normal;
  if (first->kind == PATCH_SEGMENT && second->kind == PATCH_SEGMENT) return shared_by_segments(pair, k);
  const u32 corner_kind = pair->swapped ? 2 : 1, other_kind = pair->swapped ? 1 : 2;
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
      if (!patch_contains(second, n, x, (real)10 * pair->tolerance)) return none;
      return shared_point(pair, x, patch_lift(second, n, x), shared_name(corner_kind, patch_name(first, k), 0));
    }
    if (k < own + 2) return shared_by_rims(pair, k - own);
    i = k - own - 2;
  }
  const Vec3 x = patch_point(second, i);
  if (!patch_contains(first, n, x, (real)10 * pair->tolerance)) return none;
  return shared_point(pair, patch_lift(first, n, x), x, shared_name(other_kind, patch_name(second, i), 0));
}

typedef struct Chosen {
  u32 count;
  SharedPoint points[4];
} Chosen;

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

#endif
