// The device's solvers along a gradient against the oracle of the same model: where the convex problem has one answer
// in velocities, both find it.
#include <gtest/gtest.h>

#include <memory>

#include "host/error.hpp"
#include "host/report/measures.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "host/steppers/oracle_backend.hpp"

namespace lockstep::gradient_descent_test {
namespace {

Buffers<double> last_of(std::unique_ptr<Backend<double>> backend, const StepParams<double>& params, u32 steps) {
  Simulation<double> simulation(std::move(backend), params);
  for (u32 i = 0; i < steps; ++i) simulation.step();
  Backend<double>& end = simulation.backend();
  return end.download(measured_buffers(end.features()));
}

Buffers<double> by_oracle(Scene scene, u32 steps) {
  replace_solver(scene.settings, Solver::gauss_seidel);
  scene.settings.joint_solver = JointSolver::sweeps;  // close joints as descent does
  scene.settings.tolerance = 1e-13;
  scene.settings.iterations = 200'000;
  const InitialState<double> state = compile<double>(scene);
  return last_of(std::make_unique<OracleBackend>(state, find_system_solver("ccp_apgd", 4)), state.params, steps);
}

Buffers<double> by_descent(Scene scene, u32 steps) {
  replace_solver(scene.settings, Solver::accelerated_gradient);
  scene.settings.tolerance = 0;
  scene.settings.iterations = 20'000;
  const InitialState<double> state = compile<double>(scene);
  return last_of(std::make_unique<ReferenceBackend<double>>(state), state.params, steps);
}

// Sliding and sticking boxes, a stack, a heap that falls, hinges and contacts together.
TEST(GradientDescent, EndsWhereTheOracleDoes) {
  const std::pair<const char*, u32> scenes[] = {
      {"incline", 5}, {"box_stack", 2}, {"slide_to_roll", 10}, {"wrecking_ball", 2}};
  for (const auto& [name, steps] : scenes) {
    Scene scene = read_scene(name);
    scene.settings.geometric_stiffness = false;  // what it adds follows from impulses, which agree less well
    const Buffers<double> oracle = by_oracle(scene, steps), descent = by_descent(scene, steps);
    ASSERT_EQ(oracle.motions.size(), descent.motions.size());
    double fastest = 0;
    for (std::size_t i = 0; i < oracle.motions.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(descent.motions[i].v[k], oracle.motions[i].v[k], 1e-8) << name << ", body " << i;
        EXPECT_NEAR(descent.motions[i].w[k], oracle.motions[i].w[k], 1e-8) << name << ", body " << i;
        fastest = std::max(fastest, std::abs(oracle.motions[i].v[k]));
      }
    }
    EXPECT_GT(fastest, std::string(name) == "box_stack" ? -1 : 1e-2) << name;
  }
}

}  // namespace
}  // namespace lockstep::gradient_descent_test
