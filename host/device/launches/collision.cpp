#include <algorithm>

#include "host/device/launcher.hpp"

namespace lockstep {

namespace {

// Of a FoundContacts of kernels/found_contacts.h with so many points, in u32 words.
constexpr u32 found_words(u32 points, u32 real_words) { return (8 * points + 4) * real_words + 12; }

// Pairs that a work-item takes together: neighbours, so that a CPU device finds enough of one sort to fill its lanes
// (at most TILE_PAIRS of kernels/collide_tile.h), but so few that there is work for all threads.
u32 tile_pairs(const LaunchPlan& plan) {
  constexpr u32 shares = 256, largest_tile = 128;
  return plan.lanes == 1 ? 1 : std::clamp(plan.pairs / shares, plan.lanes, largest_tile);
}

}  // namespace

void launch_collide(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  const u32 points = has(plan.features, Feature::manifolds) ? 4 : 1, tile = tile_pairs(plan);
  launcher.scratch("found_contacts", std::size_t{plan.sizes.pairs} * found_words(points, plan.real_words));
  launcher.run("collide_pairs", plan.pairs / tile + 1, {{"tile_pairs", tile}});
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
