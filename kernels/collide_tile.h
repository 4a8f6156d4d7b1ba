// The pairs of a tile that go through lanes: neighbours in the list of pairs, sorted by what is to be done with them,
// so that no lane waits for another case and what they read stays in the cache. The same as collide_pair does, bit for
// bit.
#ifndef LOCKSTEP_COLLIDE_TILE_H
#define LOCKSTEP_COLLIDE_TILE_H

#include "shapes/box_box.h"

// At most so many pairs (host/device/launches/collision.cpp).
#define TILE_PAIRS 128u

// Pairs of one sort. What is appended is always written, and counted where it belongs.
typedef struct TileList {
  u32 count;
  u32 at[TILE_PAIRS + 1u];  // places in the tile
} TileList;

LANE_INLINE void tile_append(TileList* list, u32 place, u32 belongs) {
  list->at[list->count] = place;
  list->count += belongs;
}

typedef struct Tile {
  u32 first;  // pair
  u32 shape_a[TILE_PAIRS], shape_b[TILE_PAIRS], body_a[TILE_PAIRS], body_b[TILE_PAIRS];
  TileList boxes, others;
} Tile;

// Pairs of boxes that no case of its own applies to go through lanes.
static inline void tile_sort(Tile* tile, u32 first, u32 end, global const Pair* pairs,
                             global const ShapeInfo* shape_infos) {
  tile->first = first;
  tile->boxes.count = 0u;
  tile->others.count = 0u;
  for (u32 i = 0u; i < end - first; ++i) {
    const Pair pair = pairs[first + i];
    global const ShapeInfo *a = shape_infos + pair.shape_a, *b = shape_infos + pair.shape_b;
    tile->shape_a[i] = pair.shape_a;
    tile->shape_b[i] = pair.shape_b;
    tile->body_a[i] = a->body;
    tile->body_b[i] = b->body;
    const u32 special = (a->flags | b->flags) & (SHAPE_IS_SENSOR | SHAPE_IS_CONTINUOUS);
    const u32 boxes = a->kind == SHAPE_BOX && b->kind == SHAPE_BOX && special == 0u ? 1u : 0u;
    tile_append(&tile->boxes, i, boxes);
    tile_append(&tile->others, i, 1u - boxes);
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

// First the separating axis of each pair of boxes, then those that meet on a face and those that meet on edges.
static inline void tile_boxes(StepParams params, const Tile* tile, const SideTables* tables,
                              global const BodyInfo* body_infos, global FoundContacts* found_contacts,
                              global u32* contact_starts) {
  TileList faces, edges;
  faces.count = 0u;
  edges.count = 0u;
  real codes[TILE_PAIRS];
  LanePairs group;
  LaneSides sides;
  for (u32 first = 0u; first < tile->boxes.count; first += LANES) {
    const u32 members = tile_lanes(&group, tile, &tile->boxes, first);
    lane_sides(&sides, tables, &group);
    const LaneBox a = box_of_side(&sides.a), b = box_of_side(&sides.b);
    const BoxPair pair = box_pair(&a, &b);
    lane code;
    const lane separation = box_axis(&a, &b, &pair, &code);
    real found[LANES];
    LANE_STORE(code, found);
    const u32 near = ~LANE_BITS(separation > lane_limit(params, &sides));
    const u32 on_edge = LANE_BITS(code >= LANE_OF(6));
    for (u32 k = 0u; k < members; ++k) {
      const u32 i = group.pair[k] - tile->first;
      contact_starts[group.pair[k]] = 0u;
      codes[i] = found[k];
      tile_append(&faces, i, (near & ~on_edge) >> k & 1u);
      tile_append(&edges, i, (near & on_edge) >> k & 1u);
    }
  }
  const u32 face_groups = (faces.count + LANES - 1u) / LANES, edge_groups = (edges.count + LANES - 1u) / LANES;
  for (u32 g = 0u; g < face_groups + edge_groups; ++g) {
    const bool on_face = g < face_groups;
    const TileList* list = on_face ? &faces : &edges;
    const u32 members = tile_lanes(&group, tile, list, (on_face ? g : g - face_groups) * LANES);
    real found[LANES];
    for (u32 k = 0u; k < LANES; ++k) found[k] = codes[group.pair[k] - tile->first];
    lane_sides(&sides, tables, &group);
    const LaneBox a = box_of_side(&sides.a), b = box_of_side(&sides.b);
    const BoxPair pair = box_pair(&a, &b);
    LaneManifold m;
    if (on_face)
      m = box_faces(&a, &b, &pair, LANE_LOAD(found), lane_limit(params, &sides));
    else
      m = box_edges(&a, &b, &pair, LANE_LOAD(found));
    const u32 points = on_face ? 4u : 1u;
    lane_keep(params, &sides, &m, points);
    lane_store_found(&sides, &m, points, &group, members, body_infos, found_contacts, contact_starts);
  }
}

#endif
