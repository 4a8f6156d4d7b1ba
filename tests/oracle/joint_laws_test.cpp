// Springs, motors and limits of joints by oracles of each kind, against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "host/scene/read.hpp"
#include "include/lockstep/world.hpp"

namespace lockstep::joint_laws_test {
namespace {

constexpr double g = 9.81, degree = 3.14159265358979323846 / 180;

class JointLaws : public testing::TestWithParam<const char*> {
 protected:
  World world(const std::string& text) const { return World(parse_scene(text, "x.json"), {.solver = GetParam()}); }
};

// A load on a vertical spring: it sags by m g / k, whatever the step.
TEST_P(JointLaws, ASpringSagsByItsLoad) {
  World w = world(R"({"settings": {"dt": 0.005},
    "bodies": [{"name": "load", "mass": 3, "inertia": [0.1, 0.1, 0.1], "position": [0, 0, 2]}],
    "joints": [{"type": "slider", "bodies": ["world", "load"], "anchor": [0, 0, 2], "axis": [0, 0, 1],
                "spring": {"stiffness": 900, "damping": 40}}]})");
  w.step(800);
  EXPECT_NEAR(w.poses()[0].position[2], 2 - 3 * g / 900, 1e-9);
}

// A level arm of 2 kg, its centre 0.5 m from the hinge: 9.81 N m hold it.
std::string arm(const std::string& torque) {
  return R"({"settings": {"dt": 0.002},
    "bodies": [{"name": "arm", "mass": 2, "inertia": [0.01, 0.1667, 0.1667], "position": [0.5, 0, 0]}],
    "joints": [{"type": "hinge", "bodies": ["world", "arm"], "anchor": [0, 0, 0], "axis": [0, 1, 0],
                "motor": {"speed": 0, "max_torque": )" +
         torque + "}}]}";
}

double angle_of(World& w) {
  const Vector3 x = w.poses()[0].position;
  return std::atan2(-x[2], x[0]);
}

TEST_P(JointLaws, AMotorCarriesAnArmThatIsNotTooHeavy) {
  World w = world(arm("12"));
  w.step(50);
  EXPECT_NEAR(angle_of(w), 0, 1e-9);
}

// The angle after n steps of h: alpha h^2 n (n + 1) / 2, less what the arm loses by leaving the level.
TEST_P(JointLaws, AMotorThatIsTooWeakPushesWithAllItHas) {
  World w = world(arm("5"));
  w.step(50);
  const double alpha = (2 * g * 0.5 - 5) / (0.1667 + 2 * 0.25);
  EXPECT_NEAR(angle_of(w), alpha * 0.002 * 0.002 * 50 * 51 / 2, 1e-5);
}

TEST_P(JointLaws, AHeavyArmComesToRestAtItsLimit) {
  World w = world(R"({"settings": {"dt": 0.002},
    "bodies": [{"name": "arm", "mass": 100, "inertia": [1, 8.33, 8.33], "position": [0.5, 0, 0]}],
    "joints": [{"type": "hinge", "bodies": ["world", "arm"], "anchor": [0, 0, 0], "axis": [0, 1, 0],
                "limits_deg": [-30, 30]}]})");
  w.step(600);
  EXPECT_NEAR(angle_of(w), 30 * degree, 1e-9);
  EXPECT_LE(std::abs(w.velocities()[0].linear[2]), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(EachKind, JointLaws,
                         testing::Values("nsgs", "proximal_point", "admm", "mixed_ldlt", "impulse_based",
                                         "reduced_auto"),
                         [](const auto& tried) { return std::string(tried.param); });

}  // namespace
}  // namespace lockstep::joint_laws_test
