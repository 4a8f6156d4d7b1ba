// Springs with dampers on joints are of second order by the trapezoidal rule.
#include <cmath>

#include "tests/joints/joint_scene.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::test::damper_order_test {
namespace {

struct Method {
  const char* name;
  bool direct = false;
  u32 substeps = 1;
};

std::ostream& operator<<(std::ostream& out, const Method& method) {
  return out << method.name << (method.direct ? ", direct" : "") << ", " << method.substeps;
}

class DamperOrder : public testing::TestWithParam<Method> {};

INSTANTIATE_TEST_SUITE_P(Methods, DamperOrder,
                         testing::Values(Method{"gauss_seidel"}, Method{"gauss_seidel", true},
                                         Method{"gauss_seidel", false, 4}, Method{"jacobi"}, Method{"nsgs"},
                                         Method{"reduced_nsgs"}));

// A body of 1 kg and 1 kg m^2 on a spring of 1 Hz with a tenth of the critical damping, let go 0.5 from where its
// weight rests.
Scene oscillator(JointKind kind, const Method& method, double h) {
  const double pi = 3.141592653589793;
  Scene scene = joint_scene({bare_body({0, 0, 0}, {1, 1, 1})}, {joint_of(kind, NONE, 0, {0, 0, 0})}, h);
  scene.name = scene.source = "oscillator";
  replace_solver(scene.settings, *find_solver(method.name));
  scene.settings.integrator = Integrator::trapezoidal;
  if (method.direct) scene.settings.joint_solver = JointSolver::direct;
  if (method.substeps > 1) scene.settings.substeps = method.substeps;
  const double stiffness = 4 * pi * pi, sag = kind == JOINT_SLIDER ? 9.81 / stiffness : 0;
  scene.joints[0].spring = JointSpring{.stiffness = stiffness, .damping = 0.4 * pi, .rest = sag - 0.5};
  return scene;
}

// x = x_0 e^-dt (cos wt + d / w sin wt), counted from where it rests.
TEST_P(DamperOrder, IsTwo) {
  const double pi = 3.141592653589793, d = 0.2 * pi, w = std::sqrt(4 * pi * pi - d * d), time = 0.2;
  const double exact = 0.5 * std::exp(-d * time) * (std::cos(w * time) + d / w * std::sin(w * time)) - 0.5;
  for (const JointKind kind : {JOINT_SLIDER, JOINT_HINGE}) {
    double before = 0;
    for (const u32 steps : {10u, 20u, 40u, 80u, 160u}) {
      World world(oscillator(kind, GetParam(), time / steps), in_double());
      world.step(steps);
      const double error = std::abs(world.state(world.joints()[0]).coordinate - exact);
      if (before > 0) {
        EXPECT_NEAR(std::log2(before / error), 2, 0.15) << name_of(kind) << ' ' << steps;
      }
      before = error;
    }
    EXPECT_LT(before, 1e-5) << name_of(kind);
  }
}

// However stiff, a damper stops what moves: the mean of the velocities alone would reverse it again and again.
TEST_P(DamperOrder, StiffOnesDoNotRing) {
  Scene scene = oscillator(JOINT_HINGE, GetParam(), 0.01);
  scene.joints[0].spring = JointSpring{.stiffness = 0, .damping = 1e4};
  scene.bodies[0].angular_velocity = {0, 0, 3};
  World world(scene, in_double());
  double before = 3;
  for (int i = 0; i < 5; ++i) {
    world.step();
    const double speed = world.state(world.joints()[0]).speed;
    EXPECT_LT(std::abs(speed), 0.1 * before + 1e-12) << i;
    before = std::abs(speed);
  }
}

}  // namespace
}  // namespace lockstep::test::damper_order_test
