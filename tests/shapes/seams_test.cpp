// Shapes that lie flush are one: nothing is felt where tiles, blocks, hulls and surfaces meet that do not move against
// each other, and what sticks out, gapes or ends is.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/library_worlds.hpp"
#include "tests/shapes/seam_scenes.hpp"
#include "tests/stage_harness.hpp"
#include "tests/surfaces.hpp"

namespace lockstep::seams_test {
namespace {

using namespace seam_scenes;

struct Ground {
  const char* name;
  std::vector<BodyDescription> bodies;
};

TriangleMesh level_field(u32 points, double spacing) {
  return hills(points, spacing, [](double, double) { return 0.0; });
}

std::vector<Ground> grounds() {
  std::vector<Ground> grounds = {{"tiles", laid(tiles(), box)},
                                 {"tiles askew", rotated(laid(tiles(), box), askew)},
                                 {"tiles of one body", {compound(laid(tiles(), box))}},
                                 {"tiles of a kinematic body", {compound(laid(tiles(), box), BODY_KINEMATIC)}},
                                 {"hulls", laid(tiles(), hull_box)},
                                 {"bricks", laid(bricks(), box)}};
  std::vector<BodyDescription> mixed = laid(tiles(), box);
  for (std::size_t i = 0; i < mixed.size(); i += 2) mixed[i].shapes[0] = hull_box({0.2, 0.2, 0.2});
  grounds.push_back({"boxes and hulls", mixed});
  std::vector<BodyDescription> moving = laid(tiles(), box), mixed_kinds = moving;
  for (std::size_t i = 0; i < moving.size(); ++i) {
    moving[i].kind = BODY_KINEMATIC;
    if (i % 2 == 0) mixed_kinds[i].kind = BODY_KINEMATIC;
  }
  grounds.push_back({"kinematic tiles", moving});
  grounds.push_back({"static and kinematic tiles in turn", mixed_kinds});
  std::vector<BodyDescription> fields, unequal, cubes, beside = laid(tiles(0.4, 5), box);
  for (const double x : {-1.0, 1.0, 3.0})
    for (const double y : {-1.0, 1.0}) fields.push_back(surface_body(level_field(5, 0.5), {x, y, 0}));
  for (const double x : {-1.0, 1.0, 3.0})
    for (const double y : {-1.0, 1.0})
      unequal.push_back(surface_body(x == y ? level_field(6, 0.4) : level_field(5, 0.5), {x, y, 0}));
  for (const double x : {-0.75, 0.25, 1.25, 2.25})
    for (const double y : {-0.75, 0.25, 1.25}) cubes.push_back(surface_body(cube_mesh(0.5), {x, y, -0.5}));
  beside.push_back(surface_body(level_field(11, 0.4), {0.4 + 2, 0, 0}));
  grounds.push_back({"height fields", fields});
  grounds.push_back({"height fields of unequal spacing", unequal});
  grounds.push_back({"cubes of triangles", cubes});
  grounds.push_back({"tiles beside a height field", beside});
  return grounds;
}

// Rolling.
BodyDescription on_its_side(const ShapeDescription& shape) {
  BodyDescription body = solid(shape, {0.0317, 0.0213, 0.2}, {0, 1, 0}, lying);
  body.angular_velocity = {-5, 0, 0};
  return body;
}

std::vector<BodyDescription> sliders() {
  BodyDescription ball = solid(sphere(0.1), {0.0317, 0.0213, 0.1}, {2, 0.3, 0});
  ball.angular_velocity = {-3, 20, 0};
  return {ball,
          solid(sphere(0.25), {0.0317, 0.0213, 0.25}, {2, 0.3, 0}),
          solid(box({0.3, 0.2, 0.2}), {0.0317, 0.0213, 0.2}, {3, 0.4, 0}),
          solid(box({0.1, 0.1, 0.1}), {0.8317, 0.0213, 0.1}, {-2.5, 0.2, 0}),
          solid(box({0.05, 0.05, 0.05}), {0.0317, 0.0213, 0.05}, {3, 0.4, 0}),
          on_its_side({.kind = SHAPE_CAPSULE, .radius = 0.2, .half_length = 0.3}),
          on_its_side({.kind = SHAPE_CYLINDER, .radius = 0.2, .half_length = 0.3}),
          solid({.kind = SHAPE_CYLINDER, .radius = 0.2, .half_length = 0.2}, {0.0317, 0.0213, 0.2}, {2, 0.3, 0}),
          solid(hull_box({0.2, 0.2, 0.15}), {0.0317, 0.0213, 0.15}, {2, 0.3, 0})};
}

void expect_as_on_a_plane(const Ground& ground, const BodyDescription& body, Solver solver) {
  std::vector<BodyDescription> bodies = ground.bodies;
  bodies.push_back(body);
  World on_plane(scene_of({level_floor(), body}, 0.5, solver), in_double());
  World on_ground(scene_of(bodies, 0.5, solver), in_double());
  // small steps let a cylinder rock whose points come and go as it rolls over seams that are askew
  const double close = solver == Solver::gauss_seidel ? 1e-3 : 1.5e-2;
  const BodyHandle one = on_plane.bodies().back(), other = on_ground.bodies().back();
  for (int i = 0; i < 60; ++i) {
    on_plane.step();
    on_ground.step();
    const Pose a = on_plane.pose(one), b = on_ground.pose(other);
    for (unsigned k = 0; k < 3; ++k) ASSERT_NEAR(a.position[k], b.position[k], close) << i;
    for (unsigned k = 0; k < 4; ++k) ASSERT_NEAR(a.orientation[k], b.orientation[k], 3 * close) << i;
    for (const BodyContact& contact : on_ground.contacts()) ASSERT_GT(std::abs(contact.normal[2]), 1 - 1e-4) << i;
  }
  EXPECT_GT(exact::length(exact::subtract(on_ground.pose(other).position, body.position)), 0.3);
}

// A second of sliding and rolling is one on a plane.
TEST(Seams, AFlushGroundIsAPlane) {
  for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps}) {
    for (const Ground& ground : grounds()) {
      int n = 0;
      for (const BodyDescription& body : sliders()) {
        SCOPED_TRACE(std::string(ground.name) + ", body " + std::to_string(n++) + ", " + std::string(name_of(solver)));
        expect_as_on_a_plane(ground, body, solver);
      }
    }
  }
}

