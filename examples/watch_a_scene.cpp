// Loads a built-in scene, simulates it and says where a body is.
#include <cstdio>
#include <lockstep/world.hpp>

int main() {
  lockstep::World world = lockstep::World::load("slide_to_roll");
  const lockstep::BodyHandle ball = world.bodies().back();
  while (world.time() < 1) world.step();
  const lockstep::Pose pose = world.pose(ball);
  const lockstep::Twist velocity = world.velocity(ball);
  std::printf("after %.2f s at x = %.3f m, %.3f m/s, turning at %.3f rad/s\n", world.time(), pose.position[0],
              velocity.linear[0], velocity.angular[1]);
  const lockstep::WorldDevice device = world.device();
  std::printf("state %016llx on %s\n", static_cast<unsigned long long>(world.state_hash()), device.name.c_str());
  if (!device.bit_exact) std::printf("other devices may get another: %s\n", device.canary.c_str());
}
