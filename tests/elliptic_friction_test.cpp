// Contacts that have more friction along an axis than across it: closed forms of slabs on planes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "host/cases/trial.hpp"
#include "host/scene/compile.hpp"
#include "host/scene/read.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::elliptic_friction_test {
namespace {

const double pi = std::acos(-1.0);
constexpr double gravity = 9.81, along = 0.6, across = 0.2;

// A thin slab with its axis of anisotropy along x of its shape, which `yaw` rotates about z, on a floor.
Scene slab(double yaw, Vector3 pull, Vector3 velocity, double dt) {
  return parse_scene(fmt::format(R"({{
      "description": "a slab with anisotropic friction", "gravity": [{}, {}, {}], "settings": {{"dt": {}, "iterations": 50}},
      "materials": [{{"name": "floor", "friction": 0.6}}, {{"name": "wood", "friction": 0.6, "friction_across": {}}}],
      "bodies": [
        {{"name": "ground", "type": "static", "shapes": [{{"type": "plane", "material": "floor"}}]}},
        {{"name": "slab", "density": 500, "position": [0, 0, 0.005], "velocity": [{}, {}, 0],
         "shapes": [{{"type": "box", "size": [0.4, 0.4, 0.01], "material": "wood",
                     "rotation": {{"axis": [0, 0, 1], "angle_deg": {}}}}}]}}]}})",
                                 pull[0], pull[1], pull[2], dt, across * across / along, velocity[0], velocity[1], yaw),
                     "elliptic_friction_test");
}

class EllipticFriction : public testing::TestWithParam<const char*> {
 protected:
  BodyState after(const Scene& scene, double duration) {
    Trial trial({.name = "gauss_seidel", .ladder = {}}, {}, GetParam(), std::nullopt);
    BodyState last = {};
    trial.run(scene, duration, [&](Seen& sample) {
      last = sample.body(1);
      residual_ = sample.measures().residual->relative;
      return true;
    });
    return last;
  }
  double residual_ = 0;
};

// Two materials combine to the geometric mean across as along: sqrt(0.6 * 0.2^2 / 0.6) = 0.2. What slides at (u, v) is
// slowed down by g (mu_1^2 u, mu_2^2 v) / |(mu_1 u, mu_2 v)|, so that u / u_0 = (v / v_0)^9 all the way.
TEST_P(EllipticFriction, DeflectsASlideTowardsTheSlipperyDirection) {
  const Scene scene = slab(0, {0, 0, -gravity}, {1, 1, 0}, 0.0005);
  double u = 1, v = 1;
  const double h = 1e-5;
  for (int i = 0; i < 10000; ++i) {  // of the equation itself, by the midpoint rule
    const auto slows = [&](double x, double y) {
      const double size = std::hypot(along * x, across * y);
      return std::pair(-gravity * along * along * x / size, -gravity * across * across * y / size);
    };
    const auto [a, b] = slows(u, v);
    const auto [c, d] = slows(u + h / 2 * a, v + h / 2 * b);
    u += h * c, v += h * d;
  }
  EXPECT_NEAR(u, std::pow(v, 9), 1e-6);
  const BodyState end = after(scene, 0.1);
  EXPECT_NEAR(end.v[0], u, 3e-3);
  EXPECT_NEAR(end.v[1], v, 3e-3);
  EXPECT_LT(residual_, 1e-4);
}

// On a slope of tan 0.4 it lies along its axis and slides across it, wherever shape and axis are turned to.
TEST_P(EllipticFriction, SticksAlongTheAxisOfAnisotropyAlone) {
  const double slope = std::atan(0.4), down = gravity * std::sin(slope), normal = gravity * std::cos(slope);
  for (const double yaw : {0.0, 90.0, 180.0}) {
    const bool lies_on_x = yaw != 90;
    const BodyState on_x = after(slab(yaw, {down, 0, -normal}, {0, 0, 0}, 0.005), 1);
    const BodyState on_y = after(slab(yaw, {0, down, -normal}, {0, 0, 0}, 0.005), 1);
    const double slides = down - across * normal;
    EXPECT_NEAR(on_x.v[0], lies_on_x ? 0 : slides, 0.01 * slides) << yaw;
    EXPECT_NEAR(on_y.v[1], lies_on_x ? slides : 0, 0.01 * slides) << yaw;
  }
  // between the two: it holds up to |S^-1 (pull)| = mu r_n
  const double edge = 1 / std::hypot(std::sqrt(0.5) / along, std::sqrt(0.5) / across);
  for (const double fraction : {0.97, 1.03}) {
    const double pull = fraction * edge * gravity * std::sqrt(0.5);
    const BodyState end = after(slab(0, {pull, pull, -gravity}, {0, 0, 0}, 0.005), 2);
    EXPECT_EQ(std::hypot(end.v[0], end.v[1]) > 1e-3, fraction > 1) << fraction;
  }
}