// A ball that rolls goes on with all its speed, a box without friction too, in either precision: x = x0 + v t.
TEST(Seams, NothingIsLostOverTenSeams) {
  for (const char* precision : {"float", "double"}) {
    for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps}) {
      for (const Ground& ground : grounds()) {
        SCOPED_TRACE(std::string(ground.name) + ", " + precision);
        BodyDescription ball = solid(sphere(0.1), {-0.5, 0.3, 0.1}, {3, 0, 0});
        ball.angular_velocity = {0, 30, 0};
        const BodyDescription cube = solid(box({0.1, 0.1, 0.1}), {-0.5, 0.3, 0.1}, {3, 0, 0});
        for (const BodyDescription& body : {ball, cube}) {
          std::vector<BodyDescription> bodies = ground.bodies;
          bodies.push_back(body);
          World world(scene_of(bodies, body.angular_velocity[1] > 0 ? 0.5 : 0, solver),
                      {.device = "reference", .precision = precision});
          world.step(45);
          const BodyHandle handle = world.bodies().back();
          const Vector3 p = world.pose(handle).position;
          EXPECT_NEAR(p[0], -0.5 + 3 * 45.0 / 60, 2e-3);
          EXPECT_NEAR(p[1], 0.3, 2e-3);
          EXPECT_NEAR(p[2], 0.1, 2e-3);
          EXPECT_NEAR(world.velocity(handle).linear[0], 3, 5e-3);
          EXPECT_NEAR(exact::length(exact::subtract(world.velocity(handle).angular, body.angular_velocity)), 0, 0.1);
        }
      }
    }
  }
}

std::vector<BodyDescription> two_blocks(double height, double gap = 0) {
  return {fixed(box({1, 1, 1}), {-1, 0, -1}), fixed(box({1, 1, 1}), {1 + gap, 0, height - 1})};
}

std::vector<BodyDescription> with(std::vector<BodyDescription> bodies, const BodyDescription& body) {
  bodies.push_back(body);
  return bodies;
}

// A step up of a millimetre stops a box that slides against it, and lifts a ball.
TEST(Seams, AStepUpIsFelt) {
  for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps}) {
    const BodyDescription cube = solid(box({0.1, 0.1, 0.1}), {-0.5, 0, 0.1}, {1, 0, 0});
    World slides(scene_of(with(two_blocks(1e-3), cube), 0, solver), in_double());
    slides.step(60);
    EXPECT_LT(slides.pose(slides.bodies().back()).position[0], -0.05);
    const BodyDescription ball = solid(sphere(0.1), {-0.5, 0, 0.1}, {2, 0, 0});
    World rolls(scene_of(with(two_blocks(1e-3), ball), 0, solver), in_double());
    double highest = 0;
    for (int i = 0; i < 60; ++i) {
      rolls.step();
      highest = std::max(highest, rolls.pose(rolls.bodies().back()).position[2]);
    }
    EXPECT_GT(highest, 0.1 + 0.8e-3);
    EXPECT_LT(rolls.velocity(rolls.bodies().back()).linear[0], 2 - 1e-3);
    EXPECT_GT(rolls.pose(rolls.bodies().back()).position[0], 0.3);
  }
}

