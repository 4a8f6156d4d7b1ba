// Bodies at a ridge of two slopes, of which one tells of contacts with the edge itself, and both of what is over them.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/library_worlds.hpp"
#include "tests/surfaces.hpp"
#include "tests/worlds.hpp"

namespace lockstep::ridges_test {
namespace {

constexpr double g = 9.81;

BodyDescription roof(double slope, double spacing) {
  return surface_body(hills(9, spacing, [slope](double x, double) { return -slope * std::abs(x); }));
}

Scene scene_on(const BodyDescription& ground, const BodyDescription& body, double friction) {
  Scene scene;
  scene.name = scene.source = "ridge";
  scene.settings.dt = 1.0 / 60;
  scene.materials = {{.name = "stuff", .friction = friction, .restitution = 0}};
  scene.bodies = {ground, body};
  return scene;
}

// From the roof, m; negative inside.
double distance_to_roof(const Vector3& x, double slope) {
  const double norm = std::sqrt(1 + slope * slope), height = (x[2] + slope * std::abs(x[0])) / norm;
  const bool over_slope = std::abs(x[0]) > height * slope / norm;
  return over_slope ? height : std::hypot(x[0], x[2]);
}

Quaternion about(const Vector3& axis, double angle) {
  return exact::rotation(axis, std::sin(angle / 2), std::cos(angle / 2));
}

// Rods of 0.6 m and 40 mm lie across the ridge, leaning between its slopes, and spin about it at 21 rad/s, 0.35 rad a
// step: what comes down on a slope is held there, whichever facet has the ridge for its own.
TEST(Ridges, RodsComeDownOnBothSides) {
  const double radius = 0.02, half_length = 0.3;
  const ShapeDescription rods[] = {{.kind = SHAPE_CYLINDER, .radius = radius, .half_length = half_length},
                                   {.kind = SHAPE_CAPSULE, .radius = radius, .half_length = half_length},
                                   {.kind = SHAPE_BOX, .half_extents = {radius, radius, half_length}}};
  for (const double slope : {0.3, 0.6, 1.0}) {
    for (const double spacing : {0.5, 2.0}) {  // of facets: the rods reach over one, and over several
      const BodyDescription ground = roof(slope, spacing);
      test::Random random(7);
      double first_step = 0, later = 0;
      for (int n = 0; n < 90; ++n) {
        const double yaw = random.between(-0.6, 0.6), along = random.between(-0.2, 0.2);
        const double lean = 0.95 * std::atan(slope * std::cos(yaw)) * random.between(-1, 1);
        BodyDescription rod;
        rod.shapes.push_back(rods[n % 3]);
        make_solid(rod, 1000);
        rod.orientation = exact::unit(exact::multiply(about({0, 0, 1}, yaw), about({0, 1, 0}, exact::pi / 2 + lean)));
        const Vector3 axis = exact::rotate(rod.orientation, {0, 0, 1}), to_centre = exact::scale(along, axis);
        const Vector3 over_ridge = {0, random.between(-1, 1), 1.05 * radius / std::sqrt(1 - axis[2] * axis[2]) + 0.002};
        rod.position = exact::add(over_ridge, to_centre);
        rod.angular_velocity = exact::scale(n % 2 ? 21 : -21, exact::unit(Vector3{-axis[1], axis[0], 0}));
        rod.velocity = exact::cross(rod.angular_velocity, to_centre);
        World world(scene_on(ground, rod, 0.5), in_double());
        for (int step = 0; step < 5; ++step) {
          world.step();
          const Pose pose = world.pose(world.bodies()[1]);
          for (int i = -20; i <= 20; ++i) {
            const Vector3 x = exact::add(pose.position, exact::rotate(pose.orientation, {0, 0, half_length * i / 20}));
            double& deepest = step == 0 ? first_step : later;
            deepest = std::max(deepest, radius - distance_to_roof(x, slope));
          }
        }
      }
      EXPECT_LT(first_step, 1e-2) << slope << " " << spacing;
      EXPECT_LT(later, 35e-3) << slope << " " << spacing;
    }
  }
}

// A box that lies flat on one slope and reaches beyond the ridge slides down without friction, 50 mm a step: its
// corners leave the other slope over the ridge, and nothing holds them there.
TEST(Ridges, WhatSlidesOffHasNoContact) {
  const double slope = 0.2, alpha = std::atan(slope);
  for (const double yaw : {0.0, 0.3, 0.7}) {
    for (const double beyond : {0.1, 0.14, 0.2}) {
      BodyDescription box;
      box.shapes.push_back({.kind = SHAPE_BOX, .half_extents = {0.3, 0.2, 0.1}});
      make_solid(box, 1000);
      const Quaternion flat = about({0, 1, 0}, alpha);
      const Vector3 down = exact::rotate(flat, {1, 0, 0}), up = exact::rotate(flat, {0, 0, 1});
      box.orientation = exact::unit(exact::multiply(flat, about({0, 0, 1}, yaw)));
      box.position = exact::add(exact::scale(beyond, down), exact::scale(0.1, up));
      box.position[1] = 0.07;
      box.velocity = exact::scale(3, down);
      World world(scene_on(roof(slope, 0.5), box, 0), in_double());
      for (int step = 1; step <= 12; ++step) {
        world.step();
        const Twist twist = world.velocity(world.bodies()[1]);
        const double speed = 3 + g * std::sin(alpha) * step / 60;
        for (unsigned k = 0; k < 3; ++k) {
          ASSERT_NEAR(twist.linear[k], speed * down[k], 3e-4) << yaw << " " << beyond << " " << step;
          ASSERT_NEAR(twist.angular[k], 0, 1e-3) << yaw << " " << beyond << " " << step;
        }
      }
    }
  }
}

}  // namespace
}  // namespace lockstep::ridges_test
