#include "host/device/launcher.hpp"

namespace lockstep {

namespace {

// Shapes that one work-item bounds: few enough items not to fight over the largest extent.
constexpr u32 bounds_per_item = 16;

// Of kernels/find_pairs.cl: FOUND, and the words of GridSphere (double precision), GridInfo and GridPlane (double).
constexpr u32 found_per_shape = 16, grid_sphere_words = 14, grid_info_words = 16, grid_plane_words = 16;

// Of a Manifold of kernels/shapes/manifold.h with so many points, in units of a real.
constexpr u32 manifold_words(u32 points) { return 7 + 7 * points; }

// Of a BoxLine of kernels/collide_boxes.cl, in the same unit.
constexpr u32 box_line_words = 24;

// Pairs of boxes in lanes cost a tenth of what they cost one by one, and a GPU's work-items all take the same way; a
// small scene has them with the other pairs, in one launch.
void collide_boxes(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  launcher.scratch("box_lines", std::size_t{plan.sizes.shapes} * box_line_words * plan.real_words);
  launcher.scratch("box_counts", 2);
  for (const char* list : {"box_codes", "box_faces_list", "box_edges_list"}) launcher.scratch(list, plan.sizes.pairs);
  launcher.run("collide_box_lines", plan.sizes.shapes);
  launcher.run("collide_box_axes", plan.pairs / plan.lanes + 1);
  launcher.run("collide_box_faces", plan.box_pairs / plan.lanes + 1);
  launcher.run("collide_box_edges", plan.box_pairs / plan.lanes + 1);
}

}  // namespace

void launch_update_bounds(Launcher& launcher) {
  launcher.run("update_bounds", (launcher.plan().sizes.shapes + bounds_per_item - 1) / bounds_per_item);
}

void launch_sort_cells(Launcher& launcher) {
  const Sizes& sizes = launcher.plan().sizes;
  launcher.scratch("cell_arrivals", sizes.shapes);
  launcher.run("sort_cells_clear", sizes.buckets + 1);
  launcher.run("sort_cells_count", sizes.shapes);
  launcher.scan("bucket_starts", sizes.buckets + 1);
  launcher.run("sort_cells_fill", sizes.shapes);
  launcher.run("sort_cells_order", sizes.buckets);
}

void launch_find_pairs(Launcher& launcher) {
  const Sizes& sizes = launcher.plan().sizes;
  launcher.scratch("found_partners", std::size_t{sizes.shapes} * found_per_shape);
  launcher.scratch("grid_spheres", (std::size_t{sizes.shapes} + PACK) * grid_sphere_words);
  launcher.scratch("grid_infos", std::size_t{sizes.shapes} * grid_info_words);
  launcher.scratch("grid_planes", std::size_t{sizes.planes} * grid_plane_words);
  launcher.run("find_pairs_gather", sizes.shapes);
  launcher.run("find_pairs_search", sizes.shapes);
  launcher.scan("pair_starts", sizes.shapes + 1);
  launcher.run("find_pairs_write", sizes.shapes);
}

void launch_collide(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  const u32 points = has(plan.features, Feature::manifolds) ? 4 : 1;
  launcher.scratch("manifolds", std::size_t{plan.sizes.pairs} * manifold_words(points) * plan.real_words);
  const bool boxes_apart = !plan.small && plan.box_pairs > 0;
  launcher.run("collide_pairs", plan.pairs + 1, {{"boxes_apart", boxes_apart ? 1u : 0u}});
  if (boxes_apart) collide_boxes(launcher);
  launcher.scan("contact_starts", plan.sizes.pairs + 1, COUNTER_PAIRS, plan.pairs + 1);
  launcher.run("collide_write", plan.pairs);
}

void launch_match_contacts(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  launcher.scratch("cached_starts", std::size_t{plan.sizes.shapes} + 1);
  launcher.run("match_contacts_index", plan.contacts + 1);
  launcher.run("match_contacts", plan.contacts);
}

}  // namespace lockstep
