#include "host/device/launcher.hpp"

namespace lockstep {

namespace {

// Of a Manifold of kernels/shapes/manifold.h with so many points, in units of a real.
constexpr u32 manifold_words(u32 points) { return 7 + 7 * points; }

}  // namespace

void launch_collide(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  const u32 points = has(plan.features, Feature::manifolds) ? 4 : 1;
  launcher.scratch("manifolds", std::size_t{plan.sizes.pairs} * manifold_words(points) * plan.real_words);
  launcher.run("collide_pairs", plan.pairs + 1);
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
