// What rests on bodies that rotate follows them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "host/scene/read.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::turntable_test {
namespace {

/// A box of 0.1 m at 0.5 m from the centre of a turntable, on which it rests at first.
std::string turntable(double speed, double dt, const char* integrator = "semi_implicit_euler") {
  return fmt::format(R"({{"settings": {{"dt": {}, "integrator": "{}"}},
      "materials": [{{"name": "m", "friction": 0.5}}],
      "bodies": [{{"name": "table", "type": "kinematic", "position": [0, 0, -0.1], "angular_velocity": [0, 0, {}],
                  "shapes": [{{"type": "cylinder", "radius": 4, "length": 0.2, "material": "m"}}]}},
                 {{"name": "box", "density": 1000, "position": [0.5, 0, 0.05], "velocity": [0, {}, 0],
                  "angular_velocity": [0, 0, {}],
                  "shapes": [{{"type": "box", "size": [0.1, 0.1, 0.1], "material": "m"}}]}}]}})",
                     dt, integrator, speed, 0.5 * speed, speed);
}

struct Method {
  const char *solver, *precision, *integrator;
};
void PrintTo(const Method& m, std::ostream* out) { *out << m.solver << ", " << m.precision << ", " << m.integrator; }

class Turntable : public testing::TestWithParam<Method> {
 protected:
  World world(double speed, double dt) const {
    return World(parse_scene(turntable(speed, dt, GetParam().integrator), "turntable_test"),
                 {.device = "reference", .precision = GetParam().precision, .solver = GetParam().solver});
  }
  static double distance_from_axis(World& w) {
    const Vector3 x = w.pose(*w.find("box")).position;
    return std::hypot(x[0], x[1]);
  }
};

// mu g = w^2 r at 3.13 rad/s.
TEST_P(Turntable, ABoxStaysOnATurntableUntilItsFrictionIsUsedUp) {
  for (const double speed : {1.0, 2.5, 3.0}) {
    World w = world(speed, 1. / 60);
    w.step(600);
    EXPECT_NEAR(distance_from_axis(w), 0.5, 2e-3) << speed;
  }
  World w = world(3.3, 1. / 60);
  w.step(120);
  EXPECT_GT(distance_from_axis(w), 0.6);
}

// How far it is from its place on the table after two seconds, when the step is halved.
TEST_P(Turntable, ABoxFollowsATurntableToSecondOrder) {
  const auto error = [&](unsigned steps) {
    World w = world(3, 2. / steps);
    w.step(steps);
    const Vector3 x = w.pose(*w.find("box")).position;
    return std::hypot(x[0] - 0.5 * std::cos(6), x[1] - 0.5 * std::sin(6));
  };
  const double coarse = error(120), fine = error(240);
  EXPECT_LT(coarse, 5e-3);
  if (GetParam().precision == std::string("float")) return;  // rounding
  EXPECT_LT(fine, coarse / 3.3) << coarse;
}

INSTANTIATE_TEST_SUITE_P(ByMethod, Turntable,
                         testing::Values(Method{"small_steps", "float", "semi_implicit_euler"},
                                         Method{"small_steps", "double", "semi_implicit_euler"},
                                         Method{"gauss_seidel", "float", "semi_implicit_euler"},
                                         Method{"gauss_seidel", "double", "semi_implicit_euler"},
                                         Method{"gauss_seidel", "double", "trapezoidal"},
                                         Method{"jacobi", "double", "semi_implicit_euler"},
                                         Method{"auto", "double", "semi_implicit_euler"}));

}  // namespace
}  // namespace lockstep::turntable_test
