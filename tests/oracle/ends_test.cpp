// A small scene for each way in which a solve ends, and certificates that are checked.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cpu_reference/oracle/joints/contradiction.hpp"
#include "cpu_reference/oracle/lcp/certificate.hpp"
#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "host/error.hpp"
#include "host/report/measures.hpp"
#include "host/scene/read.hpp"
#include "host/scene/solid_body.hpp"
#include "host/simulation.hpp"
#include "host/steppers/oracles.hpp"
#include "host/steppers/stepper.hpp"
#include "include/lockstep/world.hpp"
#include "tests/command_line.hpp"
#include "tests/oracle/lcp_problems.hpp"

namespace lockstep::ends_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

Simulation<double> simulation_by(Scene scene, const std::string& solver) {
  replace_solver(scene.settings, find_solver(solver).value());
  const InitialState<double> state = compile<double>(scene);
  return {make_stepper(state, StepTarget()).backend, state.params};
}

double drift_of(Simulation<double>& simulation) {
  Backend<double>& backend = simulation.backend();
  const Buffers<double>& buffers = backend.download(measured_buffers(backend.features()));
  return measure(buffers, backend.sizes(), backend.features(), simulation.params(), simulation.counters())
      .joint_drift->separation;
}

u32 ended(const Unsolved& unsolved, Stop stop) { return unsolved.ended[static_cast<u32>(stop)]; }

// A bar of 2 m with a ball joint at each end; the second holds a point of the world that is 0.1 m too far out.
Scene stretched_bar() {
  Scene scene;
  scene.name = scene.source = "stretched_bar";
  scene.settings.stabilization = Stabilization::velocities;
  BodyDescription bar;
  bar.position = {0, 0, 1};
  bar.shapes.push_back({.kind = SHAPE_BOX, .half_extents = {1, 0.1, 0.1}});
  make_solid(bar, 500);
  scene.bodies.push_back(bar);
  for (const double end : {-1.0, 1.0}) {
    JointDescription joint;
    joint.kind = JOINT_BALL;
    joint.body_b = 0;
    joint.anchor_a = joint.anchor_b = {end, 0, 1};
    joint.reference_poses = ReferencePoses{.position_b = {end > 0 ? 0.1 : 0.0, 0, 1}};
    scene.joints.push_back(joint);
  }
  return scene;
}

const char* const of_joints[] = {"mixed_ldlt",        "mixed_sparse", "mixed_pcg", "mixed_ichol",
                                 "mixed_articulated", "auto",         "nsgs",      "admm"};

// Joints that contradict each other: said with a certificate, and the middle way is taken.
TEST(Ends, InfeasibleWhereJointsContradictEachOther) {
  for (const char* solver : of_joints) {
    SCOPED_TRACE(solver);
    Simulation<double> simulation = simulation_by(stretched_bar(), solver);
    for (int i = 0; i < 30; ++i) simulation.step();
    const Unsolved unsolved = simulation.unsolved();
    EXPECT_EQ(unsolved.count, 30u);
    EXPECT_EQ(ended(unsolved, Stop::infeasible), 30u) << in_words(solver, unsolved);
    EXPECT_EQ(unsolved.first_step, 0u);
    EXPECT_EQ(unsolved.first_stop, Stop::infeasible);
    const Buffer wanted[] = {Buffer::positions};
    EXPECT_NEAR(simulation.backend().download(wanted).positions[0].x, 0.05, 1e-3) << "both ends give way by half";
  }
}

// A linkage with joints that are more than it needs. They contradict each other by what they have drifted, a millionth:
// no proof, and no impulses without bounds either.
TEST(Ends, StalledWhereRedundantJointsHaveDrifted) {
  for (const char* solver : of_joints) {
    SCOPED_TRACE(solver);
    Simulation<double> simulation = simulation_by(read_scene("bricard"), solver);
    double drift = 0;
    for (int i = 0; i < 60; ++i) {
      simulation.step();
      drift = std::max(drift, drift_of(simulation));
    }
    const Unsolved unsolved = simulation.unsolved();
    EXPECT_LT(drift, 2e-4) << "of rods of 1 m";
    EXPECT_GT(ended(unsolved, Stop::stalled), 50u) << in_words(solver, unsolved);
    EXPECT_EQ(ended(unsolved, Stop::stalled), unsolved.count) << in_words(solver, unsolved);
    EXPECT_LT(unsolved.worst_residual, 2e-3);
    EXPECT_EQ(unsolved.first_step, 1u) << "at load nothing has drifted";
  }
}

