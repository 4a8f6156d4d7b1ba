// Contacts, joints and bounded rows solved as sub-blocks: to the residual of the whole, and to the solution of solvers
// that take joints out.
#include <gtest/gtest.h>

#include "cpu_reference/oracle/cone/whole.hpp"
#include "cpu_reference/oracle/joints/joint_solver.hpp"
#include "cpu_reference/oracle/joints/mixed.hpp"
#include "host/report/measures.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "host/steppers/oracle_backend.hpp"
#include "tests/command_line.hpp"
#include "tests/oracle/cone_problems.hpp"

namespace lockstep::mixed_solvers_test {
namespace {

using Eigen::VectorXd;
using oracle::GlobalConeProblem;
using oracle::MixedImpulses;
using oracle::MixedProblem;
using oracle::MixedSolver;
using oracle::SparseMatrix;
using oracle::Stop;

constexpr oracle::SolveLimits limits = {.tolerance = 1e-10, .iterations = 100'000, .seconds = 60};

MixedProblem without_bounds(GlobalConeProblem cones) {
  const Eigen::Index n = cones.m.rows();
  return {std::move(cones), SparseMatrix(n, 0), {}};
}

// Bodies on uneven ground, each hung on the next by a ball joint halfway; with `rings` the first on the last as well.
GlobalConeProblem linked_heap(std::uint32_t bodies, double mu, unsigned seed, bool rings) {
  GlobalConeProblem problem = oracle::random_heap(bodies, 3 * bodies, mu, seed);
  std::vector<Eigen::Triplet<double>> g;
  int row = 0;
  problem.first = {0};
  const std::uint32_t links = rings ? bodies : bodies - 1;
  for (std::uint32_t k = 0; k < links; ++k) {
    const std::uint32_t pair[] = {k, (k + 1) % bodies};
    for (const int side : {0, 1}) {
      const double sign = side == 0 ? 1 : -1;
      const Eigen::Vector3d arm(0.5 * sign, 0.1 * k, 0);
      for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d direction = Eigen::Vector3d::Unit(i), moment = arm.cross(direction);
        g.emplace_back(6 * pair[side] + i, row + i, sign);
        for (int a = 0; a < 3; ++a) g.emplace_back(6 * pair[side] + 3 + a, row + i, sign * moment[a]);
      }
    }
    row += 3;
    problem.first.push_back(row);
  }
  problem.g = SparseMatrix(6 * bodies, row);
  problem.g.setFromTriplets(g.begin(), g.end());
  problem.b = VectorXd::LinSpaced(row, -0.1, 0.1);
  return problem;
}

// No solver of cones has seen what the others have: W, and the joints taken out.
TEST(MixedSolvers, AgreeWithSolversThatTakeJointsOut) {
  for (const bool rings : {false, true}) {
    for (const unsigned seed : {1u, 2u, 3u}) {
      const MixedProblem problem = without_bounds(linked_heap(6, 0.3, seed, rings));
      const oracle::ConeProblem local = oracle::local_form(problem.cones);
      const oracle::ConeSolution wanted = oracle::solve_whole(local, *oracle::find_cone_solver("auto"), limits);
      ASSERT_LE(wanted.error.residual, limits.tolerance);
      const VectorXd u = local.w.times(wanted.r) + local.joints->v * wanted.l + local.q;
      for (const MixedSolver& solver : oracle::mixed_solvers()) {
        SCOPED_TRACE(solver.name);
        MixedImpulses x;
        const oracle::SolveReport report = oracle::solve_mixed(problem, solver, limits, x);
        EXPECT_EQ(report.stop, Stop::solved);
        const oracle::ConeError error = oracle::cone_error(local, x.r, x.l);
        EXPECT_LE(error.residual, 1.01 * limits.tolerance);
        EXPECT_NEAR(error.residual, report.residual, 1e-3 * report.residual + 1e-14) << "it measures as all others do";
        EXPECT_LE((local.w.times(x.r) + local.joints->v * x.l + local.q - u).norm(), 1e-7 * u.norm());
      }
    }
  }
}

TEST(MixedSolvers, AreGaussSeidelWithoutJoints) {
  const MixedProblem problem = without_bounds(oracle::random_heap(5, 12, 0.4, 7));
  const oracle::ConeProblem local = oracle::local_form(problem.cones);
  VectorXd r;
  const oracle::SolveLimits few = {.tolerance = 1e-30, .iterations = 10, .seconds = 60};
  oracle::nsgs(local, few, r);
  for (const MixedSolver& solver : oracle::mixed_solvers()) {
    MixedImpulses x;
    const oracle::SolveReport report = oracle::solve_mixed(problem, solver, few, x);
    EXPECT_EQ(report.iterations, 10u) << solver.name;
    EXPECT_LE((x.r - r).norm(), 1e-14 * r.norm()) << solver.name;
  }
}

TEST(MixedSolvers, SolveNothingAndJointsAlone) {
  GlobalConeProblem cones = linked_heap(6, 0.3, 1, true);
  cones.h = SparseMatrix(cones.m.rows(), 0);
  cones.w = cones.mu = VectorXd();
  for (const MixedSolver& solver : oracle::mixed_solvers()) {
    MixedImpulses x;
    const oracle::SolveReport report = oracle::solve_mixed(without_bounds(cones), solver, limits, x);
    EXPECT_EQ(report.stop, Stop::solved) << solver.name;
    EXPECT_LE(report.iterations, 3u) << solver.name;
    GlobalConeProblem nothing = oracle::random_heap(2, 0, 0.3, 1);
    EXPECT_EQ(oracle::solve_mixed(without_bounds(nothing), solver, limits, x).stop, Stop::solved) << solver.name;
    nothing.dimension = 2;
    EXPECT_THROW(oracle::solve_mixed(without_bounds(nothing), solver, limits, x), std::runtime_error);
  }
}

// Of one row of mobility e: driven, held by its bounds, hard and soft, and on a spring.
TEST(BoundedLaw, IsThatOfMotorsLimitsAndSprings) {
  constexpr double far = 1e30;
  const oracle::BoundedLaw motor = {.speed = 2, .max_impulse = 3, .slowest = -far, .fastest = far, .mobility = 1};
  EXPECT_DOUBLE_EQ(motor.velocity(0, 1), 2);
  EXPECT_DOUBLE_EQ(motor.velocity(-4, 1), -1) << "as far as it reaches";
  EXPECT_DOUBLE_EQ(motor.velocity(9, 0.5), 7.5) << "and it brakes";
  const oracle::BoundedLaw limits_of = {.slowest = -1, .fastest = 4, .mobility = 1};
  EXPECT_DOUBLE_EQ(limits_of.velocity(3, 1), 3);
  EXPECT_DOUBLE_EQ(limits_of.velocity(-3, 1), -1);
  EXPECT_DOUBLE_EQ(limits_of.velocity(6, 1), 4);
  // u - fastest + bound_compliance r = 0 and u = q + e r
  const oracle::BoundedLaw soft = {.slowest = -1, .fastest = 4, .bound_compliance = 0.25, .mobility = 1};
  const double u = soft.velocity(6, 1), r = (u - 6) / 1;
  EXPECT_NEAR(u - 4 + 0.25 * r, 0, 1e-15);
  const oracle::BoundedLaw spring = {.slowest = 1, .fastest = 1, .spring_compliance = 0.5, .mobility = 1};
  const double v = spring.velocity(3, 2), push = (v - 3) / 2;
  EXPECT_NEAR(v - 1 + 0.5 * push, 0, 1e-15);
}

// Scenes as they are, with motors, limits and springs: the residual asked for is that of the report. Where contacts are
// redundant the last digits are out of reach of sweeps; what rounding makes of a body that falls freely is no residual.
TEST(MixedSolvers, SolveStepsOfScenes) {
  const std::pair<const char*, double> scenes[] = {
      {"rover", 1e-5},         {"rag_doll", 1e-6},       {"sweeper", 1e-6},         {"capstan", 1e-4},
      {"governor", 1e-10},     {"slider_crank", 1e-10},  {"squeezer", 1e-10},       {"screw_nut", 1e-10},
      {"cardan_shaft", 1e-10}, {"hanging_chain", 1e-10}, {"pendulum_chain", 1e-10}, {"chain64", 1e-10}};
  for (const auto& [name, tolerance] : scenes) {
    for (const char* solver : {"mixed_ldlt", "mixed_sparse", "mixed_articulated"}) {
      SCOPED_TRACE(std::string(name) + ", " + solver);
      Scene scene = read_scene(name);
      replace_solver(scene.settings, *find_solver(solver));
      scene.settings.tolerance = tolerance;
      const InitialState<double> state = compile<double>(scene);
      auto* backend = new OracleBackend(state, find_system_solver(solver, 4));
      Simulation<double> simulation(std::unique_ptr<Backend<double>>(backend), state.params);
      for (int i = 0; i < 20; ++i) {
        simulation.step();
        const Buffers<double>& buffers = backend->download(measured_buffers(backend->features()));
        const Residual left = residual(contact_system(buffers, simulation.counters()), 0x1p-53);
        ASSERT_LE(left.defect_rms, 1.1 * tolerance * left.scale + 1e-14) << "step " << i;
      }
      EXPECT_EQ(backend->unsolved().count, 0u);
    }
  }
}

TEST_F(CommandLine, SolvesJointsSeparately) {
  EXPECT_LE(report_of("slider_crank --solver mixed_ldlt --steps 30 --tolerance 1e-9")["residual_max"], 1.1e-9);
  const std::string problem = file("chain.hdf5").string();
  ASSERT_EQ(run("export pendulum_chain --at 5 -o " + problem).status, 0);
  for (const char* name : {"mixed_ldlt", "mixed_sparse", "mixed_pcg", "mixed_ichol", "mixed_articulated"})
    EXPECT_EQ(run("solve " + problem + " --tolerance 1e-10 --quiet --solver " + name).status, 0) << name;
  ASSERT_EQ(run("export pendulum_chain --at 5 --local -o " + problem).status, 0);
  expect_refused("solve " + problem + " --solver mixed_ldlt", 2, "local form");
}

}  // namespace
}  // namespace lockstep::mixed_solvers_test
