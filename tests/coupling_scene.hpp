// Scenes with couplings of joints for the tests.
#pragma once

#include <algorithm>

#include "cpu_reference/joints/couplings.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test {

inline CouplingDescription coupling_of(std::vector<CoupledCoordinate> joints, double sum = 0) {
  CouplingDescription coupling;
  coupling.joints = std::move(joints);
  coupling.limited = true;
  coupling.low = coupling.high = sum;
  return coupling;
}

/// Adds couplings of one to four joints with a coordinate: equal, with limits, with springs, with both.
inline Scene random_couplings(Scene scene, u32 couplings) {
  Random random(23);
  std::vector<u32> free;
  for (u32 j = 0; j < scene.joints.size(); ++j)
    if (free_of(scene.joints[j].kind) != FREE_NOTHING) free.push_back(j);
  scene.couplings.clear();
  for (u32 i = 0; i < couplings; ++i) {
    CouplingDescription coupling = coupling_of({}, random.between(-0.1, 0.1));
    const u32 count = 1 + random.bits() % 4;
    while (coupling.joints.size() < count) {
      const u32 joint = free[random.bits() % free.size()];
      if (std::ranges::find(coupling.joints, joint, &CoupledCoordinate::joint) == coupling.joints.end())
        coupling.joints.push_back({joint, random.between(0.2, 2) * (random.bits() % 2 == 0 ? 1 : -1)});
    }
    if (random.bits() % 2 == 0) coupling.high += random.between(0, 0.3);
    if (random.bits() % 2 == 0) {
      coupling.spring = {random.between(0, 100), random.between(0.1, 2), random.between(0, 0.3)};
      coupling.limited = random.bits() % 2 == 0;
    }
    scene.couplings.push_back(coupling);
  }
  return scene;
}

/// Two fingers on hinges to a palm that hangs on a slider: the second stands at -0.5 of the first and `offset` on.
inline Scene gripper(double offset) {
  Scene scene =
      joint_scene({bare_body({0, 0, 0}), bare_body({0.3, 0, -0.4}, {0.02, 0.03, 0.04}),
                   bare_body({-0.2, 0, -0.5}, {0.05, 0.03, 0.04})},
                  {joint_of(JOINT_SLIDER, NONE, 0, {0, 0, 0}), joint_of(JOINT_HINGE, 0, 1, {0.1, 0, 0}, {0, 1, 0}),
                   joint_of(JOINT_HINGE, 0, 2, {-0.1, 0, 0}, {0, 1, 0})},
                  0.002);
  scene.bodies[0].mass = 3;
  scene.couplings = {coupling_of({{2, 1}, {1, 0.5}}, offset)};
  return scene;
}

/// Its fingers have tips, which press on a floor.
inline Scene gripper_on_floor(double offset) {
  Scene scene = gripper(offset);
  for (u32 i = 1; i < 3; ++i) scene.bodies[i].shapes.push_back({.kind = SHAPE_SPHERE, .radius = 0.1});
  BodyDescription floor;
  floor.kind = BODY_STATIC;
  floor.position = {0, 0, -0.55};
  floor.shapes.push_back({.kind = SHAPE_PLANE});
  scene.bodies.push_back(floor);
  scene.materials = {{.name = "stuff"}};
  return scene;
}

}  // namespace lockstep::test
