#include "host/device/launcher.hpp"

namespace lockstep {

namespace {

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
