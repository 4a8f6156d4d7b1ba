// Angular friction, rolling and torsional: twins, and closed forms of balls.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "host/cases/trial.hpp"
#include "host/scene/read.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::angular_friction_test {
namespace {

constexpr double radius = 0.1, gravity = 9.81;

// A solid ball on a plane that is tilted by `slope` (gravity turns).
Scene ball_on_plane(const std::string& material, double slope, const std::string& state, double dt = 0.002) {
  return parse_scene(fmt::format(R"({{
    "description": "a ball on a plane", "gravity": [{}, 0, {}],
    "settings": {{"dt": {}, "iterations": 50}},
    "materials": [{{"name": "all", {}}}],
    "bodies": [
      {{"name": "ground", "type": "static", "shapes": [{{"type": "plane"}}]}},
      {{"name": "ball", "mass": 2, "position": [0, 0, 0.1], {} "shapes": [{{"type": "sphere", "radius": 0.1}}]}}
    ]}})",
                                 gravity * std::sin(slope), -gravity * std::cos(slope), dt, material, state),
                     "angular_friction_test");
}

struct Variant {
  std::string solver, precision;
};

class AngularFriction : public testing::TestWithParam<Variant> {
 protected:
  // The ball at the end of so many seconds.
  BodyState after(Scene scene, double duration) {
    const std::string& solver = GetParam().solver;  // not bound in parts: clang 14 catches no such name
    Method method = {.name = solver, .ladder = {}};
    method.choose = [&](Settings& settings) {
      settings.solver = solver == "jacobi"        ? Solver::jacobi
                        : solver == "small_steps" ? Solver::small_steps
                                                  : Solver::gauss_seidel;
      if (solver == "small_steps") {
        settings.integrator = Integrator::semi_implicit_euler;
        settings.substeps = 4;
        settings.iterations = 4;
      }
    };
    Trial trial(method, {}, GetParam().precision, std::nullopt);
    BodyState last = {};
    trial.run(scene, duration, [&](Seen& sample) {
      last = sample.body(1);
      residual_ = sample.measures().residual ? sample.measures().residual->relative : 0;
      return true;
    });
    return last;
  }
  double rounding() const { return GetParam().precision == "float" ? 1 : 0; }
  double residual_ = 0;
};

// It rolls at v' = -5/7 g b / r, from the moment of rolling m g b and the friction that keeps it from slipping, and
// comes to rest.
TEST_P(AngularFriction, OfRollingStopsABall) {
  const std::string rolls = R"("velocity": [1, 0, 0], "angular_velocity": [0, 10, 0],)";
  const Scene scene = ball_on_plane(R"("friction": 0.5, "rolling_friction": 0.01)", 0, rolls);
  const double slows = 5.0 / 7 * gravity * 0.01 / radius, time = 0.5;
  const BodyState ball = after(scene, time);
  EXPECT_NEAR(ball.v[0], 1 - slows * time, 2e-3);
  EXPECT_NEAR(ball.w[1], ball.v[0] / radius, 2e-3 / radius);
  EXPECT_NEAR(ball.x[0], time - slows * time * time / 2, 3e-3);
  EXPECT_LT(residual_, 1e-4);
  const BodyState still = after(scene, 3);
  EXPECT_NEAR(std::hypot(still.v[0], still.v[1]), 0, 1e-5);
  EXPECT_NEAR(still.x[0], 1 / (2 * slows), 5e-3);
}

// On a slope it stays where tan(slope) < b / r, and rolls at 5/7 g (sin - b / r cos) where it is steeper.
TEST_P(AngularFriction, OfRollingStopsABallOnASlope) {
  const std::string material = R"("friction": 0.5, "rolling_friction": 0.01)";
  const BodyState at_rest = after(ball_on_plane(material, std::atan(0.09), ""), 2);
  EXPECT_NEAR(at_rest.x[0], 0, 2e-4);
  EXPECT_NEAR(at_rest.v[0], 0, 1e-4);
  const double slope = std::atan(0.15);
  const BodyState rolling = after(ball_on_plane(material, slope, ""), 1);
  const double speed = 5.0 / 7 * gravity * (std::sin(slope) - 0.1 * std::cos(slope));
  EXPECT_NEAR(rolling.v[0], speed, 0.01 * speed);
}

