// Contacts that stick by more than they slide with, against closed forms of a box on a slope.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "host/cases/trial.hpp"
#include "host/scene/compile.hpp"
#include "host/scene/read.hpp"

namespace lockstep::static_friction_test {
namespace {

constexpr double gravity = 9.81;

class StaticFriction : public testing::TestWithParam<const char*> {
 protected:
  // A box on a slope (gravity turns) that starts at `speed` downhill.
  BodyState after(double slope, double speed, double duration) {
    const Scene scene = parse_scene(fmt::format(R"({{
      "description": "a box on a slope", "gravity": [{}, 0, {}], "settings": {{"dt": 0.005, "iterations": 30}},
      "materials": [{{"name": "wood", "friction": 0.3, "static_friction": 0.5}}],
      "bodies": [
        {{"name": "ground", "type": "static", "shapes": [{{"type": "plane"}}]}},
        {{"name": "box", "density": 500, "position": [0, 0, 0.1], "velocity": [{}, 0, 0],
         "shapes": [{{"type": "box", "size": [0.6, 0.4, 0.2]}}]}}]}})",
                                                gravity * std::sin(slope), -gravity * std::cos(slope), speed),
                                    "static_friction_test");
    Trial trial({.name = "gauss_seidel", .ladder = {}}, {}, GetParam(), std::nullopt);
    BodyState last = {};
    trial.run(scene, duration, [&](Seen& sample) {
      last = sample.body(1);
      return true;
    });
    return last;
  }
};

// Between the two coefficients it stays where it lies, and slides on once it slides.
TEST_P(StaticFriction, SticksAtRestAndLetsSlideWhatSlides) {
  const double slope = std::atan(0.4), speeds_up = gravity * (std::sin(slope) - 0.3 * std::cos(slope));
  const BodyState lies = after(slope, 0, 5);
  EXPECT_NEAR(lies.x[0], 0, 1e-4);
  const BodyState slides = after(slope, 0.2, 1);
  EXPECT_NEAR(slides.v[0], 0.2 + speeds_up, 0.01 * speeds_up);
  // it gives way by itself: as what sticks up to stick_speed, 0.02/s of its bounding radius, then as what slides
  const double stick_speed = 0.02 * std::hypot(0.3, 0.2, 0.1);
  const double steep = std::atan(0.52);
  const auto gains = [&](double mu) { return gravity * (std::sin(steep) - mu * std::cos(steep)); };
  const double time_sticking = stick_speed / gains(0.5);
  EXPECT_NEAR(after(steep, 0, 1).v[0], stick_speed + gains(0.3) * (1 - time_sticking), 0.01);
}

// What slides on a gentle slope comes to rest as by the lower coefficient, and stays.
TEST_P(StaticFriction, CatchesWhatComesToRest) {
  const double slope = std::atan(0.25), slows = gravity * (0.3 * std::cos(slope) - std::sin(slope));
  const BodyState still = after(slope, 0.5, 3);
  EXPECT_NEAR(still.x[0], 0.25 / (2 * slows), 5e-3);
  EXPECT_NEAR(still.v[0], 0, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Precisions, StaticFriction, testing::Values("float", "double"));

Scene two_materials(const std::string& a, const std::string& b, const std::string& rule) {
  return parse_scene(fmt::format(R"({{"description": "two", "materials": [{{"name": "a", {}}}, {{"name": "b", {}}}],
    "material_pairs": [{}], "bodies": [{{"type": "static", "name": "ground", "shapes": [{{"type": "plane", "material": "a"}}]}},
      {{"name": "ball", "mass": 1, "shapes": [{{"type": "sphere", "radius": 1, "material": "b"}}]}}]}})",
                                 a, b, rule),
                     "static_friction_test");
}

// Coefficients meet in their geometric mean, rolling coefficients in the larger; rules override what they name.
TEST(FurtherFriction, OfTwoMaterialsIsWhatTheyCombineTo) {
  const std::string a = R"("friction": 0.2, "static_friction": 0.45, "torsional_friction": 0.01)";
  const std::string b = R"("friction": 0.8, "rolling_friction": 0.03, "torsional_friction": 0.004)";
  const InitialState<double> met = compile<double>(two_materials(a, b, ""));
  EXPECT_DOUBLE_EQ(met.buffers.material_pairs[1].friction, 0.4);
  EXPECT_DOUBLE_EQ(met.buffers.static_friction_pairs[1].friction, 0.6);
  EXPECT_EQ(met.buffers.static_friction_pairs[1].speed, 0);
  EXPECT_DOUBLE_EQ(met.buffers.static_friction_pairs[1].speed_share, 0.02);
  EXPECT_DOUBLE_EQ(met.buffers.angular_friction_pairs[1].torsion_radius, 0.01 / 0.4);
  EXPECT_DOUBLE_EQ(met.buffers.angular_friction_pairs[1].rolling_coefficient, 0.03);
  EXPECT_DOUBLE_EQ(met.buffers.angular_friction_pairs[0].rolling_coefficient, 0);
  EXPECT_DOUBLE_EQ(met.buffers.static_friction_pairs[3].friction, 0.8);
  const InitialState<double> ruled = compile<double>(two_materials(
      a, b,
      R"({"materials": ["b", "a"], "friction": 0.5, "restitution": 0, "static_friction": 0.7, "stick_speed": 0.02,
               "rolling_friction": 0})"));
  EXPECT_DOUBLE_EQ(ruled.buffers.static_friction_pairs[2].friction, 0.7);
  EXPECT_DOUBLE_EQ(ruled.buffers.static_friction_pairs[2].speed, 0.02);
  EXPECT_DOUBLE_EQ(ruled.buffers.angular_friction_pairs[2].rolling_coefficient, 0);
  EXPECT_DOUBLE_EQ(ruled.buffers.angular_friction_pairs[2].torsion_radius, 0.01 / 0.5);
  const InitialState<double> slick =
      compile<double>(two_materials(a, b, R"({"materials": ["a", "b"], "friction": 0, "restitution": 0})"));
  EXPECT_DOUBLE_EQ(slick.buffers.angular_friction_pairs[1].torsion_radius, 0);
  EXPECT_DOUBLE_EQ(slick.buffers.static_friction_pairs[1].friction, 0);
}

}  // namespace
}  // namespace lockstep::static_friction_test
