// Steps whose constraint systems are solved by oracles: to the residual asked for, and what that says of the sweeps.
#include "host/steppers/oracle_backend.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "host/error.hpp"
#include "host/report/measures.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "tests/command_line.hpp"

namespace lockstep::oracle_backend_test {
namespace {

Scene hard_scene(const std::string& name) {
  Scene scene = read_scene(name);
  replace_solver(scene.settings, Solver::gauss_seidel);
  scene.settings.precision = "double";
  return scene;
}

struct Stepper {
  Stepper(Scene scene, const std::string& oracle) {
    if (!oracle.empty()) {
      scene.settings.tolerance = 1e-11;
      scene.settings.iterations = 100'000;
    }
    const InitialState<double> state = compile<double>(scene);
    std::unique_ptr<Backend<double>> backend;
    if (oracle.empty())
      backend = std::make_unique<ReferenceBackend<double>>(state);
    else
      backend = std::make_unique<OracleBackend>(state, find_system_solver(oracle, 4));
    simulation = std::make_unique<Simulation<double>>(std::move(backend), state.params);
  }

  /// One more step, and how well its problem is solved.
  Residual step() {
    simulation->step();
    Backend<double>& backend = simulation->backend();
    const Buffers<double>& buffers = backend.download(measured_buffers(backend.features()));
    return residual(contact_system(buffers, simulation->counters()), 0x1p-53);
  }

  double distance(Stepper& other) {
    const Buffer wanted[] = {Buffer::motions};
    const auto& mine = simulation->backend().download(wanted).motions;
    const auto& others = other.simulation->backend().download(wanted).motions;
    double largest = 0;
    for (std::size_t i = 0; i < mine.size(); ++i) {
      for (int k = 0; k < 3; ++k)
        largest = std::max({largest, std::abs(mine[i].v[k] - others[i].v[k]), std::abs(mine[i].w[k] - others[i].w[k])});
    }
    return largest;
  }

