// Scenes that are built at rest stay as they were built: ten seconds of the reference at their own settings.
#include <gtest/gtest.h>

#include "host/cases/rest.hpp"
#include "host/scene/read.hpp"

namespace lockstep::stacks_test {
namespace {

Scene ten_seconds_of(const std::string& name) {
  const Scene scene = read_scene(name);
  EXPECT_GE(scene.settings.steps * scene.settings.dt, 10 - 1e-9) << name;
  return scene;
}

// No body is seen a centimetre from its place; overlap is under half a millimetre on the mean and two at most.
void expect_at_rest(const RestMeasures& rest) {
  EXPECT_LT(rest.moved, 0.01);
  EXPECT_LT(rest.mean_depth, 0.5e-3);
  EXPECT_LT(rest.deepest_of_all, 2e-3);
  EXPECT_LT(rest.kinetic, 1e-3);
}

class StacksStayAtRest : public testing::TestWithParam<const char*> {};

TEST_P(StacksStayAtRest, ForTenSeconds) { expect_at_rest(measure_rest(ten_seconds_of(GetParam()))); }

INSTANTIATE_TEST_SUITE_P(All, StacksStayAtRest,
                         testing::Values("pyramid20", "wall", "box_stack", "box_stack20", "three_cubes", "card_house",
                                         "arch"),
                         [](const testing::TestParamInfo<const char*>& scene) { return std::string(scene.param); });

// Planks on edge, which lie on each other by narrow rims: faces become edges and back while they settle, and what
// trembles walks. They moved by 8 mm with one relaxing sweep and pairs that forgot what their lost contacts carried.
TEST(StacksStayAtRest, KaplaIsStillAfterTwentySeconds) {
  Scene scene = read_scene("kapla");
  scene.settings.steps = 2000;
  const RestMeasures rest = measure_rest(scene);
  EXPECT_LT(rest.moved, 3e-3);
  EXPECT_LT(rest.mean_depth, 0.3e-3);
  EXPECT_LT(rest.kinetic, 1e-5);
}

// 512 kg on top of a stack that begins with 1 kg.
TEST(StacksStayAtRest, MassRatioOf512) {
  const Scene scene = ten_seconds_of("mass_ratio");
  for (const RestMeasures& rest : {measure_rest(scene), measure_rest(scene, "double")}) {
    EXPECT_LT(rest.moved, 0.01);
    EXPECT_LT(rest.deepest_of_all, 4e-3);
  }
}

// A gram under a tonne, in 2048 sub-steps: one second.
TEST(StacksStayAtRest, MassRatioOfAMillion) {
  Scene scene = ten_seconds_of("two_cubes");
  scene.settings.steps = 60;
  for (const RestMeasures& rest : {measure_rest(scene), measure_rest(scene, "double")}) {
    EXPECT_LT(rest.moved, 0.01);
    EXPECT_LT(rest.mean_depth, 0.5e-3);
    EXPECT_LT(rest.deepest_of_all, 2e-3);
  }
}

// A card that leans at 25 degrees under a load has to be held at its upper edge, by up to tan(25) = 0.466 of the load.
// Of the outer ones it is the floor that holds them, by friction; the weight of the card that leans against them helps
// a little. Just above that rounding decides, for the cards move while they take up their load
// (docs/theory/solvers.md).
TEST(CardHouse, NeedsTheFrictionThatItsLeaningCardsAskFor) {
  Scene scene = read_scene("card_house");
  for (const u32 substeps : {16u, 32u, 48u}) {
    SCOPED_TRACE(substeps);
    scene.settings.substeps = substeps;
    scene.materials[0].friction = 0.6;
    EXPECT_LT(measure_rest(scene).moved, 0.01);
    scene.materials[0].friction = 0.45;
    EXPECT_GT(measure_rest(scene).moved, 0.1);
  }
}

}  // namespace
}  // namespace lockstep::stacks_test
