#include <gtest/gtest.h>

#include "host/report/measures.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::joint_residual_test {
namespace {

Residual residual_after(const Scene& scene, u32 steps) {
  const InitialState<double> state = compile<double>(scene);
  const Counters none = {};
  return *measure(after_steps<double>(scene, steps), state.sizes, state.features, state.params, none).residual;
}

Scene chain(u32 links, u32 iterations) {
  std::vector<BodyDescription> bodies;
  std::vector<JointDescription> joints;
  for (u32 i = 0; i < links; ++i) {
    bodies.push_back(bare_body({0.5 + i, 0, 0}, {0.05, 0.1, 0.1}));
    joints.push_back(joint_of(JOINT_BALL, i == 0 ? NONE : i - 1, i, {1.0 * i, 0, 0}));
  }
  Scene scene = joint_scene(bodies, joints, 1.0 / 240);
  scene.settings.iterations = iterations;
  return scene;
}

// More sweeps, less defect: down to rounding.
TEST(JointResidual, FallsToRounding) {
  const Residual one = residual_after(chain(8, 1), 5), many = residual_after(chain(8, 3000), 5);
  EXPECT_GT(one.relative, 1e-3);
  EXPECT_TRUE(one.worst_is_joint);
  EXPECT_LT(many.relative, 1e-10);
}

// One solve satisfies a joint alone, whatever it is: locked rows, motor, limits and springs agree with their law.
TEST(JointResidual, OfOneJointIsRounding) {
  for (u32 seed = 0; seed < 40; ++seed) {
    Scene scene = one_random_joint(seed);
    if (seed % 2 == 1) scene = with_small_steps(scene, 1);
    if (seed % 4 == 0) scene.settings.integrator = Integrator::trapezoidal;
    EXPECT_LT(residual_after(scene, 1).relative, 1e-9) << seed;
  }
}

// A velocity that is off by so much is reported as so much, in m/s.
TEST(JointResidual, DefectIsTheVelocityThatIsLeft) {
  const Scene scene = joint_scene({bare_body({0, 0, 0})}, {joint_of(JOINT_BALL, NONE, 0, {0, 0, 0})}, 1.0 / 240);
  const InitialState<double> state = compile<double>(scene);
  Buffers<double> b = after_steps<double>(scene, 1);
  b.motions[0].v[1] += 0.25;
  const Counters none = {};
  const Residual r = *measure(b, state.sizes, state.features, state.params, none).residual;
  EXPECT_NEAR(r.defect_max, 0.25, 1e-12);
}

}  // namespace
}  // namespace lockstep::test::joint_residual_test
