// Worlds of the library and bodies for them.
#pragma once

#include "host/scene/exact_math.hpp"
#include "include/lockstep/world.hpp"
#include "tests/refusal.hpp"

namespace lockstep {

inline WorldOptions in_double() { return {.device = "reference", .precision = "double"}; }

inline BodyDescription level_floor() {
  BodyDescription floor;
  floor.name = "floor";
  floor.kind = BODY_STATIC;
  floor.shapes.push_back({.kind = SHAPE_PLANE});
  return floor;
}

inline BodyDescription box_at(const Vector3& position, double mass = 2) {
  BodyDescription box;
  box.position = position;
  box.shapes.push_back({.kind = SHAPE_BOX, .half_extents = {0.5, 0.5, 0.5}});
  make_solid_of_mass(box, mass);
  return box;
}

inline BodyDescription ball_at(const Vector3& position) {
  BodyDescription ball;
  ball.position = position;
  ball.shapes.push_back({.kind = SHAPE_SPHERE, .radius = 0.5});
  make_solid(ball, 1000);
  return ball;
}

inline Scene ground_scene(double friction = 0.5) {
  Scene scene;
  scene.name = "ground";
  scene.source = "ground";
  scene.settings.dt = 0.01;
  replace_solver(scene.settings, Solver::small_steps);
  scene.materials = {{.name = "stuff", .friction = friction, .restitution = 0}};
  scene.bodies.push_back(level_floor());
  return scene;
}

inline Scene empty_scene(double dt = 0.01) {
  Scene scene;
  scene.name = scene.source = "space";
  scene.settings.dt = dt;
  scene.gravity = {0, 0, 0};
  return scene;
}

}  // namespace lockstep
