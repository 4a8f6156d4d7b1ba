// A step's constraint system written as an FCLIB file and read again has the error that the report gives.
#include "host/steppers/system_problem.hpp"

#include <gtest/gtest.h>

#include "cpu_reference/oracle/cone/whole.hpp"
#include "host/backends/reference_backend.hpp"
#include "host/error.hpp"
#include "host/problems/cone_file.hpp"
#include "host/record/whole_file.hpp"
#include "host/report/measures.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::system_problem_test {
namespace {

struct Step {
  ContactSystem system;
  Residual residual;
};

template <class real>
Step step_of(const Scene& scene, u32 steps) {
  const InitialState<real> state = compile<real>(scene);
  Simulation<real> simulation(std::make_unique<ReferenceBackend<real>>(state), state.params);
  for (u32 i = 0; i < steps; ++i) simulation.step();
  Backend<real>& backend = simulation.backend();
  const Buffers<real>& buffers = backend.download(measured_buffers(backend.features()));
  Step step = {contact_system(buffers, simulation.counters()), {}};
  step.residual = residual(step.system, sizeof(real) == 8 ? 0x1p-53 : 0x1p-24);
  return step;
}

template <class real>
Step step_of(const std::string& name, u32 steps, bool cones = true) {
  Scene scene = read_scene(name);
  if (cones) scene.settings.friction_model = FrictionModel::cones;
  return step_of<real>(scene, steps);
}

// Without what FCLIB has no rows for.
Scene with_free_joints(const std::string& name) {
  Scene scene = read_scene(name);
  for (JointDescription& joint : scene.joints) {
    joint.limited = false;
    joint.motor_force = joint.friction = 0;
  }
  return scene;
}

// Through a file and back.
ConeFile through_file(const SystemProblem& system, bool local) {
  const TemporaryFolder folder;
  const std::string path = folder.file("step.hdf5");
  replace_file(path, local ? encode_fclib(oracle::local_form(system.problem), "a step", system.impulses)
                           : encode_fclib(system.problem, "a step", system.impulses));
  return read_cone_file(path);
}

void expect_residual_of_report(const Step& step, double relative) {
  const SystemProblem system = problem_of(step.system, "test");
  for (const bool local : {false, true}) {
    const ConeFile file = through_file(system, local);
    ASSERT_TRUE(file.stored);
    const oracle::ConeError error = oracle::cone_error(file.problem, file.stored->r, file.stored->l);
    const double wanted = step.residual.relative + step.residual.model_error.value_or(0);
    EXPECT_NEAR(error.residual, wanted, relative * wanted + 1e-12);
    if (step.residual.model_error) continue;  // of patches the report has the scale of another problem
    EXPECT_NEAR(error.scale, step.residual.scale, relative * step.residual.scale);
    EXPECT_NEAR(error.defect_max, step.residual.defect_max, relative * step.residual.defect_max + 1e-12);
  }
}

TEST(SystemProblem, OfContactsHasTheReportsResidual) {
  expect_residual_of_report(step_of<float>("spheres_small", 90), 1e-6);
  expect_residual_of_report(step_of<double>("mass_ratio", 20), 1e-6);
  expect_residual_of_report(step_of<float>("kinematic_pusher", 60), 1e-6);
}

TEST(SystemProblem, OfPatchesHasTheResidualOfCones) {
  const Step step = step_of<float>("slabs", 30, false);
  ASSERT_TRUE(step.residual.model_error);
  expect_residual_of_report(step, 1e-6);
}

TEST(SystemProblem, OfJointsHasTheReportsResidual) {
  expect_residual_of_report(step_of<float>("chain64", 30), 1e-6);
  expect_residual_of_report(step_of<double>("bricard", 10), 1e-6);
  for (const char* name : {"cardan_shaft", "screw_nut", "air_table"}) {
    SCOPED_TRACE(name);
    Scene scene = with_free_joints(name);
    scene.settings.iterations = 2;
    expect_residual_of_report(step_of<double>(scene, 30), 1e-6);
  }
}

TEST(SystemProblem, CanBeSolvedFarBetterThanTheStepDid) {
  for (const char* name : {"dominoes", "box_stack"}) {
    const SystemProblem system = problem_of(step_of<float>(name, 40).system, name);
    const oracle::ConeProblem problem = oracle::local_form(system.problem);
    const double before = oracle::cone_error(problem, system.impulses.r, system.impulses.l).residual;
    const oracle::ConeSolution solution = oracle::solve_whole(problem, oracle::cone_solvers()[0], {.tolerance = 1e-9});
    EXPECT_LE(solution.error.residual, 1e-9) << name;
    EXPECT_GT(before, 1e-9) << name;
  }
}

TEST(SystemProblem, RefusesMotors) {
  try {
    problem_of(step_of<float>("rover", 5).system, "rover, step 5");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("rover, step 5: joint "), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace lockstep::system_problem_test