// A ball that spins on the spot: w' = -5/2 g t / r^2.
TEST_P(AngularFriction, OfTorsionStopsABall) {
  const Scene scene =
      ball_on_plane(R"("friction": 0.5, "torsional_friction": 0.002)", 0, R"("angular_velocity": [0, 0, 10],)");
  const double slows = 2.5 * gravity * 0.002 / (radius * radius);
  EXPECT_NEAR(after(scene, 1).w[2], 10 - slows, 0.01 * slows);
  const BodyState still = after(scene, 3);
  EXPECT_NEAR(still.w[2], 0, 1e-5);
  EXPECT_NEAR(std::hypot(still.x[0], still.x[1]), 0, 1e-5);
}

// Slip and torsion share the friction. With torsional friction mu r both rates of a ball that slides and spins are in
// one direction, 7/2 u' / u = 5/2 w' / w, so that u / u_0 = (w / w_0)^(7/5) all the way, whatever gravity does; and
// with the spin it slides longer.
TEST_P(AngularFriction, OfContensouIsSharedBySlipAndTorsion) {
  const std::string material = R"("friction": 0.3, "torsional_friction": 0.03)";
  const Scene scene = ball_on_plane(material, 0, R"("velocity": [1, 0, 0], "angular_velocity": [0, 0, 20],)", 0.0005);
  for (const double time : {0.05, 0.1, 0.15}) {
    const BodyState ball = after(scene, time);
    const double slip = ball.v[0] - radius * ball.w[1], angular_velocity = ball.w[2];
    ASSERT_GT(slip, 0.05);
    EXPECT_NEAR(slip, std::pow(angular_velocity / 20, 1.4), 5e-3) << time;
  }
  const Scene unspun = ball_on_plane(material, 0, R"("velocity": [1, 0, 0],)", 0.0005);
  const auto slip_of = [](const BodyState& ball) { return ball.v[0] - radius * ball.w[1]; };
  EXPECT_NEAR(slip_of(after(unspun, 0.05)), 1 - 3.5 * 0.3 * gravity * 0.05, 5e-3);
  EXPECT_GT(slip_of(after(scene, 0.05)), slip_of(after(unspun, 0.05)) + 0.1);
}

std::string name_of(const testing::TestParamInfo<Variant>& info) {
  return info.param.solver + "_" + info.param.precision;
}

INSTANTIATE_TEST_SUITE_P(Variants, AngularFriction,
                         testing::Values(Variant{"gauss_seidel", "double"}, Variant{"gauss_seidel", "float"},
                                         Variant{"jacobi", "double"}, Variant{"small_steps", "double"},
                                         Variant{"small_steps", "float"}),
                         name_of);

// Balls, boxes and cylinders in a heap, of materials that turn freely and that do not; they slide and spin.
Scene heap(const std::string& settings, const std::string& more = "") {
  return parse_scene(fmt::format(R"({{
    "description": "a heap with angular friction",
    "settings": {{"dt": 0.005, "iterations": 4 {}}},
    "materials": [{{"name": "free", "friction": 0.4}},
                  {{"name": "rolls", "friction": 0.5, "rolling_friction": 0.01, "static_friction": 0.8}},
                  {{"name": "spins", "friction": 0.6, "torsional_friction": 0.02}},
                  {{"name": "ice", "friction": 0}}],
    "bodies": [
      {{"name": "ground", "type": "static", "shapes": [{{"type": "plane", "material": "spins"}}]}},
      {{"generator": "grid", "counts": [3, 3, 3], "spacing": [0.41, 0.43, 0.35],
       "bodies": [
         {{"name": "ball", "density": 800, "position": [0, 0, 0.12], "velocity": [1, 0.2, 0], "angular_velocity": [3, 1, 9],
          "shapes": [{{"type": "sphere", "radius": 0.1, "material": "rolls"}}]}},
         {{"name": "box", "density": 500, "position": [0.2, 0.1, 0.2], "angular_velocity": [1, -2, 12],
          "shapes": [{{"type": "box", "size": [0.2, 0.15, 0.1], "material": "spins"}}]}},
         {{"name": "drum", "density": 500, "position": [0.1, 0.25, 0.2], "angular_velocity": [0, 6, 2],
          "shapes": [{{"type": "cylinder", "radius": 0.06, "length": 0.12, "material": "free"}}]}},
         {{"name": "slider", "density": 500, "position": [0.3, 0.3, 0.12], "velocity": [0, -1, 0],
          "shapes": [{{"type": "sphere", "radius": 0.05, "material": "ice"}}]}}]}}{}]}})",
                                 settings, more),
                     "angular_friction_test");
}

