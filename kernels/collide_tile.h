// The pairs of a tile that go through lanes: neighbours in the list of pairs, sorted by what is to be done with them,
// so that no lane waits for another case and what they read stays in the cache. The same as collide_pair does, bit for
// bit.
#ifndef LOCKSTEP_COLLIDE_TILE_H
#define LOCKSTEP_COLLIDE_TILE_H

#include "shapes/box_box.h"
#include "shapes/box_round_lanes.h"

// At most so many pairs (host/device/launches/collision.cpp).
#define TILE_PAIRS 128u

// What is to be done with a pair: sorts that have lanes, and all others.
enum TileSort {
  TILE_FACES = 0,    // boxes
  TILE_CORNERS = 1,  // boxes whose faces do not meet
  TILE_SPHERE_BOX = 2,
  TILE_BOX_SPHERE = 3,
  TILE_BOX_PLANE = 4,
  TILE_LANE_SORTS = 5,
  TILE_BOXES = 5,  // whose axis is not known yet
  TILE_OTHERS = 6,
  TILE_SORTS = 7
};

// Pairs of one sort.
typedef struct TileList {
  u32 count;
  u32 at[TILE_PAIRS + 1u];  // slots in the tile; one more, so that what does not belong can be written and not counted
} TileList;

LANE_INLINE void tile_append(TileList* list, u32 slot, u32 belongs) {
  list->at[list->count] = slot;
  list->count += belongs;
}

typedef struct Tile {
  u32 first;  // pair
  u32 shape_a[TILE_PAIRS], shape_b[TILE_PAIRS], body_a[TILE_PAIRS], body_b[TILE_PAIRS];
  TileList lists[TILE_SORTS];
  real codes[TILE_PAIRS], separations[TILE_PAIRS];  // of the axes of pairs of boxes
} Tile;

// Pairs of triggers, of bodies whose impacts are looked for and of shapes with seams are among the others.
static inline u32 tile_sort_of(u32 kind_a, u32 kind_b, u32 flags) {
  const bool box_a = kind_a == SHAPE_BOX, box_b = kind_b == SHAPE_BOX;
  u32 sort = TILE_OTHERS;
  sort = box_a && box_b ? TILE_BOXES : sort;
  sort = kind_a == SHAPE_SPHERE && box_b ? TILE_SPHERE_BOX : sort;
  sort = box_a && kind_b == SHAPE_SPHERE ? TILE_BOX_SPHERE : sort;
  sort = box_a && kind_b == SHAPE_PLANE ? TILE_BOX_PLANE : sort;
  return (flags & (SHAPE_IS_TRIGGER | SHAPE_IS_CONTINUOUS | SHAPE_HAS_SEAMS)) == 0u ? sort : TILE_OTHERS;
}

static inline void tile_sort(Tile* tile, u32 first, u32 end, global const Pair* pairs,
                             global const ShapeInfo* shape_infos) {
  tile->first = first;
  for (u32 sort = 0u; sort < TILE_SORTS; ++sort) tile->lists[sort].count = 0u;
  for (u32 i = 0u; i < end - first; ++i) {
    const Pair pair = pairs[first + i];
    global const ShapeInfo *a = shape_infos + pair.shape_a, *b = shape_infos + pair.shape_b;
    tile->shape_a[i] = pair.shape_a;
    tile->shape_b[i] = pair.shape_b;
    tile->body_a[i] = a->body;
    tile->body_b[i] = b->body;
    tile_append(&tile->lists[tile_sort_of(a->kind, b->kind, a->flags | b->flags)], i, 1u);
  }
}

// LANES members of a list from the first on; behind its end the last one is repeated. Returns how many there are.
LANE_INLINE u32 tile_lanes(LanePairs* group, const Tile* tile, const TileList* list, u32 first) {
  for (u32 k = 0u; k < LANES; ++k) {
    const u32 i = list->at[first + k < list->count ? first + k : list->count - 1u];
    group->pair[k] = tile->first + i;
    group->shape_a[k] = tile->shape_a[i];
    group->shape_b[k] = tile->shape_b[i];
    group->body_a[k] = tile->body_a[i];
    group->body_b[k] = tile->body_b[i];
  }
  return list->count - first < LANES ? list->count - first : LANES;
}

LANE_INLINE LaneBox box_of_side(const LaneSide* side) {
  const LaneBox box = {side->center, side->size, side->rotation};
  return box;
}