// The residual of redundant joints is in the measure of the load: no impulses, however large, hide it.
TEST(Ends, NoImpulseHidesADefect) {
  for (const char* solver : of_joints) {
    SCOPED_TRACE(solver);
    Simulation<double> simulation = simulation_by(read_scene("bricard"), solver);
    for (int i = 0; i < 20; ++i) {
      const u32 before = simulation.unsolved().count;
      simulation.step();
      Backend<double>& backend = simulation.backend();
      const Buffers<double>& buffers = backend.download(measured_buffers(backend.features()));
      const Residual left = residual(contact_system(buffers, simulation.counters()), 0x1p-53);
      if (simulation.unsolved().count == before) {
        EXPECT_LE(left.relative, 1.1e-10) << i;
      }
    }
  }
}

TEST(Ends, AtItsLimitWhereIterationsAreTooFew) {
  Scene scene = read_scene("box_stack");
  replace_solver(scene.settings, find_solver("nsgs").value());
  scene.settings.iterations = 3;
  const InitialState<double> state = compile<double>(scene);
  Simulation<double> simulation(make_stepper(state, StepTarget()).backend, state.params);
  for (int i = 0; i < 3; ++i) simulation.step();
  EXPECT_EQ(simulation.unsolved().count, 3u);
  EXPECT_EQ(ended(simulation.unsolved(), Stop::limit), 3u);
  EXPECT_EQ(in_words("nsgs", simulation.unsolved()).find("nsgs left 3 sub-steps unsolved (3 at its limit), "), 0u);
}

// Sweeps with a tolerance, that it ends and that it does not.
TEST(Ends, AtItsLimitWhereSweepsDoNotSettle) {
  for (const u32 iterations : {3u, 5000u}) {
    Scene scene = read_scene("box_stack");
    replace_solver(scene.settings, Solver::gauss_seidel);
    scene.settings.precision = "double";
    scene.settings.substeps = 2;
    scene.settings.iterations = iterations;
    scene.settings.tolerance = 1e-3;
    World world(std::move(scene), {.device = "reference"});
    world.step(4);
    EXPECT_EQ(world.unsolved().count, iterations == 3 ? 8u : 0u) << "of two sub-steps a step";
    EXPECT_EQ(ended(world.unsolved(), Stop::limit), world.unsolved().count);
    if (iterations != 3) continue;
    EXPECT_EQ(in_words("gauss_seidel", world.unsolved()),
              "gauss_seidel left 8 sub-steps unsolved (8 at its limit), the worst in step 0 (limit): the last sweep "
              "changed velocities by more than 0.001 m/s");
  }
}

// A friction pyramid is out of the reach of sweeps over its rows: they have a zero diagonal. It has a solution.
TEST(Ends, StalledWhereTheMethodCannotAct) {
  Simulation<double> swept = simulation_by(read_scene("box_stack"), "pyramid_pgs");
  swept.step();
  EXPECT_EQ(ended(swept.unsolved(), Stop::stalled), 1u) << in_words("pyramid_pgs", swept.unsolved());
  Simulation<double> pivoted = simulation_by(read_scene("box_stack"), "pyramid_lemke");
  pivoted.step();
  EXPECT_EQ(pivoted.unsolved().count, 0u);
}

// A ball that gets faster than can be: the step counts once, and nothing after it.
TEST(Ends, BadWhereAStepFails) {
  for (const char* solver : {"gauss_seidel", "nsgs"}) {
    SCOPED_TRACE(solver);
    Scene scene;
    scene.name = scene.source = "ball";
    replace_solver(scene.settings, find_solver(solver).value());
    BodyDescription ball;
    ball.position = {0, 0, 1};
    ball.shapes.push_back({.kind = SHAPE_SPHERE, .radius = 0.3});
    make_solid(ball, 500);
    scene.bodies.push_back(ball);
    scene.settings.precision = "double";
    World world(std::move(scene), {.device = "reference"});
    world.step(1);
    world.set_velocity(world.bodies()[0], {{1e200, 0, 0}, {0, 0, 0}});
    EXPECT_THROW(world.step(1), Error);
    for (int i = 0; i < 3; ++i) EXPECT_THROW(world.step(2), Error);
    EXPECT_EQ(world.steps_done(), 1u);
    EXPECT_TRUE(world.contacts().empty());
    EXPECT_EQ(world.unsolved().count, 1u);
    EXPECT_EQ(ended(world.unsolved(), Stop::bad), 1u);
    EXPECT_EQ(world.unsolved().first_step, 1u);
    world.add(ball);  // nothing starts from what was cut short
    EXPECT_THROW(world.step(1), Error);
    EXPECT_EQ(world.steps_done(), 1u);
    EXPECT_EQ(world.unsolved().count, 1u);
  }
}