  std::unique_ptr<Simulation<double>> simulation;
};

TEST(OracleBackend, LeavesTheResidualThatWasAskedFor) {
  for (const char* name : {"incline", "slide_to_roll", "box_stack", "pendulum_chain"}) {
    Stepper run(hard_scene(name), "auto");
    for (int i = 0; i < 20; ++i) EXPECT_LE(run.step().relative, 1.1e-11) << name << ", step " << i;
    EXPECT_EQ(static_cast<OracleBackend&>(run.simulation->backend()).unsolved().count, 0u) << name;
  }
}

// The first step from rest, where velocities are unique: sweeps come as near to the oracle as their residual is small.
// In a column ten high a defect at one contact moves what is above it; it counts up to a few dozen times.
TEST(OracleBackend, IsWhatSweepsApproach) {
  for (const char* name : {"incline", "box_stack"}) {
    Stepper exact(hard_scene(name), "auto");
    exact.step();
    std::vector<double> distances;
    for (const u32 iterations : {1u, 50u, 2000u}) {  // of which a first step has ten times as many
      Scene scene = hard_scene(name);
      scene.settings.iterations = iterations;
      Stepper swept(scene, "");
      const Residual left = swept.step();
      distances.push_back(swept.distance(exact));
      EXPECT_LE(distances.back(), 100 * left.relative * left.scale + 1e-9) << name << ", " << iterations;
      EXPECT_GE(distances.back(), 0.01 * left.defect_max - 1e-9) << name << ", " << iterations;
    }
    EXPECT_GT(distances[0], 1e-4) << name;
    EXPECT_LE(distances[2], 1e-2 * distances[0]) << name;
  }
}

// A ball sliding along x has one contact, whose friction is along a side of pyramid and box: all models agree.
TEST(OracleBackend, TakesSolversOfEveryModel) {
  Stepper exact(hard_scene("slide_to_roll"), "auto");
  for (int i = 0; i < 5; ++i) exact.step();
  for (const std::string& name : system_solver_names()) {
    const bool other_model = name == "ccp_apgd";
    const bool for_pyramids =
        name == "pyramid_lemke" || name == "pyramid_enumeration" || name == "pyramid_fischer_newton";
    const bool out_of_scope = (name.starts_with("pyramid_") && !for_pyramids) || name == "box_fischer_newton";
    if (other_model || out_of_scope) continue;
    Stepper run(hard_scene("slide_to_roll"), name);
    for (int i = 0; i < 5; ++i) run.step();
    EXPECT_LE(run.distance(exact), 1e-9) << name;
  }
  EXPECT_FALSE(find_system_solver("magic", 4));
}

TEST(OracleBackend, JointsAreThoseOfEveryModel) {
  Stepper cones(hard_scene("pendulum_chain"), "auto"), pyramids(hard_scene("pendulum_chain"), "pyramid_lemke"),
      boxes(hard_scene("pendulum_chain"), "box_baraff");
  for (int i = 0; i < 30; ++i) {
    cones.step();
    EXPECT_LE(pyramids.step().relative, 1e-10);
    EXPECT_LE(boxes.step().relative, 1e-10);
  }
  EXPECT_LE(pyramids.distance(cones), 1e-8);
  EXPECT_LE(boxes.distance(cones), 1e-8);
}

// Crosses, and the threads of screws.
TEST(OracleBackend, JointsOfTwoFramesAreThoseOfEveryModel) {
  for (const char* name : {"cardan_shaft", "screw_nut"}) {
    SCOPED_TRACE(name);
    Scene scene = hard_scene(name);
    for (JointDescription& joint : scene.joints) {
      joint.limited = false;
      joint.motor_force = joint.friction = 0;
    }
    scene.settings.iterations = 1000;
    Stepper swept(scene, ""), cones(scene, "auto"), pyramids(scene, "pyramid_lemke");
    for (int i = 0; i < 30; ++i) {
      EXPECT_LE(swept.step().relative, 1e-8);
      EXPECT_LE(cones.step().relative, 1e-10);
      EXPECT_LE(pyramids.step().relative, 1e-10);
    }
    EXPECT_LE(cones.distance(swept), 1e-6);
    EXPECT_LE(pyramids.distance(cones), 1e-8);
  }
}

// Of the nuts one slides and one sticks.
TEST(OracleBackend, EveryModelKnowsFrictionInJoints) {
  Scene scene = hard_scene("screw_nut");
  for (JointDescription& joint : scene.joints) joint.limited = false;
  scene.settings.iterations = 100;
  Stepper swept(scene, ""), cones(scene, "auto"), pyramids(scene, "pyramid_lemke"), boxes(scene, "box_baraff");
  for (int i = 0; i < 30; ++i) {
    EXPECT_LE(swept.step().relative, 1e-10);
    EXPECT_LE(cones.step().relative, 1e-10);
    EXPECT_LE(pyramids.step().relative, 1e-10);
    EXPECT_LE(boxes.step().relative, 1e-10);
  }
  EXPECT_LE(pyramids.distance(swept), 1e-8);
  EXPECT_LE(boxes.distance(swept), 1e-8);
  EXPECT_LE(cones.distance(swept), 1e-8);
}

// Hinges that bend one way only, actuators with springs and dry friction on the same wheel, loops with a motor.
TEST(OracleBackend, ConesTakeLimitsMotorsAndSprings) {
  for (const char* name : {"rag_doll", "governor", "screw_nut"}) {
    for (const char* solver : {"nsgs", "proximal_point"}) {
      SCOPED_TRACE(std::string(name) + ", " + solver);
      Scene scene = read_scene(name);
      replace_solver(scene.settings, *find_solver(solver));
      scene.settings.tolerance = 1e-6;
      const InitialState<double> state = compile<double>(scene);
      OracleBackend* backend = new OracleBackend(state, find_system_solver(solver, 4));
      Simulation<double> simulation(std::unique_ptr<Backend<double>>(backend), state.params);
      for (int i = 0; i < 20; ++i) simulation.step();
      EXPECT_EQ(backend->unsolved().count, 0u);
      const Buffers<double>& buffers = backend->download(measured_buffers(backend->features()));
      const Residual left = residual(contact_system(buffers, simulation.counters()), 0x1p-53);
      EXPECT_LE(left.defect_rms, 1.1e-6 * left.scale + 1e-14);
    }
  }
}

TEST(OracleBackend, TellsWhatItLeftUnsolved) {
  Scene scene = hard_scene("box_stack");
  scene.settings.tolerance = 1e-11;
  scene.settings.iterations = 3;
  const InitialState<double> state = compile<double>(scene);
  OracleBackend* backend = new OracleBackend(state, find_system_solver("nsgs", 4));
  Simulation<double> simulation(std::unique_ptr<Backend<double>>(backend), state.params);
  for (int i = 0; i < 2; ++i) simulation.step();
  EXPECT_EQ(backend->unsolved().count, 2u);
  EXPECT_GT(backend->unsolved().worst_residual, 1e-3);
  EXPECT_EQ(backend->unsolved().worst_stop, Stop::limit);
}

TEST_F(CommandLine, RunsWithAnOracle) {
  const nlohmann::json exact = report_of("box_stack --solver auto --steps 5");
  EXPECT_EQ(exact["solver"], "auto");
  EXPECT_EQ(exact["device"], "reference");
  EXPECT_EQ(exact["precision"], "double");
  EXPECT_EQ(exact["friction_model"], "cones");
  EXPECT_EQ(exact["substeps"], 1) << "the sub-steps are for solvers that sweep little";
  EXPECT_LE(exact["residual_max"], 1.1e-10);
  EXPECT_GT(report_of("box_stack --solver gauss_seidel --device reference --steps 5")["residual_max"], 1e-3);
  EXPECT_LE(report_of("incline --solver pyramid_lemke --directions 8 --steps 5")["residual_max"], 1e-10)
      << "down the slope is one of the directions";

  const std::string report = file("ccp.json").string();
  const Outcome relaxed = run("run incline --solver ccp_apgd --steps 5 --quiet --report " + report);
  EXPECT_EQ(relaxed.status, 1);
  EXPECT_NE(relaxed.err.find("ccp_apgd left 5 sub-steps unsolved (5 "), std::string::npos);
  EXPECT_GT(nlohmann::json::parse(read_file(report))["residual_max"], 1e-3);

  EXPECT_NE(run("run --help").out.find("pyramid_NAME"), std::string::npos);
}

TEST_F(CommandLine, RefusesOraclesInOneLine) {
  expect_refused("run box_stack --solver magic", 2, "unknown solver \"magic\"");
  expect_refused("run box_stack --solver auto --device cpu", 2, "--device: auto is an oracle");
  expect_refused("run box_stack --solver auto --precision float", 2, "/settings/precision: auto is an oracle");
  expect_refused("run box_stack --solver auto --friction-model patches", 2,
                 "/settings/friction_model: auto is an oracle");
  expect_refused("run particles_rest --solver auto", 2, "/settings/solver: auto is an oracle");
  expect_refused("run box_stack --solver auto --tolerance 0", 2, "/settings/tolerance: auto is an oracle");
  expect_refused("run box_stack --solver pyramid_lemke --directions 2", 2, "--directions");
  expect_refused("run pyramid100 --solver auto --steps 1 --quiet", 2, "40000 contacts are too many");
  expect_refused("run rover --solver pyramid_lemke --steps 1 --quiet", 2, "step 0, solve_constraints: joint ");
  expect_refused("run box_stack --solver auto --joint-solver direct", 2, "/settings/joint_solver: auto is an oracle");
  expect_refused("run bricard --solver pyramid_lemke --steps 1 --quiet", 2, "closed loop");
  expect_refused("check box_stack --solver auto", 2, "check: compares an OpenCL device with the reference, and auto");
}

}  // namespace
}  // namespace lockstep::oracle_backend_test
