// Impacts of several contacts in one step: Newton's law with Moreau's reading of it keeps what a common e promises.
#include <gtest/gtest.h>

#include <random>

#include "host/cases/trial.hpp"
#include "host/scene/read.hpp"

namespace lockstep {
namespace {

// Two balls of 1 kg, no gravity: the lower one has just left the ground at 1 m/s when the upper one, at 3 m/s, meets
// it.
Scene met_on_the_way_up(double e) {
  Scene scene = parse_scene(R"({
    "description": "a ball leaves the ground, and another one comes down on it", "gravity": [0, 0, 0],
    "settings": {"dt": 0.01, "iterations": 100},
    "materials": [{"name": "all", "friction": 0}],
    "bodies": [
      {"name": "ground", "type": "static", "shapes": [{"type": "plane"}]},
      {"name": "lower", "mass": 1, "position": [0, 0, 0.5], "velocity": [0, 0, 1],
       "shapes": [{"type": "sphere", "radius": 0.5}]},
      {"name": "upper", "mass": 1, "position": [0, 0, 1.5], "velocity": [0, 0, -3],
       "shapes": [{"type": "sphere", "radius": 0.5}]}
    ]})",
                            "impacts_test");
  scene.materials[0].restitution = e;
  return scene;
}

struct Case {
  double e;
  Integrator integrator;
  std::string precision;
};

class Impacts : public testing::TestWithParam<Case> {};

// The law at both contacts: the balls part at 4 e, and the lower one comes to the ground at e. With e = 1 that is all
// the energy there was; had the lower one been stopped at the ground instead, it would be 8 J of 5.
TEST_P(Impacts, OfSeveralContactsGiveNoEnergy) {
  const auto [e, integrator, precision] = GetParam();
  Scene scene = met_on_the_way_up(e);
  scene.settings.integrator = integrator;
  const Method hard = {.name = "gauss_seidel", .ladder = {}};
  Trial trial(hard, {}, precision, std::nullopt);
  std::vector<double> lower, upper;
  trial.run(scene, 0.02, [&](Seen& now) {
    lower.push_back(now.body(1).v[2]);
    upper.push_back(now.body(2).v[2]);
    return true;
  });
  ASSERT_EQ(lower.size(), 3u);
  EXPECT_NEAR(lower[1], -e, 1e-5);
  EXPECT_NEAR(upper[1], 3 * e, 1e-5);
  EXPECT_NEAR(lower[2], e * e, 1e-5);  // and bounces
  EXPECT_NEAR(upper[2], 3 * e, 1e-5);
}

// 64 balls that all touch, with velocities at random: in one step the energy stays with e = 1, and falls below.
TEST(Impacts, OfALatticeKeepTheEnergyThatTheyPromise) {
  Scene scene = parse_scene(R"({
    "description": "a lattice of balls that touch", "gravity": [0, 0, 0],
    "settings": {"dt": 0.001, "iterations": 2000, "precision": "double"},
    "materials": [{"name": "all", "friction": 0}],
    "bodies": [{"generator": "grid", "counts": [4, 4, 4], "spacing": [1, 1, 1],
                "bodies": [{"name": "ball", "mass": 1, "shapes": [{"type": "sphere", "radius": 0.5}]}]}]})",
                            "impacts_test");
  std::mt19937 random(1);
  for (BodyDescription& ball : scene.bodies)
    for (double& v : ball.velocity) v = static_cast<double>(random()) / 2147483648.0 - 1;
  const Method hard = {.name = "gauss_seidel", .ladder = {}};
  for (const double e : {1.0, 0.7, 0.3}) {
    scene.materials[0].restitution = e;
    Trial trial(hard, {}, "double", std::nullopt);
    double before = 0, after = 0;
    trial.run(scene, 0.001, [&](Seen& now) {
      (now.time == 0 ? before : after) = now.measures().energy();
      return true;
    });
    if (e == 1)
      EXPECT_NEAR(after, before, 1e-9 * before);
    else
      EXPECT_LT(after, 0.98 * before) << e;
    EXPECT_GT(after, 0.99 * e * e * before) << e;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Impacts,
                         testing::Values(Case{1, Integrator::semi_implicit_euler, "float"},
                                         Case{1, Integrator::trapezoidal, "double"},
                                         Case{0.5, Integrator::semi_implicit_euler, "double"},
                                         Case{0.5, Integrator::trapezoidal, "float"}),
                         [](const testing::TestParamInfo<Case>& one) { return "case" + std::to_string(one.index); });

}  // namespace
}  // namespace lockstep
