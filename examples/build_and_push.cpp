// Builds a scene in code: a crate on a floor, pushed by a force that grows with time until it slips, and a lift. With
// an argument it records what happens there, for `lockstep verify` and `lockstep render`.
#include <cmath>
#include <cstdio>
#include <lockstep/world.hpp>

using namespace lockstep;

int main(int argc, char** argv) {
  Scene scene;
  scene.name = "crate";
  scene.settings.solver = Solver::small_steps;
  scene.materials = {{.name = "wood", .friction = 0.5, .restitution = 0}};

  BodyDescription floor;
  floor.kind = BODY_STATIC;
  floor.shapes.push_back({.kind = SHAPE_PLANE});

  BodyDescription crate;
  crate.position = {0, 0, 0.5};
  crate.shapes.push_back({.kind = SHAPE_BOX, .half_extents = {0.5, 0.5, 0.5}});
  make_solid_of_mass(crate, 20);

  BodyDescription lift;
  lift.kind = BODY_KINEMATIC;
  lift.position = {5, 0, 0.1};
  lift.shapes.push_back({.kind = SHAPE_BOX, .half_extents = {1, 1, 0.1}});

  World world(scene);
  world.add(floor);
  const BodyHandle pushed = world.add(crate), platform = world.add(lift);

  // 20 N more every second; friction holds 0.5 x 20 kg x 9.81 m/s^2 = 98.1 N
  world.set_load(pushed, load_table({{0, {}}, {10, {.force = {200, 0, 0}}}}));
  if (argc > 1) world.record(argv[1]);
  while (world.velocity(pushed).linear[0] < 0.01) {
    world.set_kinematic_target(platform, {.position = {5, 0, 0.1 + 0.1 * world.time()}});
    world.step();
  }
  std::printf("the crate slips at %.2f s; the lift is %.2f m up\n", world.time(),
              world.pose(platform).position[2] - 0.1);
}
