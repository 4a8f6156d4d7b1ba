#pragma OPENCL FP_CONTRACT OFF
// The first solid shape that each ray meets (cpu_reference/cast_rays.hpp).
#include "common.h"
#include "shapes/rays.h"
#include "top_level_shapes.h"
#include "tree.h"
#include "types.h"

// Whether the ray passes within `range` of the point that is at `offset` from its origin; not what is behind it.
static inline bool ray_passes(Vec3 offset, Vec3 direction, real range) {
  const real along = dot3(offset, direction);
  const Vec3 aside = sub3(offset, scale3(along > (real)0 ? along : (real)0, direction));
  return dot3(aside, aside) <= range * range * (real)1.0001;
}

// What rays are cast at.
typedef struct RayScene {
  global const ShapeInfo* shape_infos;
  global const Shape* shapes;
  global const Vec4* positions;
  global const Vec4* orientations;
  HullTables tables;
} RayScene;

typedef struct RayHit {
  u32 shape;
  real distance;
  Vec3 normal;
} RayHit;

// Looks whether the ray meets shape i before what it has met so far.
static inline void meet_shape(const RayScene* s, Ray ray, QueryFilter filter, u32 i, RayHit* closest) {
  const ShapeInfo info = s->shape_infos[i];
  if ((info.category & filter.mask) == 0u || (info.flags & SHAPE_IS_TRIGGER) != 0u) return;
  global const Shape* shape = s->shapes + i;
  const Vec3 origin = make3(ray.origin[0], ray.origin[1], ray.origin[2]);
  const Vec3 direction = make3(ray.direction[0], ray.direction[1], ray.direction[2]);
  const Pose pose = make_pose(s->positions[info.body], s->orientations[info.body]);
  const Vec3 offset = sub3(shape_center(pose, shape), origin);
  if (info.kind != SHAPE_PLANE && !ray_passes(offset, direction, shape->bounding_radius)) return;
  const Quat rotation = shape_rotation(pose, shape);
  const Vec3 size = make3(shape->size[0], shape->size[1], shape->size[2]);
  const RayEntry entry = ray_shape(info.kind, unrotate3(rotation, scale3((real)-1, offset)),
                                   unrotate3(rotation, direction), size, info.hull, &s->tables);
  const bool first = closest->shape == NONE || entry.distance < closest->distance ||
                     (entry.distance == closest->distance && i < closest->shape);
  if (!(entry.distance >= (real)0 && entry.distance <= ray.range) || !first) return;
  closest->shape = i;
  closest->distance = entry.distance;
  closest->normal = rotate3(rotation, entry.normal);
}

#if FEATURE_SHAPE_TREES
// By how much boxes of a tree are wider on the way of a ray from `d` before the tree's body at `at`.
static inline real ray_rounding(Vec3 at, Vec3 d, real radius) {
  const real rounding = sizeof(real) == 4 ? (real)2e-6 : (real)4e-15;
  return (fabs(at.x) + fabs(at.y) + fabs(at.z) + fabs(d.x) + fabs(d.y) + fabs(d.z) + radius) * rounding;
}

// A ray in the frame of a tree's body: where boxes are `wider` by rounding.
typedef struct RayInTree {
  Vec3 origin, inverse;
  real range, wider;
} RayInTree;

// Bit k is set where the ray may meet box k of a block. One that runs along the side of a box, which is wider than what
// it holds, may miss it: zero times infinity is no number, and counts for nothing.
static inline u32 boxes_on_ray(global const BoxBlock* block, const RayInTree* ray) {
  u32 hits = 0u;
  for (u32 k = 0u; k < PACK; k += LANES) {
    const lane low_x = (LANE_LOAD(block->low_x + k) - (ray->origin.x + ray->wider)) * ray->inverse.x;
    const lane low_y = (LANE_LOAD(block->low_y + k) - (ray->origin.y + ray->wider)) * ray->inverse.y;
    const lane low_z = (LANE_LOAD(block->low_z + k) - (ray->origin.z + ray->wider)) * ray->inverse.z;
    const lane high_x = (LANE_LOAD(block->high_x + k) - (ray->origin.x - ray->wider)) * ray->inverse.x;
    const lane high_y = (LANE_LOAD(block->high_y + k) - (ray->origin.y - ray->wider)) * ray->inverse.y;
    const lane high_z = (LANE_LOAD(block->high_z + k) - (ray->origin.z - ray->wider)) * ray->inverse.z;
    const lane enters =
        lane_larger(lane_larger(lane_less(low_x, high_x), lane_less(low_y, high_y)), lane_less(low_z, high_z));
    const lane leaves =
        lane_less(lane_less(lane_larger(low_x, high_x), lane_larger(low_y, high_y)), lane_larger(low_z, high_z));
    const lane_mask there = LANE_LOAD(block->low_x + k) <= LANE_LOAD(block->high_x + k);  // else the box is missing
    hits |= LANE_BITS(there & (enters <= leaves) & (leaves >= (lane)0) & (enters <= ray->range)) << k;
  }
  return hits;
}