// A step down is not felt before it is reached, and then a box falls by it.
TEST(Seams, AStepDownIsNotFelt) {
  for (const double down : {1e-3, 0.02}) {
    for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps}) {
      const BodyDescription cube = solid(box({0.1, 0.1, 0.1}), {-0.5, 0, 0.1}, {2, 0, 0});
      World world(scene_of(with(two_blocks(-down), cube), 0, solver), in_double());
      world.step(36);
      const BodyHandle handle = world.bodies().back();
      EXPECT_NEAR(world.pose(handle).position[0], -0.5 + 2 * 36.0 / 60, down < 0.01 ? 5e-3 : 0.1);
      EXPECT_GT(world.velocity(handle).linear[0], 1.7);
      EXPECT_LT(world.pose(handle).position[2], 0.1 - 0.5 * down);
    }
  }
}

// Over a gap a ball sinks, and on its other side it is struck.
TEST(Seams, AGapIsFelt) {
  const BodyDescription ball = solid(sphere(0.1), {-0.3, 0, 0.1}, {0.4, 0, 0});
  World world(scene_of(with(two_blocks(0, 0.1), ball), 0), in_double());
  double lowest = 1;
  for (int i = 0; i < 120; ++i) {
    world.step();
    lowest = std::min(lowest, world.pose(world.bodies().back()).position[2]);
  }
  // as deep as a ball of 0.1 m sinks between edges 0.1 m apart
  EXPECT_LT(lowest, std::sqrt(0.01 - 0.0025) + 1e-3);
  EXPECT_GT(lowest, std::sqrt(0.01 - 0.0025) - 5e-3);
}

// Two metres of blocks of every kind that there is, a gap apart, the second half lower by `down`.
std::vector<Ground> grounds_with_gaps(double gap, double down = 0) {
  std::vector<Brick> bricks;
  for (int i = 0; i < 5; ++i) {
    const double x = -1 + i * (0.5 + gap), top = i < 3 ? 0 : -down;
    bricks.push_back({{x, -1, top - 0.5}, {x + 0.5, 1, top}});
  }
  std::vector<BodyDescription> fields;
  for (int i = 0; i < 3; ++i)
    fields.push_back(surface_body(level_field(5, 0.25), {i * (1 + gap) - 0.5, 0, i < 2 ? 0 : -down}));
  return {{"boxes", laid(bricks, box)},
          {"hulls", laid(bricks, hull_box)},
          {"boxes of one body", {compound(laid(bricks, box))}},
          {"boxes of a kinematic body", {compound(laid(bricks, box), BODY_KINEMATIC)}},
          {"fields", fields}};
}

// What is flat goes over a gap as if there were none: it has nothing to fall into it with.
TEST(Seams, WhatIsFlatSpansAGap) {
  const std::vector<BodyDescription> flat = {
      solid(box({0.15, 0.15, 0.15}), {-0.6, 0.02, 0.15}, {2, 0, 0}),
      solid(hull_box({0.2, 0.1, 0.1}), {-0.6, 0.02, 0.1}, {2, 0, 0}),
      solid({.kind = SHAPE_CYLINDER, .radius = 0.15, .half_length = 0.1}, {-0.6, 0.02, 0.1}, {2, 0, 0})};
  for (const double gap : {2e-5, 1e-4, 3e-4, 1e-3, 5e-3, 2e-2}) {
    for (const double down : {0.0, 1e-3}) {
      for (const Ground& ground : grounds_with_gaps(gap, down)) {
        for (std::size_t n = 0; n < flat.size(); ++n) {
          for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps}) {
            SCOPED_TRACE(std::string(ground.name) + ", body " + std::to_string(n) + ", " +
                         std::string(name_of(solver)));
            SCOPED_TRACE(std::to_string(gap) + " m, lower by " + std::to_string(down));
            World world(scene_of(with(ground.bodies, flat[n]), 0, solver), in_double());
            world.step(42);
            const BodyHandle handle = world.bodies().back();
            EXPECT_NEAR(world.pose(handle).position[0], -0.6 + 2 * 42.0 / 60, 1e-2);
            EXPECT_NEAR(world.velocity(handle).linear[0], 2, 0.02);
            EXPECT_NEAR(world.pose(handle).position[2], flat[n].position[2] - down, 2e-3);
          }
        }
      }
    }
  }
}

