#include "host/device/launches/gradient.hpp"

#include <algorithm>

namespace lockstep {

namespace {

// In words of a real, and of integers: GradientRow and the like of kernels/gradient/descent.h.
void make_room(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  const std::size_t real_words = plan.real_words, joints = std::size_t{plan.sizes.joint_blocks} * PACK;
  const bool touching = has(plan.features, Feature::contacts);
  const auto scratch = [&](const char* name, std::size_t reals, std::size_t integers = 0) {
    launcher.scratch(name, std::max<std::size_t>(reals * real_words + integers, 1));
  };
  scratch("gradient_rows", touching ? std::size_t{plan.sizes.rows} * PACK * 7 : 0);
  scratch("gradient_joints", joints * (1 + 2 * (JOINT_ROWS + 2)));  // sides, two sets of impulses
  scratch("gradient_bodies", std::size_t{plan.sizes.bodies} * (8 + 8 + 4));
  scratch("pair_sides", touching ? std::size_t{plan.sizes.contacts} * 2 * 8 : 0);
  scratch("joint_sides", joints * 2 * 8);
  scratch("descents", std::size_t{plan.sizes.worlds} * 3, std::size_t{plan.sizes.worlds} * 4);
}

}  // namespace

void solve_by_gradient(Launcher& launcher, bool fused) {
  const LaunchPlan& plan = launcher.plan();
  make_room(launcher);
  if (fused) return launcher.run_group("solve_gradient_group");
  const u32 blocks = plan.blocks + plan.sizes.joint_blocks;
  launcher.run("gradient_begin", std::max(blocks * PACK, plan.sizes.bodies));
  for (u32 i = 0; i < plan.counts.iterations; ++i) {
    launcher.run("gradient_step", blocks * (PACK / plan.lanes));
    launcher.run("gradient_move", plan.sizes.bodies);
    launcher.run_group("gradient_decide");
    launcher.run("gradient_take", plan.sizes.bodies);
  }
  launcher.run("gradient_finish", std::max(blocks * (PACK / plan.lanes), plan.sizes.bodies));
}

}  // namespace lockstep
