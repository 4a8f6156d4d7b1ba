// Launches of the stages that move bodies.
#include "host/device/launcher.hpp"

namespace lockstep {

void launch_begin_step(Launcher& launcher) { launcher.run("begin_step", COUNTER_COUNT); }

void launch_integrate_velocities(Launcher& launcher) {
  launcher.run("integrate_velocities", launcher.plan().sizes.bodies);
}

void launch_integrate_positions(Launcher& launcher) {
  launcher.run("integrate_positions", launcher.plan().sizes.bodies);
}

void launch_integrate_free_flight(Launcher& launcher) {
  launcher.run("integrate_free_flight", launcher.plan().sizes.bodies);
}

void launch_end_step(Launcher& launcher) { launcher.run("end_step", 1); }

void launch_hash_state(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  // a work-item adds up what it has before it meets the others at the sum
  const u32 share = plan.lanes > 1 ? 64 : 4;
  const auto run = [&](const char* kernel, u32 records) { launcher.run(kernel, (records + share - 1) / share); };
  launcher.run("hash_state_steps", plan.sizes.worlds);
  run("hash_state_bodies", plan.sizes.bodies);
  if (has(plan.features, Feature::contacts)) run("hash_state_contacts", plan.contacts);
  if (has(plan.features, Feature::sleeping)) {
    run("hash_state_sleepers", plan.sizes.bodies);
    if (has(plan.features, Feature::contacts)) run("hash_state_slept", plan.contacts);
  }
  if (has(plan.features, Feature::joints)) run("hash_state_joints", plan.sizes.joint_blocks * PACK);
  if (has(plan.features, Feature::couplings)) {
    const u32 couplings = plan.sizes.couplings;
    launcher.run("hash_state_couplings", (couplings + share - 1) / share, {{"coupling_count", couplings}});
  }
  if (has(plan.features, Feature::events)) run("hash_state_touching", plan.pairs);
  if (has(plan.features, Feature::shear_springs)) run("hash_state_springs", plan.pairs);
}

}  // namespace lockstep