// Friction along one direction alone: 0 along the axis and 1 across it, as of a skate, or the other way round. What is
// pushed askew keeps its velocity in the one direction and is stopped by mu g in the other.
TEST_P(EllipticFriction, ActsAlongOneDirectionAlone) {
  for (const bool skate : {true, false}) {
    for (const double yaw : {0.0, 30.0, 90.0}) {
      Scene scene = slab(yaw, {0, 0, -gravity}, {0, 0, 0}, 0.001);
      for (Material& material : scene.materials) {
        if (material.name == "wood")
          material.friction = skate ? 0 : 1, material.further.friction_across = skate ? 1 : 0;
      }
      const double c = std::cos(yaw * pi / 180), s = std::sin(yaw * pi / 180), mu = std::sqrt(0.6);
      const Vector3 free = skate ? Vector3{c, s, 0} : Vector3{-s, c, 0}, stopped = {-free[1], free[0], 0};
      for (int i = 0; i < 3; ++i) scene.bodies[1].velocity[i] = 2 * free[i] + 1 * stopped[i];
      const auto component = [&](const Vector3& v, const Vector3& direction) {
        return v[0] * direction[0] + v[1] * direction[1];
      };
      const BodyState soon = after(scene, 0.05), late = after(scene, 0.5);
      EXPECT_NEAR(component(soon.v, free), 2, 1e-4) << yaw;
      EXPECT_NEAR(component(soon.v, stopped), 1 - mu * gravity * 0.05, 1e-2) << yaw;
      EXPECT_NEAR(component(late.v, free), 2, 1e-3) << yaw;
      EXPECT_NEAR(component(late.v, stopped), 0, 1e-3) << yaw;
      EXPECT_NEAR(late.w[2], 0, 1e-3) << yaw;
      EXPECT_LT(residual_, 2e-4);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Precisions, EllipticFriction, testing::Values("float", "double"));

Scene heap(const std::string& settings, const std::string& more) {
  return parse_scene(fmt::format(R"({{
    "description": "a heap with anisotropic friction",
    "settings": {{"dt": 0.005, "iterations": 4 {}}},
    "materials": [{{"name": "floor", "friction": 0.4, "friction_across": 0.7}},
                  {{"name": "wood", "friction": 0.5, "friction_across": 0.1 {}}}, {{"name": "plain", "friction": 0.6}}],
    "bodies": [
      {{"name": "ground", "type": "static", "shapes": [{{"type": "plane", "material": "floor"}}]}},
      {{"generator": "grid", "counts": [3, 3, 3], "spacing": [0.31, 0.33, 0.35],
       "bodies": [
         {{"name": "ball", "density": 800, "position": [0, 0, 0.12], "velocity": [1, 0.2, 0], "angular_velocity": [3, 1, 9],
          "shapes": [{{"type": "sphere", "radius": 0.1, "material": "wood"}}]}},
         {{"name": "box", "density": 500, "position": [0.2, 0.1, 0.2], "angular_velocity": [1, -2, 12],
          "shapes": [{{"type": "box", "size": [0.2, 0.15, 0.1], "material": "wood"}}]}},
         {{"name": "brick", "density": 500, "position": [0.2, 0.25, 0.3], "velocity": [1, 1, 0],
          "shapes": [{{"type": "box", "size": [0.1, 0.15, 0.1], "material": "plain"}}]}}]}}]}})",
                                 settings, more),
                     "elliptic_friction_test");
}

template <class real>
class EllipticTwins : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(EllipticTwins, Precisions);

TYPED_TEST(EllipticTwins, Agree) {
  const InitialState<TypeParam> state = compile<TypeParam>(heap("", ""));
  EXPECT_TRUE(has(state.features, Feature::elliptic_friction));
  expect_twins_agree(state, 20, all_launch_options());
  expect_twins_agree(compile<TypeParam>(heap(R"(, "solver": "small_steps", "substeps": 3)",
                                             R"(, "torsional_friction": 0.01, "rolling_friction": 0.002)")),
                     20, {DeviceOptions()});
  Scene rails = heap("", "");
  for (Material& material : rails.materials) {
    if (material.name == "floor") material.friction = 0;
    if (material.name == "wood") material.further.friction_across = 0;
  }
  expect_twins_agree(compile<TypeParam>(rails), 20, {DeviceOptions()});
  rails.materials[1].further.torsional_friction = 0.01;
  expect_twins_agree(compile<TypeParam>(rails), 20, {DeviceOptions()});
}

}  // namespace
}  // namespace lockstep::elliptic_friction_test
