// The broad phase: bounds, and candidate pairs from a grid, from a tree of boxes or from comparing all shapes.
#include <bit>
#include <utility>

#include "host/device/launcher.hpp"

namespace lockstep {

namespace {

// Shapes that one work-item bounds: few enough items not to fight over the largest extent, and enough to be at work.
constexpr u32 bounds_per_cpu_item = 16, bounds_per_gpu_item = 4;

// Of kernels/pair_search.h: FOUND, reals of SearchComponent without and with boxes, words of SearchInfo and of
// PlaneInfo (double).
constexpr u32 found_per_shape = 16, sphere_reals = 8, shape_reals = 13, search_info_words = 16, plane_info_words = 16;

// Of kernels/sort_shapes.cl: bits of the two words of a key.
constexpr u32 low_key_bits = 24, high_key_bits = 27;

u32 blocks_of(u32 count) { return (count + PACK - 1) / PACK; }

void make_search_arrays(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  const u32 reals = has(plan.features, Feature::manifolds) ? shape_reals : sphere_reals;
  launcher.scratch("found_partners", std::size_t{plan.sizes.shapes} * found_per_shape);
  launcher.scratch("search_bounds", (std::size_t{plan.sizes.top_level()} + PACK) * reals * plan.real_words);
  launcher.scratch("search_infos", std::size_t{plan.sizes.top_level()} * search_info_words);
  launcher.scratch("shape_slots", plan.sizes.shapes);
  launcher.scratch("plane_infos", std::size_t{plan.sizes.planes} * plane_info_words);
}

}  // namespace

void launch_update_bounds(Launcher& launcher) {
  const u32 per_item = launcher.plan().lanes > 1 ? bounds_per_cpu_item : bounds_per_gpu_item;
  launcher.run("update_bounds", (launcher.plan().sizes.top_level() + per_item - 1) / per_item);
}

void launch_move_seams(Launcher& launcher) {
  const u32 seams = launcher.plan().sizes.seams;
  launcher.run("move_seams", seams, {{"seam_count", seams}});
}

void launch_sort_cells(Launcher& launcher) {
  const Sizes& sizes = launcher.plan().sizes;
  launcher.scratch("cell_arrivals", sizes.top_level());
  launcher.run("sort_cells_clear", sizes.buckets + 1);
  launcher.run("sort_cells_count", sizes.top_level());
  launcher.scan("bucket_starts", sizes.buckets + 1);
  launcher.run("sort_cells_fill", sizes.top_level());
  launcher.run("sort_cells_order", sizes.buckets);
}

void launch_find_pairs(Launcher& launcher) {
  const Sizes& sizes = launcher.plan().sizes;
  make_search_arrays(launcher);
  launcher.run("find_pairs_gather", sizes.top_level());
  launcher.run("find_pairs_search", sizes.top_level());
  launcher.scan("pair_starts", sizes.shapes + 1);
  launcher.run("find_pairs_write", sizes.shapes);
}

void launch_compare_shapes(Launcher& launcher) {
  make_search_arrays(launcher);
  launcher.run_group("compare_shapes");
}

void launch_sort_shapes(Launcher& launcher) {
  const Sizes& sizes = launcher.plan().sizes;
  for (const char* name : {"low_keys", "high_keys", "spare_keys", "spare_items"})
    launcher.scratch(name, sizes.top_level());
  launcher.run("sort_shapes_clear", sizes.worlds);
  launcher.run("sort_shapes_bound", (sizes.top_level() + CHUNK - 1) / CHUNK);
  // the last pass of all ends in tree_items
  const u32 world_bits = static_cast<u32>(std::bit_width(sizes.worlds - 1));
  const u32 passes =
      launcher.sort_passes(low_key_bits) + launcher.sort_passes(high_key_bits) + launcher.sort_passes(world_bits);
  SortArrays arrays = {"low_keys", "tree_items", "spare_keys", "spare_items"};
  if (sizes.top_level() > 1 && passes % 2 == 1) std::swap(arrays.values, arrays.spare_values);
  launcher.run("sort_shapes_keys", sizes.top_level(), {{"values", arrays.values}});
  arrays = launcher.sort(arrays, sizes.top_level(), low_key_bits);
  launcher.run("sort_shapes_next", sizes.top_level(), {{"values", arrays.values}, {"keys", arrays.keys}});
  arrays = launcher.sort(arrays, sizes.top_level(), high_key_bits);
  if (world_bits == 0) return;
  launcher.run("sort_shapes_worlds", sizes.top_level(), {{"values", arrays.values}, {"keys", arrays.keys}});
  launcher.sort(arrays, sizes.top_level(), world_bits);
}

void launch_build_tree(Launcher& launcher) {
  u32 below = 0, entries = blocks_of(launcher.plan().sizes.top_level());
  launcher.run("build_tree_runs", entries);
  while (entries > PACK) {
    launcher.run("build_tree_level", blocks_of(entries), {{"below", below}, {"entries", blocks_of(entries)}});
    below += blocks_of(entries);
    entries = blocks_of(entries);
  }
}

void launch_search_tree(Launcher& launcher) {
  const Sizes& sizes = launcher.plan().sizes;
  make_search_arrays(launcher);
  launcher.run("search_tree_gather", sizes.shapes);
  launcher.run("search_tree_search", sizes.top_level());
  launcher.scan("pair_starts", sizes.shapes + 1);
  launcher.run("search_tree_write", sizes.shapes);
}

}  // namespace lockstep