// A ball sinks by no more than g^2 / 8 r, and by the law of the pivot loses next to nothing on the other edge.
TEST(Seams, ABallRollsOverANarrowGap) {
  const double r = 0.1;
  for (const double gap : {1e-4, 1e-3, 3e-3}) {
    for (const Ground& ground : grounds_with_gaps(gap)) {
      for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps}) {
        SCOPED_TRACE(std::string(ground.name) + ", " + std::to_string(gap) + ", " + std::string(name_of(solver)));
        BodyDescription ball = solid(sphere(r), {-0.6, 0.02, r}, {2, 0, 0});
        ball.angular_velocity = {0, 2 / r, 0};
        World world(scene_of(with(ground.bodies, ball), 0.5, solver), in_double());
        double lowest = 1, highest = 0;
        for (int i = 0; i < 42; ++i) {
          world.step();
          const double z = world.pose(world.bodies().back()).position[2];
          lowest = std::min(lowest, z);
          highest = std::max(highest, z);
        }
        EXPECT_GT(lowest, r - gap * gap / (8 * r) - 2e-4);
        EXPECT_LT(highest, r + 2 * gap / r / 60 + 1e-4);  // for a step, as fast as the pivot turns it upwards
        EXPECT_NEAR(world.velocity(world.bodies().back()).linear[0], 2, 0.02);
      }
    }
  }
}

// A step up of a millimetre beyond a gap stops a box, and a wall beyond one its foot.
TEST(Seams, BeyondAGapAStepIsFelt) {
  for (const double up : {1e-3, 0.3}) {
    for (const double gap : {3e-4, 1e-3, 1e-2}) {
      for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps}) {
        const BodyDescription cube = solid(box({0.1, 0.1, 0.1}), {-0.5, 0, 0.1}, {1, 0, 0});
        World world(scene_of(with(two_blocks(up, gap), cube), 0, solver), in_double());
        world.step(60);
        EXPECT_LT(world.pose(world.bodies().back()).position[0], -0.05) << up << " " << gap;
        EXPECT_NEAR(world.pose(world.bodies().back()).position[2], 0.1, 2e-3);
      }
    }
  }
}

// A wall that stands beside the floor, on it or on the seam of two tiles stops a box, which stays upright.
TEST(Seams, TheFootOfAWallIsFelt) {
  const std::vector<std::vector<BodyDescription>> rooms = {
      two_blocks(0.5),
      {fixed(box({2, 2, 0.5}), {0, 0, -0.5}), fixed(box({0.1, 1, 0.25}), {0.1, 0, 0.25})},
      {fixed(box({2, 1, 0.5}), {0, -1, -0.5}), fixed(box({2, 1, 0.5}), {0, 1, -0.5}),
       fixed(box({0.1, 1, 0.25}), {0.1, 0, 0.25})},
      {surface_body(level_field(11, 0.4)), fixed(box({0.1, 1, 0.25}), {0.1, 0, 0.25})}};
  for (std::size_t room = 0; room < rooms.size(); ++room) {
    for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps}) {
      SCOPED_TRACE(room);
      const BodyDescription cube = solid(box({0.1, 0.1, 0.1}), {-0.5, 0.03, 0.1}, {2, 0, 0});
      World world(scene_of(with(rooms[room], cube), 0.2, solver), in_double());
      world.step(90);
      const Pose pose = world.pose(world.bodies().back());
      EXPECT_NEAR(pose.position[0], -0.1, 2e-2);
      EXPECT_LT(pose.position[0], -0.1 + 1e-3);
      EXPECT_NEAR(pose.position[2], 0.1, 1e-3);
      EXPECT_NEAR(std::abs(pose.orientation[3]), 1, 1e-4);
    }
  }
}

// With a tile gone its neighbours end where it was: a ball falls into the hole, and the corner of the last tile strikes
// it.
TEST(Seams, ATileTakenAwayLeavesEdges) {
  const BodyDescription ball = solid(sphere(0.1), {-0.3, 0.1, 0.1}, {1, 0, 0});
  World world(scene_of(with(laid(tiles(), box), ball), 0), in_double());
  const auto hole = std::ranges::find_if(world.bodies(), [&](BodyHandle body) {
    const Vector3 p = world.pose(body).position;
    return std::abs(p[0] - 0.6) < 1e-9 && std::abs(p[1] - 0.2) < 1e-9;
  });
  ASSERT_NE(hole, world.bodies().end());
  world.step(20);
  EXPECT_NEAR(world.pose(world.bodies().back()).position[2], 0.1, 1e-4);
  world.remove(*hole);
  bool struck = false;
  for (int i = 0; i < 60; ++i) {
    world.step();
    for (const BodyContact& contact : world.contacts())
      struck = struck || (std::abs(contact.normal[0]) > 0.1 && exact::length(contact.impulse) > 0);
  }
  EXPECT_TRUE(struck);
  EXPECT_LT(world.pose(world.bodies().back()).position[2], 0.05);
}

