// Launches of the stages that say who sleeps.
#include <algorithm>
#include <string_view>

#include "host/device/launcher.hpp"

namespace lockstep {

namespace {

// Bodies that a work-item counts: few enough items not to fight over the counters.
constexpr u32 bodies_per_item = 16;

// Of what the last work-group merges; no device has larger ones.
constexpr u32 largest_group = 8192;

u32 linked_pairs(const LaunchPlan& plan) { return std::max(plan.contacts, plan.sizes.joint_blocks * PACK); }

u32 counting_items(const LaunchPlan& plan) { return (plan.sizes.bodies + bodies_per_item - 1) / bodies_per_item; }

}  // namespace

void launch_wake_islands(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  launcher.scratch("touched_islands", plan.sizes.bodies);
  launcher.run("wake_clear", plan.sizes.bodies);
  launcher.run("wake_mark", linked_pairs(plan));
  launcher.run("wake_apply", plan.sizes.bodies);
}

void launch_fall_asleep(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  launcher.scratch("island_parents", plan.sizes.bodies);
  launcher.scratch("disturbed_bodies", plan.sizes.bodies);
  launcher.run("sleep_count", counting_items(plan));
  launcher.run("sleep_join", linked_pairs(plan));
  launcher.run("sleep_roots", plan.sizes.bodies);
  launcher.run("sleep_apply", counting_items(plan));
  if (!has(plan.features, Feature::contacts)) return;
  launcher.scratch("kept_contacts", std::size_t{plan.sizes.contacts} + 1);
  launcher.scratch("kept_keys", std::size_t{plan.sizes.contacts} + 1);
  launcher.scratch("keep_sums", std::size_t{2} * largest_group);
  launcher.scratch("merged_keys", std::size_t{plan.sizes.contacts} * 4);
  launcher.scratch("merged_impulses", std::size_t{plan.sizes.contacts} * 4 * plan.real_words);
  launcher.scratch("merged_points", std::size_t{plan.sizes.contacts} * 12 * plan.real_words);
  const bool has_moments = has(plan.features, Feature::angular_friction);
  if (has_moments) launcher.scratch("merged_moments", std::size_t{plan.sizes.contacts} * 4 * plan.real_words);
  launcher.run_group("sleep_keep",
                     {{"merged_moments", std::string_view(has_moments ? "merged_moments" : "merged_impulses")}});
}

}  // namespace lockstep
