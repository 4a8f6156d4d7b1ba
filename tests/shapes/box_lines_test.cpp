// Boxes that touch along a line, lie on much larger ones, or meet corner first, by every method.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/library_worlds.hpp"
#include "tests/worlds.hpp"

namespace lockstep::box_lines_test {
namespace {

constexpr double g = 9.81;

struct Method {
  const char *name, *solver, *precision;
};

class BoxLines : public testing::TestWithParam<Method> {
 protected:
  World world(const Scene& scene) const {
    return World(scene, {.device = "reference", .precision = GetParam().precision, .solver = GetParam().solver});
  }
};

INSTANTIATE_TEST_SUITE_P(, BoxLines,
                         testing::Values(Method{"gauss_seidel_float", "gauss_seidel", "float"},
                                         Method{"gauss_seidel_double", "gauss_seidel", "double"},
                                         Method{"small_steps_float", "small_steps", "float"},
                                         Method{"small_steps_double", "small_steps", "double"},
                                         Method{"auto_double", "auto", "double"}),
                         [](const auto& each) { return std::string(each.param.name); });

Quaternion about(const Vector3& axis, double angle) {
  return exact::rotation(axis, std::sin(angle / 2), std::cos(angle / 2));
}

BodyDescription box_of(const Vector3& half_extents, const Vector3& position, BodyKind kind = BODY_DYNAMIC) {
  BodyDescription box;
  box.kind = kind;
  box.position = position;
  box.shapes.push_back({.kind = SHAPE_BOX, .half_extents = half_extents});
  if (kind == BODY_DYNAMIC) make_solid(box, 700);
  return box;
}

Scene scene_with(std::vector<BodyDescription> bodies, double friction = 0.5) {
  Scene scene;
  scene.name = scene.source = "boxes";
  scene.settings.dt = 1.0 / 60;
  scene.materials = {{.name = "wood", .friction = friction, .restitution = 0}};
  scene.bodies = std::move(bodies);
  return scene;
}

double speed(const Twist& v) { return std::sqrt(exact::dot(v.linear, v.linear)); }
double angular_speed(const Twist& v) { return std::sqrt(exact::dot(v.angular, v.angular)); }

// One end on the ground, and over the edge of a bar: the line along the edge that the plank lies on has two ends, both
// of which hold it. It starts where it rests.
TEST_P(BoxLines, APlankRestsOnAnEdge) {
  const bool exactly = std::string(GetParam().solver) == "auto";
  for (int n = 0; n < (exactly ? 3 : 8); ++n) {
    test::Random random(n);
    const double thick = random.between(0.005, 0.05), half = random.between(0.8, 1.2), bar = random.between(0.02, 0.05);
    const double wide = random.between(0.02, 0.2), yaw = random.between(-0.3, 0.3),
                 from_foot = random.between(0.55, 0.8);
    // seen from the side: the foot at the origin, the upper edge of the bar at (s, 2 bar), on the plank's lower face
    const double s = 2 * half * from_foot, lean = std::asin(2 * bar / s);
    const Vector3 along = {std::cos(lean), 0, std::sin(lean)}, up = {-std::sin(lean), 0, std::cos(lean)};
    const Quaternion by_yaw = about({0, 0, 1}, yaw);
    BodyDescription plank = box_of({half, wide, thick}, exact::add(exact::scale(half, along), exact::scale(thick, up)));
    plank.orientation = exact::unit(exact::multiply(by_yaw, about({0, 1, 0}, -lean)));
    plank.position = exact::rotate(by_yaw, plank.position);
    BodyDescription beam = box_of({bar, 1, bar}, {s * std::cos(lean) + bar, 0, bar}, BODY_STATIC);
    beam.position = exact::rotate(by_yaw, beam.position);
    beam.orientation = by_yaw;
    Scene scene = scene_with({level_floor(), beam, plank}, 0.6);
    World w = world(scene);
    const Vector3 start = w.pose(w.bodies()[2]).position;
    w.step(exactly ? 120 : 600);
    const Pose end = w.pose(w.bodies()[2]);
    const Vector3 moved = exact::add(end.position, exact::scale(-1, start));
    EXPECT_LT(angular_speed(w.velocity(w.bodies()[2])), 1e-3) << n;
    EXPECT_LT(speed(w.velocity(w.bodies()[2])), 1e-3) << n;
    EXPECT_LT(std::sqrt(exact::dot(moved, moved)), 1e-3) << n;
  }
}

// 10 mm dice on a ground box up to 10,000 times as large, whose surface is 10 of their sizes from its centre.
TEST_P(BoxLines, DiceRestOnALargeBox) {
  for (const double ground : {0.1, 10.0, 100.0}) {
    Scene scene = scene_with({box_of({ground, ground, 0.1}, {0, 0, -0.1}, BODY_STATIC)});
    for (int n = 0; n < 4; ++n) {
      BodyDescription die = box_of({0.005, 0.005, 0.005}, {0.04 * n - 0.06, 0.01 * n, 0.0051});
      die.orientation = about({0, 0, 1}, 0.4 * n);
      scene.bodies.push_back(die);
    }
    World w = world(scene);
    w.step(120);
    for (int n = 1; n <= 4; ++n) {
      EXPECT_NEAR(w.pose(w.bodies()[n]).position[2], 0.005, 1.5e-4) << ground;
      EXPECT_LT(angular_speed(w.velocity(w.bodies()[n])), 0.01) << ground;
    }
  }
}

// Shot at the middle of a cube from where it lies diagonally, so that no face of one is over a face of the other at
// the start: it is stopped on this side, its middle hardly inside.
TEST_P(BoxLines, ShotsAlongTheDiagonalDoNotPass) {
  test::Random random(3);
  const int shots = std::string(GetParam().solver) == "auto" ? 20 : 150;
  int passed = 0;
  for (int n = 0; n < shots; ++n) {
    BodyDescription bullet = box_of({0.2, 0.2, 0.2}, {1.6, random.between(-0.2, 0.2), random.between(0.9, 1.3)});
    const Vector3 target = {0, random.between(-0.1, 0.1), random.between(-0.1, 0.1)};
    const Vector3 direction = exact::add(target, exact::scale(-1, bullet.position));
    bullet.velocity = exact::scale(random.between(20, 180) / std::sqrt(exact::dot(direction, direction)), direction);
    Scene scene = scene_with({box_of({0.5, 0.5, 0.5}, {0, 0, 0}, BODY_STATIC), bullet});
    scene.gravity = {0, 0, 0};
    World w = world(scene);
    double farthest = 2;
    for (int k = 0; k < 8; ++k) {
      w.step(1);
      farthest = std::min(farthest, w.pose(w.bodies()[1]).position[0]);
    }
    passed += farthest < 0.25;
  }
  EXPECT_EQ(passed, 0) << "of " << shots;
}

// Two cubes meet edge to edge, their edges crossing or parallel: nothing leaves faster than it came, and no edge gets
// deeper than half of what it moves in a step.
TEST_P(BoxLines, EdgesThatMeetNeitherThrowNorPass) {
  for (const double crossing : {0.0, 0.02, 0.3, 1.5}) {
    const Quaternion on_edge = about({0, 1, 0}, exact::pi / 4);
    BodyDescription below = box_of({0.5, 0.5, 0.5}, {0, 0, 0}, BODY_STATIC);
    below.orientation = on_edge;
    BodyDescription above = box_of({0.5, 0.5, 0.5}, {0.01, 0, 1.5});
    above.orientation = exact::unit(exact::multiply(about({0, 0, 1}, crossing), on_edge));
    above.velocity = {0, 0, -5};
    Scene scene = scene_with({below, above}, 0);
    scene.gravity = {0, 0, 0};
    World w = world(scene);
    double fastest = 0, deepest = 0;
    for (int k = 0; k < 20; ++k) {
      w.step(1);
      fastest = std::max(fastest, speed(w.velocity(w.bodies()[1])));
      deepest = std::max(deepest, w.errors().max_penetration);
    }
    EXPECT_LT(fastest, 5.01) << crossing;
    EXPECT_LT(deepest, 5.0 / 60 / 2) << crossing;
    EXPECT_GT(w.velocity(w.bodies()[1]).linear[2], -4.9) << crossing;
  }
}

}  // namespace
}  // namespace lockstep::box_lines_test
