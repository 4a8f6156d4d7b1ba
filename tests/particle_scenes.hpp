// Bodies of particles, for the tests of their stages and of what they do.
#pragma once

#include <cmath>

#include "host/scene/compile.hpp"
#include "host/scene/solid_body.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep {

inline ShapeDescription ball_shape(double radius) {
  ShapeDescription shape;
  shape.radius = radius;
  return shape;
}
inline ShapeDescription box_shape(Vector3 half) {
  ShapeDescription shape;
  shape.kind = SHAPE_BOX;
  shape.half_extents = half;
  return shape;
}

/// A solid of this mass.
inline BodyDescription solid_body(ShapeDescription shape, double mass, Vector3 position) {
  BodyDescription body;
  body.shapes = {std::move(shape)};
  make_solid_of_mass(body, mass);
  body.position = exact::add(body.position, position);
  return body;
}

/// A half space whose surface goes through the point.
inline BodyDescription floor_body(Vector3 point = {0, 0, 0}, Vector3 normal = {0, 0, 1}) {
  BodyDescription body;
  body.kind = BODY_STATIC;
  body.position = point;
  ShapeDescription plane;
  plane.kind = SHAPE_PLANE;
  plane.rotation = exact::rotation_from_z_to(normal);
  body.shapes = {plane};
  return body;
}

inline Scene particle_scene(std::vector<BodyDescription> bodies, ParticleSettings particles, double dt) {
  Scene scene;
  scene.source = "test";
  scene.settings.dt = dt;
  scene.settings.margin = 0.25 * particles.radius;
  scene.particles = particles;
  scene.bodies = std::move(bodies);
  return scene;
}

/// Boxes and balls that have fallen into each other on a floor, beside a static and a kinematic one, all in motion.
inline Scene lively_particles(u32 substeps = 1, u32 side = 3) {
  std::vector<BodyDescription> bodies = {floor_body(), floor_body({-0.7, 0, 0}, {1, 0, 0.2})};
  for (u32 i = 0; i < side * side * side; ++i) {
    const double x = i % side, y = i / side % side, z = i / (side * side);
    ShapeDescription shape = i % 2 ? ball_shape(0.15) : box_shape({0.15, 0.12, 0.1});
    bodies.push_back(solid_body(shape, 1 + 0.1 * (i % 4), {0.26 * x + 0.01 * z, 0.27 * y, 0.1 + 0.22 * z}));
    bodies.back().orientation = exact::rotation({1, 0.3 * x, y - 1}, std::sin(0.1 * i), std::cos(0.1 * i));
    bodies.back().velocity = {1 - x, 0.5 * (1 - y), -0.3 * z};
    bodies.back().angular_velocity = {0.2 * x, 1, -y};
  }
  bodies.push_back(solid_body(box_shape({0.2, 0.2, 0.1}), 1, {0.3, 0.3, 0.9}));
  bodies.back().kind = BODY_KINEMATIC;
  bodies.back().velocity = {0, 0, -0.5};
  bodies.push_back(solid_body(ball_shape(0.2), 1, {0.1, -0.2, 0.1}));
  bodies.back().kind = BODY_STATIC;
  Scene scene = particle_scene(std::move(bodies), {.radius = 0.04, .stiffness = 2000, .restitution = 0.4}, 4e-4);
  scene.settings.dt *= substeps;
  scene.settings.substeps = substeps;
  return scene;
}

/// The same with springs along the surfaces.
inline Scene sprung(Scene scene) {
  scene.particles->shear_stiffness = 0.7 * scene.particles->stiffness;
  return scene;
}

/// Two worlds of them, some steps on.
template <class real>
InitialState<real> lively_state(
    u32 steps = 3, Scene (*change)(Scene) = [](Scene scene) { return scene; }) {
  const std::vector<Scene> worlds = {change(lively_particles()), change(lively_particles(1, 2))};
  InitialState<real> state = compile<real>(worlds);
  ReferenceBackend<real> backend(state);
  for (u32 i = 0; i < steps; ++i) step(backend, state.params);
  state.buffers = backend.buffers();
  return state;
}

inline const std::vector<Stage> particle_stages = {
    Stage::begin_step,      Stage::bound_particles,  Stage::sort_particles,
    Stage::find_neighbours, Stage::match_springs,    Stage::push_particles,
    Stage::sum_particles,   Stage::update_particles, Stage::store_springs};

/// Runs the stages of particles before `stage` in the reference, then that one on both sides; returns the reference's
/// buffers after it.
template <class real>
Buffers<real> expect_particle_twins_agree(Stage stage, InitialState<real> state) {
  ReferenceBackend<real> before(state);
  for (const Stage earlier : particle_stages) {
    if (earlier == stage) break;
    before.run(earlier, state.params);
  }
  return run_one_stage(stage, before.buffers(), state.sizes, state.features, state.params, all_launch_options());
}

/// Everything that the stages before `stage`, and it, make of a state.
template <class real>
Buffers<real> after_particle_stage(Stage stage, const InitialState<real>& state) {
  ReferenceBackend<real> backend(state);
  for (const Stage each : particle_stages) {
    backend.run(each, state.params);
    if (each == stage) break;
  }
  return backend.buffers();
}

}  // namespace lockstep