static inline void meet_tree(const RayScene* s, Ray ray, QueryFilter filter, ShapeTree tree,
                             global const u32* shape_tree_items, global const BoxBlock* shape_tree_blocks,
                             RayHit* closest) {
  const Pose pose = make_pose(s->positions[tree.body], s->orientations[tree.body]);
  const Vec3 direction = unrotate3(pose.orientation, make3(ray.direction[0], ray.direction[1], ray.direction[2]));
  const Vec3 d = sub3(make3(ray.origin[0], ray.origin[1], ray.origin[2]), pose.position);
  RayInTree mine;
  mine.origin = unrotate3(pose.orientation, d);
  mine.inverse = make3((real)1 / direction.x, (real)1 / direction.y, (real)1 / direction.z);
  mine.range = ray.range * (real)1.0001;
  mine.wider = ray_rounding(pose.position, d, tree.radius);
  const TreeShape shape = tree_shape(tree.item_count);
  global const BoxBlock* blocks = shape_tree_blocks + tree.first_block;
  bool arrives = false;
  TreeWalk walk = tree_begin(&shape, boxes_on_ray(blocks + shape.first[shape.levels - 1u], &mine));
  for (u32 entry; (entry = tree_next(&walk, &shape, &arrives)) != NONE;) {
    if (closest->shape != NONE) mine.range = closest->distance * (real)1.0001;
    if (arrives)
      walk.rest[walk.level] = boxes_on_ray(blocks + shape.first[walk.level] + entry, &mine);
    else
      meet_shape(s, ray, filter, shape_tree_items[tree.first_item + entry], closest);
  }
}
#endif

// `room`: rays that the buffers hold.
kernel void cast_rays(global const WorldRange* world_ranges, global const ShapeInfo* shape_infos,
                      global const Shape* shapes, global const u32* top_level_shapes,
                      global const WorldTrees* world_trees, global const ShapeTree* shape_trees,
                      global const u32* shape_tree_items, global const BoxBlock* shape_tree_blocks,
                      global const Vec4* positions, global const Vec4* orientations, global const Hull* hulls,
                      global const Vec4* hull_vertices, global const Vec4* hull_planes,
                      global const HullFace* hull_faces, global const HullEdge* hull_edges,
                      global const u32* hull_corners, global const Facet* facets, global const FacetEdge* facet_edges,
                      global const Ray* rays, global const QueryFilter* ray_filters, global u32* ray_shapes,
                      global RayPoint* ray_points, const u32 room, const StepParams params) {
  const RayScene s = {shape_infos,
                      shapes,
                      positions,
                      orientations,
                      {hulls, hull_vertices, hull_planes, hull_faces, hull_edges, hull_corners, facets, facet_edges}};
  FOR_EACH(r, room) {
    RayHit closest = {NONE, (real)0, {(real)0, (real)0, (real)0}};
    if (r < params.queries) {
      const Ray ray = rays[r];
      const QueryFilter filter = ray_filters[r];
      const TopLevelRange top_level = top_level_range(filter.world, world_ranges, world_trees);
      for (u32 k = top_level.first; k < top_level.first + top_level.count; ++k)
        meet_shape(&s, ray, filter, TOP_LEVEL_SHAPE(k), &closest);
#if FEATURE_SHAPE_TREES
      const WorldTrees world = world_trees[filter.world];
      for (u32 t = world.first_tree; t < world.first_tree + world.tree_count; ++t)
        meet_tree(&s, ray, filter, shape_trees[t], shape_tree_items, shape_tree_blocks, &closest);
#endif
    }
    ray_shapes[r] = closest.shape;
    ray_points[r].normal[0] = closest.normal.x;
    ray_points[r].normal[1] = closest.normal.y;
    ray_points[r].normal[2] = closest.normal.z;
    ray_points[r].distance = closest.distance;
  }
}
