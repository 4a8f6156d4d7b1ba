// The middle phase: the shapes that bodies keep trees of. cpu_reference/shape_trees.hpp is the twin and says more.
#ifndef LOCKSTEP_SHAPE_TREES_H
#define LOCKSTEP_SHAPE_TREES_H

#include "pair_search.h"
#include "tree.h"

// The box that meets those of all partners: swept_box of the shape.
static inline TreeBox searcher_box(const Searcher* me) {
  Vec3 box = make3(me->extent, me->extent, me->extent);
#if FEATURE_MANIFOLDS
  if (me->info.shape.kind != SHAPE_SPHERE) {
    box = make3(me->box.x + me->h * (fabs(me->velocity.x) + me->rotational_speed),
                me->box.y + me->h * (fabs(me->velocity.y) + me->rotational_speed),
                me->box.z + me->h * (fabs(me->velocity.z) + me->rotational_speed));
  }
#endif
  const Vec3 half_extents =
      make3(padded_extent(me->center.x, box.x), padded_extent(me->center.y, box.y), padded_extent(me->center.z, box.z));
  TreeBox swept;
  swept.low = sub3(me->center, half_extents);
  swept.high = add3(me->center, half_extents);
  return swept;
}

#if FEATURE_SHAPE_TREES

// A shape of a tree as one that looks for others.
static inline Searcher searcher_in_tree(const PairSearch* s, const StepParams* params, u32 i) {
  const u32 body = s->shape_infos[i].body;
  global const Motion* motion = s->motions + body;
  Bound bound;
  Searcher me;
  me.info.shape = s->shape_infos[i];
  me.info.body = s->body_infos[body];
  me.info.index = i;
  me.info.cell_y = me.info.cell_z = 0;
#if FEATURE_SLEEPING
  me.info.looks = is_moving(body, params->bodies, s->body_infos, s->motions, s->sleepers) ? 1u : 0u;
#else
  me.info.looks = 1u;
#endif
  me.slot = NONE;
  me.margin = shape_margin(params, (real)0, (real)0);
  me.h = step_length(params);
  shape_bound(me.info.shape.kind, s->shapes + i, s->positions + body, s->orientations + body, motion, params, &bound);
  me.center = make3(bound.center[0], bound.center[1], bound.center[2]);
  me.extent = bound.extent;
  me.bounding_radius = bound.extent > (real)0 ? bound.bounding_radius : (real)-1e37;
  me.velocity = point_velocity(motion, sub3(me.center, search_position(s->positions, body)));
#if FEATURE_MANIFOLDS
  const bool round = me.info.shape.kind == SHAPE_SPHERE;
  me.box = make3(bound.box[0], bound.box[1], bound.box[2]);
  me.rotational_speed =
      round ? (real)0 : length3(make3(motion->w[0], motion->w[1], motion->w[2])) * bound.bounding_radius;
  me.round = round ? (real)1 : (real)0;
#endif
  return me;
}

// As shapes_in_range of pair_search.h.
static inline bool searchers_in_range(const Searcher* me, const Searcher* other) {
  const Vec3 d = sub3(me->center, other->center), u = sub3(me->velocity, other->velocity);
  const real gap = length3(d) - (me->bounding_radius + other->bounding_radius);
  if (!(gap <= me->h * length3(u))) return false;
#if FEATURE_MANIFOLDS
  const real rotational_speed = me->rotational_speed + other->rotational_speed;
  return me->round * other->round > (real)0 ||
         (fabs(d.x) <= me->box.x + other->box.x + me->h * (fabs(u.x) + rotational_speed) &&
          fabs(d.y) <= me->box.y + other->box.y + me->h * (fabs(u.y) + rotational_speed) &&
          fabs(d.z) <= me->box.z + other->box.z + me->h * (fabs(u.z) + rotational_speed));
#else
  return true;
#endif
}