TEST_F(CommandLine, RunsThatEndUnsolvedSayWhereAndHow) {
  const Outcome outcome = run("run bricard --solver mixed_sparse --steps 60 --quiet");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("stalled), the first in step 1 (stalled), the worst in step "), std::string::npos)
      << outcome.err;
}

// ---- certificates

// Rows of two bodies that move along a line: v_1 - v_2, v_2, v_1; the third is the sum of the others.
oracle::GlobalConeProblem three_rows(double third, double shear) {
  oracle::GlobalConeProblem p;
  p.m = oracle::SparseMatrix(2, 2);
  p.m.setIdentity();
  const std::vector<Eigen::Triplet<double>> g = {{0, 0, 1.0}, {1, 0, -1.0}, {1, 1, 1.0}, {0, 2, 1.0}, {1, 2, shear}};
  p.g = oracle::SparseMatrix(2, 3);
  p.g.setFromTriplets(g.begin(), g.end());
  p.b = Eigen::Vector3d(0.3, -0.2, third);
  return p;
}

TEST(Certificates, OfJointsAreCheckedAgainstRounding) {
  const Eigen::Vector3d y(1, 1, -1);
  EXPECT_TRUE(oracle::proves_contradiction(three_rows(0.2, 0), y)) << "0.3 - 0.2 is not 0.2";
  EXPECT_TRUE(oracle::proves_contradiction(three_rows(0.2, 0), -1e-9 * y)) << "its size does not matter";
  EXPECT_FALSE(oracle::proves_contradiction(three_rows(0.3 - 0.2, 0), y)) << "they say a thing twice";
  EXPECT_FALSE(oracle::proves_contradiction(three_rows(0.2, 1e-8), y)) << "large velocities keep them";
  EXPECT_FALSE(oracle::proves_contradiction(three_rows(0.2, 0), Eigen::Vector3d(1, 1, -0.9)));
  EXPECT_FALSE(oracle::proves_contradiction(three_rows(0.2, 0), Eigen::Vector3d::Zero()));
  EXPECT_FALSE(oracle::proves_contradiction(three_rows(0.2, 0), Eigen::Vector3d(1, std::nan(""), -1)));
}

TEST(Certificates, OfComplementarityProblemsAreCheckedAgainstRounding) {
  using namespace oracle::lcp;
  Lcp p = {MatrixXd(2, 2), -VectorXd::Ones(2)};
  p.m << 1, -1, -1, 1;
  const VectorXd y = VectorXd::Ones(2);
  EXPECT_TRUE(proves_infeasible(p, y)) << "w_1 + w_2 = -2";
  EXPECT_FALSE(proves_infeasible(p, -y));
  EXPECT_FALSE(proves_infeasible(p, VectorXd::Unit(2, 0)));
  EXPECT_FALSE(proves_infeasible(p, VectorXd::Zero(2)));
  p.q[0] = 1;
  EXPECT_FALSE(proves_infeasible(p, y)) << "w_1 + w_2 = 0 does no harm";
  p.q[0] = -1;
  p.m(0, 0) = 1 + 1e-8;
  EXPECT_FALSE(proves_infeasible(p, y)) << "z of some 1e8 solves it";
  // between bounds z ends somewhere, and a free row may go either way
  p.m(0, 0) = 1;
  const VectorXd low = VectorXd::Zero(2);
  EXPECT_FALSE(proves_infeasible(p, low, VectorXd::Constant(2, 5), y));
  EXPECT_TRUE(proves_infeasible(p, VectorXd::Constant(2, -infinity), VectorXd::Constant(2, infinity), y));
}

// Matrices of no class, most of which no method promises to solve: where there is a solution none of them says that
// there is none.
TEST(Certificates, ARayIsNoProofByItself) {
  using namespace oracle::lcp;
  oracle::lcp::test::Random random(11);
  int rays = 0;
  for (int sample = 0; sample < 400; ++sample) {
    const MatrixXd m = random.matrix(4, 4);
    const Lcp p = {m, random.vector(4)};
    VectorXd z;
    const oracle::SolveReport all = enumeration(p, {.tolerance = 1e-10}, z);
    if (all.stop != Stop::solved) continue;
    for (const char* name : {"lemke", "keller", "baraff", "murty"}) {
      const auto solver = std::ranges::find(solvers(), name, &NamedSolver::name);
      const oracle::SolveReport one = solver->solve(p, {.tolerance = 1e-10, .iterations = 200}, z);
      EXPECT_NE(one.stop, Stop::infeasible) << name << ", sample " << sample << " has a solution";
      rays += one.stop == Stop::stalled;
    }
  }
  EXPECT_GT(rays, 50) << "they do not get everywhere";
}

}  // namespace
}  // namespace lockstep::ends_test
