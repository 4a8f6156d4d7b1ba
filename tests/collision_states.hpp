// States for the KernelMatchesReference halves of the collision stages, and how one stage is put to the test.
#pragma once

#include <limits>

#include "tests/stage_harness.hpp"
#include "tests/worlds.hpp"

namespace lockstep::test {

/// Three worlds, one of them empty but for a plane: compounds that turn, filters, all kinds of bodies, planes on top of
/// each other, a knot of spheres in one place.
inline std::vector<std::vector<BodyDescription>> lively_worlds() {
  std::vector<std::vector<BodyDescription>> worlds = {{}, {plane_body()}, {}};
  for (u32 w = 0; w < 3; w += 2) {
    Random random(40 + w);
    worlds[w] = {plane_body({0, 0, -3}), plane_body({-3, 0, 0}, {0, 0.6, 0, 0.8})};
    for (u32 n = 0; n < 300 + 100 * w; ++n) {
      BodyDescription body = sphere_body(random.vector(3), random.between(0.02, 0.4), random.vector(3));
      body.kind = n % 7 == 0 ? BODY_STATIC : n % 7 == 1 ? BODY_KINEMATIC : BODY_DYNAMIC;
      body.angular_velocity = random.vector(10);
      if (n % 13 == 0) body.position = {1, 1, 1};
      const ShapeDescription first = body.shapes[0];
      for (u32 k = 0; k < n % 3; ++k) {
        body.shapes.push_back(first);
        body.shapes.back().offset = random.vector(0.5);
      }
      if (n % 5 == 0) body.shapes[0].mask = random.bits();
      worlds[w].push_back(body);
    }
    worlds[w].push_back(plane_body({0, 0, -3.001}));
  }
  return worlds;
}

/// Pairs of all shapes, each pair in a world of its own: half of them at random, half in poses full of ties.
inline std::vector<std::vector<BodyDescription>> worlds_of_pairs(u32 count) {
  std::vector<std::vector<BodyDescription>> worlds;
  Random random(77);
  const auto shape = [&](u32 kind, Vector3 position, bool ties) {
    const auto size = [&] { return ties ? 0.25 * double(1 + random.bits() % 2) : random.between(0.2, 0.6); };
    BodyDescription body = kind == SHAPE_SPHERE  ? sphere_body(position, size())
                           : kind == SHAPE_BOX   ? box_body(position, {size(), size(), size()})
                           : kind == SHAPE_PLANE ? plane_body(position)
                                                 : round_body(ShapeKind(kind), position, size(), size());
    const Quaternion rotations[] = {{0, 0, 0, 1}, {0.5, 0.5, 0.5, 0.5}, {0, 0, 1, 0}, {0, 0, 0.6, 0.8}};
    body.orientation = ties ? rotations[random.bits() % 4] : random.rotation();
    if (kind != SHAPE_PLANE) body.velocity = random.vector(ties ? 0 : 2);
    return body;
  };
  for (u32 n = 0; n < count; ++n) {
    const bool ties = n % 2 == 1;
    Vector3 offset = random.vector(0.7);
    if (ties)
      offset = {0.25 * double(random.bits() % 4), 0.25 * double(random.bits() % 4), 0.25 * double(random.bits() % 5)};
    worlds.push_back(
        {shape(random.bits() % SHAPE_PLANE, {0, 0, 0}, ties), shape(random.bits() % SHAPE_KINDS, offset, ties)});
    if (worlds.back()[0].shapes[0].kind == SHAPE_HULL) worlds.back()[0] = sphere_body({0, 0, 0}, 0.5);
    if (worlds.back()[1].shapes[0].kind == SHAPE_HULL) worlds.back()[1] = sphere_body(offset, 0.5);
  }
  return worlds;
}

/// A body of one of the kinds that turn and move: long, flat, tiny and huge ones.
inline BodyDescription any_body(Random& random, double space, double size) {
  const Vector3 position = random.vector(space);
  const double shrink = random.between(0, 1), radius = size * (0.02 + shrink * shrink * shrink * shrink);
  BodyDescription body;
  switch (random.bits() % 5) {
    case 0: body = sphere_body(position, radius); break;
    case 1: body = round_body(SHAPE_CAPSULE, position, 0.2 * radius, random.between(0.1, 3) * radius); break;
    case 2: body = round_body(SHAPE_CYLINDER, position, radius, random.between(0.05, 2) * radius); break;
    case 3:
      body = box_body(position, {radius, random.between(0.02, 1) * radius, random.between(0.02, 3) * radius});
      break;
    default: body = box_body(position, {radius, radius, radius});
  }
  body.orientation = random.bits() % 4 == 0 ? Quaternion{0, 0, 0, 1} : random.rotation();
  body.velocity = random.vector(2);
  body.angular_velocity = random.vector(4);
  return body;
}

/// Two worlds of all kinds of bounded shapes, compounds, immovables and filters, one empty, one of planes alone.
inline std::vector<std::vector<BodyDescription>> worlds_of_all_kinds() {
  std::vector<std::vector<BodyDescription>> worlds = {{}, {}, {plane_body(), plane_body({1, 2, 3})}, {}};
  for (u32 w = 0; w < 4; w += 3) {
    Random random(50 + w);
    worlds[w] = {plane_body({0, 0, -3})};
    for (u32 n = 0; n < 300 + 100 * w; ++n) {
      BodyDescription body = any_body(random, 3, 0.8);
      body.kind = n % 7 == 0 ? BODY_STATIC : n % 7 == 1 ? BODY_KINEMATIC : BODY_DYNAMIC;
      if (n % 5 == 0) body.shapes[0].mask = random.bits();
      for (u32 k = 0; k < n % 3; ++k) {
        body.shapes.push_back(any_body(random, 0, 0.5).shapes[0]);
        body.shapes.back().offset = random.vector(0.5);
        body.shapes.back().rotation = random.rotation();
      }
      worlds[w].push_back(body);
    }
    worlds[w].push_back(box_body({0, 0, -4}, {30, 30, 1}));
    worlds[w].back().kind = BODY_STATIC;
  }
  return worlds;
}

/// Launches that the collision kernels are run with.
inline std::vector<DeviceOptions> launches() { return launch_options({{1, 7}, {8, 1}, {16, 64}}); }

/// Launches that whole steps with all shapes are run with: few, since each builds a large program.
template <class real>
std::vector<DeviceOptions> launches_of_a_step() {
  return launch_options({{1, 7}, {sizeof(real) == 8 ? 8 : 16, 64}});
}

/// Runs the stages before `stage` in the reference, and then this one in both.
template <class real>
Buffers<real> expect_kernel_matches(Stage stage, InitialState<real> state, std::initializer_list<Stage> before) {
  run_reference(state, before);
  return run_one_stage(stage, state.buffers, state.sizes, state.features, state.params, launches());
}

}  // namespace lockstep::test