// Finds the separating axes of pairs of boxes, and which of them can touch.
static inline void tile_box_axes(const StepParams* params, Tile* tile, const SideTables* tables,
                                 global u32* contact_starts) {
  const TileList* boxes = &tile->lists[TILE_BOXES];
  for (u32 first = 0u; first < boxes->count; first += LANES) {
    LanePairs group;
    LaneSides sides;
    const u32 members = tile_lanes(&group, tile, boxes, first);
    lane_sides(&sides, tables, &group);
    const LaneBox a = box_of_side(&sides.a), b = box_of_side(&sides.b);
    const BoxPair pair = box_pair(&a, &b);
    const BoxAxis axis = box_axis(&a, &b, &pair);
    real codes[LANES], separations[LANES];
    LANE_STORE(axis.code, codes);
    LANE_STORE(axis.separation, separations);
    const u32 near = ~LANE_BITS(axis.separation > lane_limit(params, &sides));
    for (u32 k = 0u; k < members; ++k) {
      const u32 i = group.pair[k] - tile->first;
      contact_starts[group.pair[k]] = 0u;
      tile->codes[i] = codes[k];
      tile->separations[i] = separations[k];
      tile_append(&tile->lists[TILE_FACES], i, near >> k & 1u);
    }
  }
}

// How far the shapes move past each other in the step, b seen from a.
LANE_INLINE Lane3 tile_displacement(const StepParams* params, const LaneSides* s) {
  const lane h = LANE_OF(step_length(params));
  return lane_sub3(lane_scale3(h, lane_point_velocity(&s->b, s->b.arm)),
                   lane_scale3(h, lane_point_velocity(&s->a, s->a.arm)));
}

// The contacts of LANES pairs of one sort; boxes whose faces do not meet are sorted again.
static inline void tile_group(const StepParams* params, Tile* tile, u32 sort, u32 first, const SideTables* tables,
                              global const BodyInfo* body_infos, global FoundContacts* found_contacts,
                              global u32* contact_starts) {
  LanePairs group;
  LaneSides sides;
  LaneManifold m;
  const u32 members = tile_lanes(&group, tile, &tile->lists[sort], first);
  lane_sides(&sides, tables, &group);
  if (sort == TILE_FACES) {
    const LaneBox a = box_of_side(&sides.a), b = box_of_side(&sides.b);
    const BoxPair pair = box_pair(&a, &b);
    real codes[LANES], separations[LANES];
    for (u32 k = 0u; k < LANES; ++k) {
      codes[k] = tile->codes[group.pair[k] - tile->first];
      separations[k] = tile->separations[group.pair[k] - tile->first];
    }
    m = box_faces(&a, &b, &pair, LANE_LOAD(codes), lane_limit(params, &sides));
    const u32 none = ~LANE_BITS(faces_meet(&m, &a, &b, LANE_LOAD(separations)));
    for (u32 k = 0u; k < members; ++k)
      tile_append(&tile->lists[TILE_CORNERS], group.pair[k] - tile->first, none >> k & 1u);
  } else if (sort == TILE_CORNERS) {
    const LaneBox a = box_of_side(&sides.a), b = box_of_side(&sides.b);
    const BoxPair pair = box_pair(&a, &b);
    m = box_corners(&a, &b, &pair, box_axis(&a, &b, &pair), tile_displacement(params, &sides),
                    lane_limit(params, &sides));
  } else if (sort == TILE_BOX_PLANE) {
    lane_box_plane(&sides.a, &sides.b, &m);
  } else {
    const bool swapped = sort == TILE_BOX_SPHERE;
    lane_sphere_box(swapped ? &sides.b : &sides.a, swapped ? &sides.a : &sides.b, &m);
    if (swapped) lane_flip(&m, 1u);
  }
  const u32 points = sort == TILE_FACES || sort == TILE_CORNERS || sort == TILE_BOX_PLANE ? 4u : 1u;
  lane_keep(params, &sides, &m, points);
  lane_store_found(&sides, &m, points, &group, members, body_infos, found_contacts, contact_starts);
}

static inline void tile_collide(const StepParams* params, Tile* tile, const SideTables* tables,
                                global const BodyInfo* body_infos, global FoundContacts* found_contacts,
                                global u32* contact_starts) {
  tile_box_axes(params, tile, tables, contact_starts);
  for (u32 sort = 0u; sort < TILE_LANE_SORTS; ++sort) {
    for (u32 first = 0u; first < tile->lists[sort].count; first += LANES)
      tile_group(params, tile, sort, first, tables, body_infos, found_contacts, contact_starts);
  }
}

#endif
