// The middle phase: bodies that nothing pushes and that have many shapes (surfaces, buildings) keep a tree of boxes of
// them in their own frame (Ericson, Real-Time Collision Detection, 2005, chapter 6). It is made once; a shape of
// another body looks into it where the body is by now. What is found is what the broad phase would find if it looked at
// all shapes one by one (cpu_reference/pair_test.hpp). kernels/shape_trees.h is the twin.
#pragma once

#include "cpu_reference/shape_bound.hpp"
#include "cpu_reference/tree.hpp"

namespace lockstep::reference {

template <class real>
bool is_rotated(Quat<real> q) {
  return q.x != 0 || q.y != 0 || q.z != 0;
}

/// A box in the frame of the tree's body that meets those of all partners of `me`: what me and the body move in the
/// step, and rounding, widen it. Where the body is not turned boxes of shapes are along the axes of the world, as the
/// pair test asks; else only their bounding spheres are known to be.
template <class real>
TreeBox<real> box_in_tree(const Buffers<real>& b, const StepParams<real>& params, const ShapeTree<real>& tree,
                          const Bounded<real>& me) {
  const Pose<real> pose = make_pose(b.positions[tree.body], b.orientations[tree.body]);
  const Motion<real>& motion = b.motions[tree.body];
  const real h = step_length(params), rounding = sizeof(real) == 4 ? real(2e-6) : real(4e-15);
  const real displacement = h * (length3(vec3(motion.v)) + length3(vec3(motion.w)) * tree.radius);
  const Vec3<real> at = pose.position;
  const real position_error = (std::abs(at.x) + std::abs(at.y) + std::abs(at.z) + tree.radius) * rounding;
  const real margin = shape_margin(params, real(0), real(0));
  const real wider = (margin + displacement) * real(1.0001) + position_error;
  if (!is_rotated(pose.orientation)) {
    const TreeBox<real> box = widened(swept_box(b, me, h), wider);
    return {sub3(box.low, at), sub3(box.high, at)};
  }
  const Vec3<real> d = sub3(me.center(), at), center = unrotate3(pose.orientation, d);
  const real rotation_rounding = (std::abs(d.x) + std::abs(d.y) + std::abs(d.z)) * rounding;
  const real half_extent = (me.bound.extent + tree.largest) * real(1.0001) + wider + rotation_rounding;
  return widened(TreeBox<real>{center, center}, half_extent);
}

/// Calls found(j) for each shape j of a tree of its world that `me`, of a body that is pushed, is paired with.
template <class real, class Found>
void search_shape_trees(const Buffers<real>& b, const StepParams<real>& params, const Bounded<real>& me,
                        Found&& found) {
  const BodyInfo& body = b.body_infos[b.shape_infos[me.shape].body];
  if (b.world_trees.empty() || body.kind != BODY_DYNAMIC) return;
  const WorldTrees& world = b.world_trees[body.world];
  for (u32 t = world.first_tree; t < world.first_tree + world.tree_count; ++t) {
    const ShapeTree<real>& tree = b.shape_trees[t];
    traverse_boxes(b.shape_tree_blocks.data() + tree.first_block, tree.item_count, box_in_tree(b, params, tree, me),
                   [&](u32 entry) {
                     Bounded<real> other = {b.shape_tree_items[tree.first_item + entry], {}};
                     shape_bound(b, params, other.shape, other.bound);
                     if (are_pair(b, params, me, other)) found(other.shape);
                   });
  }
}

}  // namespace lockstep::reference