static inline TreeBox box_in_tree(const PairSearch* s, ShapeTree tree, const Searcher* me) {
  const Vec3 at = search_position(s->positions, tree.body);
  const Quat orientation = make_pose(s->positions[tree.body], s->orientations[tree.body]).orientation;
  global const Motion* motion = s->motions + tree.body;
  const real speed = length3(make3(motion->v[0], motion->v[1], motion->v[2])) +
                     length3(make3(motion->w[0], motion->w[1], motion->w[2])) * tree.radius;
  const real rounding = sizeof(real) == 4 ? (real)2e-6 : (real)4e-15;
  const real position_error = (fabs(at.x) + fabs(at.y) + fabs(at.z) + tree.radius) * rounding;
  const real wider = (me->margin + me->h * speed) * (real)1.0001 + position_error;
  TreeBox box;
  if (orientation.x == (real)0 && orientation.y == (real)0 && orientation.z == (real)0) {
    box = widened(searcher_box(me), wider);
    box.low = sub3(box.low, at);
    box.high = sub3(box.high, at);
    return box;
  }
  const Vec3 d = sub3(me->center, at);
  const real rotation_rounding = (fabs(d.x) + fabs(d.y) + fabs(d.z)) * rounding;
  box.low = box.high = unrotate3(orientation, d);
  return widened(box, (me->extent + tree.largest) * (real)1.0001 + wider + rotation_rounding);
}

static inline void search_shape_tree(const PairSearch* s, const StepParams* params, ShapeTree tree, const Searcher* me,
                                     Finds* finds) {
  const TreeBox box = box_in_tree(s, tree, me);
  const TreeShape shape = tree_shape(tree.item_count);
  global const BoxBlock* blocks = s->shape_tree_blocks + tree.first_block;
  bool arrives = false;
  TreeWalk walk = tree_begin(&shape, boxes_in_range(blocks + shape.first[shape.levels - 1u], box));
  for (u32 entry; (entry = tree_next(&walk, &shape, &arrives)) != NONE;) {
    if (arrives) {
      walk.rest[walk.level] = boxes_in_range(blocks + shape.first[walk.level] + entry, box);
      continue;
    }
    const u32 j = s->shape_tree_items[tree.first_item + entry], i = me->info.index;
    if (finds->list != 0 && j < i) continue;
    if (!is_pair(s, me->info.shape, s->shape_infos[j], me->info.body, s->body_infos[tree.body])) continue;
    const Searcher other = searcher_in_tree(s, params, j);
    if (searchers_in_range(me, &other)) add_pair(finds, j < i ? j : i, j < i ? i : j);
  }
}

#endif

// The partners of a shape of a body that is pushed among those in trees.
static inline void search_shape_trees(const PairSearch* s, const StepParams* params, const Searcher* me, Finds* finds) {
#if FEATURE_SHAPE_TREES
  if (me->info.body.kind != BODY_DYNAMIC) return;
  const WorldTrees world = s->world_trees[me->info.body.world];
  for (u32 t = world.first_tree; t < world.first_tree + world.tree_count; ++t) {
    const ShapeTree tree = s->shape_trees[t];
#if FEATURE_SLEEPING
    if (me->info.looks == 0u && !is_moving(tree.body, params->bodies, s->body_infos, s->motions, s->sleepers)) continue;
#endif
    search_shape_tree(s, params, tree, me, finds);
  }
#endif
}

// What a search finds beside top-level shapes.
static inline void search_planes_and_trees(const PairSearch* s, const StepParams* params, const Searcher* me,
                                           Finds* finds) {
  search_planes(s, me, finds);
  search_shape_trees(s, params, me, finds);
}

// The one that shape i of a list that is too long searches as.
static inline Searcher owner_of_list(const PairSearch* s, const StepParams* params, global const u32* shape_slots,
                                     u32 i) {
#if FEATURE_SHAPE_TREES
  if ((s->shape_infos[i].flags & SHAPE_IS_IN_TREE) != 0u) return searcher_in_tree(s, params, i);
#endif
  return make_searcher(s, params, shape_slots[i]);
}

#endif