template <class real>
class AngularFrictionTwins : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(AngularFrictionTwins, Precisions);

TYPED_TEST(AngularFrictionTwins, AgreeHoweverTheStepIsLaunched) {
  const InitialState<TypeParam> state = compile<TypeParam>(heap(""));
  EXPECT_TRUE(has(state.features, Feature::angular_friction));
  EXPECT_TRUE(has(state.features, Feature::static_friction));
  expect_twins_agree(state, 25, all_launch_options());
}

TYPED_TEST(AngularFrictionTwins, AgreeByEverySolver) {
  for (const char* settings : {R"(, "solver": "jacobi")", R"(, "solver": "small_steps", "substeps": 3)",
                               R"(, "tolerance": 1e-5)", R"(, "integrator": "trapezoidal", "broad_phase": "bvh")"})
    expect_twins_agree(compile<TypeParam>(heap(settings)), 20, {DeviceOptions()});
}

// Moments wait with the impulses of sleepers; a box that stands beside the heap is hit, and wakes.
TYPED_TEST(AngularFrictionTwins, AgreeWhereSomeSleep) {
  const InitialState<TypeParam> state =
      compile<TypeParam>(heap(R"(, "sleeping": {"after": 0.02})", R"(, {"density": 500, "position": [1.15, -0.12, 0.1],
                              "shapes": [{"type": "box", "size": [0.2, 0.2, 0.2], "material": "rolls"}]})"));
  ReferenceBackend<TypeParam> backend(state);
  u32 most = 0, woken = 0;
  for (int i = 0; i < 60; ++i) {
    step(backend, state.params);
    most = std::max(most, backend.buffers().counters[COUNTER_ASLEEP]);
    woken += (backend.buffers().counters[COUNTER_STATUS] & STATUS_WOKEN) != 0 ? 1u : 0u;
  }
  EXPECT_GT(most, 0u);
  EXPECT_GT(woken, 0u);
  EXPECT_GT(backend.buffers().slept_moments.size(), 0u);
  expect_twins_agree(state, 60, {DeviceOptions()});
}

// Balls alone: the kernels know inertias of one number.
TYPED_TEST(AngularFrictionTwins, AgreeOfCentralContacts) {
  Scene scene = heap("");
  std::erase_if(scene.bodies, [](const BodyDescription& body) {
    return body.name.starts_with("box") || body.name.starts_with("drum");
  });
  const InitialState<TypeParam> state = compile<TypeParam>(scene);
  ASSERT_FALSE(has(state.features, Feature::general_contacts));
  expect_twins_agree(state, 25, all_launch_options());
}

// What no material asks for is not there.
TEST(AngularFriction, CostsNothingWhereNoneIsAskedFor) {
  Scene scene = heap("");
  for (Material& material : scene.materials) material.further = {};
  const InitialState<float> state = compile<float>(scene);
  EXPECT_FALSE(has(state.features, Feature::angular_friction));
  EXPECT_FALSE(has(state.features, Feature::static_friction));
  EXPECT_TRUE(state.buffers.angular_friction_blocks.empty());
  EXPECT_TRUE(state.buffers.static_friction_blocks.empty());
}

}  // namespace
}  // namespace lockstep::angular_friction_test
