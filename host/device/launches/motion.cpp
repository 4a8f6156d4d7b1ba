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
  launcher.run("hash_state_steps", launcher.plan().sizes.worlds);
  launcher.run("hash_state_bodies", launcher.plan().sizes.bodies);
  if (has(launcher.plan().features, Feature::contacts)) {
    launcher.run("hash_state_contacts", launcher.plan().sizes.contacts);
  }
  if (has(launcher.plan().features, Feature::joints))
    launcher.run("hash_state_joints", launcher.plan().sizes.joint_blocks * PACK);
  if (has(launcher.plan().features, Feature::events)) launcher.run("hash_state_touching", launcher.plan().sizes.pairs);
}

}  // namespace lockstep