// A triangle and a field end at their corners, which strike a ball beside them from above and not from below.
TEST(Seams, SurfacesEndAtTheirCorners) {
  const BodyDescription triangle = surface_body({{{-2, -2, 0}, {2, -2, 0}, {-2, 2, 0}}, {{0, 1, 2}}});
  const double r = 0.3;
  for (const BodyDescription& ground : {surface_body(level_field(5, 1)), triangle}) {
    const Vector3 start = {2.04, -2.04, 0.6};
    World world(scene_of({ground, solid(sphere(r), start)}, 0), in_double());
    double height = 1;
    for (int i = 0; i < 40; ++i) {
      const Vector3 before = world.pose(world.bodies().back()).position;
      world.step();
      if (height == 1 && world.pose(world.bodies().back()).position[0] != before[0]) height = before[2];
    }
    // struck on its way below r, at which its centre is r from the corner; then off outwards
    EXPECT_LT(height, 0.6);
    EXPECT_GT(height, std::sqrt(r * r - 2 * 0.04 * 0.04) - 1e-3);
    EXPECT_GT(world.pose(world.bodies().back()).position[0], start[0] + 0.1);
    EXPECT_LT(world.pose(world.bodies().back()).position[1], start[1] - 0.1);
    World below(scene_of({ground, solid(sphere(r), {start[0], start[1], -0.6}, {0, 0, 4})}, 0), in_double());
    below.step(8);  // its centre is not yet above
    EXPECT_EQ(below.pose(below.bodies().back()).position[0], start[0]);
  }
}

// What is not felt with all is not covered by all: tiles that some bodies pass through cover nothing for the others.
TEST(Seams, TilesOfOtherFiltersCoverNothing) {
  std::vector<BodyDescription> blocks = two_blocks(0);
  blocks[0].shapes[0].category = 2;
  const BodyDescription cube = solid(box({0.1, 0.1, 0.1}), {-0.3, 0, 0.05}, {0, 0, 0});
  BodyDescription falls = cube;
  falls.shapes[0].mask = 1;  // not the first block
  falls.position = {-0.2, 0, -0.5};
  falls.velocity = {1, 0, 0};
  Scene scene = scene_of(with(blocks, falls), 0);
  scene.gravity = {0, 0, 0};
  World world(scene, in_double());
  world.step(60);
  EXPECT_LT(world.pose(world.bodies().back()).position[0], -0.1 + 1e-3);
}

template <class real>
class SeamTwins : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(SeamTwins, Precisions);

TYPED_TEST(SeamTwins, KernelMatchesReference) {
  using real = TypeParam;
  std::vector<BodyDescription> bodies = laid(bricks(), box);
  for (std::size_t i = 0; i < bodies.size(); i += 3) {
    const Vector3 half = bodies[i].shapes[0].half_extents;
    bodies[i].shapes[0] = hull_box(half);
  }
  bodies.push_back(fixed(box({0.1, 1, 0.5}), {1.5, 0, 0.5}));
  for (const double x : {4.5, 6.502}) bodies.push_back(surface_body(level_field(5, 0.5), {x, 0, -0.01}));
  test::Random random(8);
  for (int n = 0; n < 5; ++n) {
    for (BodyDescription body : sliders()) {
      body.position = {random.between(-1.5, 6), random.between(-0.9, 0.9), random.between(0, 1)};
      body.velocity = exact::add(random.vector(n == 4 ? 60 : 2), {0, 0, -3});
      body.angular_velocity = random.vector(n == 4 ? 30 : 2);
      if (n > 1) body.orientation = random.rotation();
      body.continuous = n == 4;
      bodies.push_back(body);
    }
  }
  const Scene scene = scene_of(bodies, 0.5);
  const InitialState<real> state = compile<real>(std::span<const Scene>(&scene, 1));
  ASSERT_TRUE(has(state.features, Feature::seams));
  const std::span seams(state.buffers.seams.data(), state.sizes.seams);
  EXPECT_TRUE(std::ranges::any_of(seams, [](const Seam<real>& seam) { return seam.has_gap != 0; }));
  expect_twins_agree(state, 6, launch_options({{1, 0}, {16, 0}}));
}

}  // namespace
}  // namespace lockstep::seams_test
