// Every solver of frictional contact problems on the same problems, against closed forms and against each other.
#include <gtest/gtest.h>

#include <algorithm>

#include "cpu_reference/oracle/cone/cone.hpp"
#include "cpu_reference/oracle/cone/whole.hpp"
#include "cpu_reference/oracle/joints/contradiction.hpp"
#include "tests/oracle/cone_problems.hpp"

namespace lockstep::oracle::cone_solvers_test {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr SolveLimits limits = {.tolerance = 1e-9, .iterations = 200000, .seconds = 600};

// Those that solve Coulomb's law.
std::vector<ConeSolver> exact_solvers() {
  std::vector<ConeSolver> solvers;
  for (const ConeSolver& solver : cone_solvers()) {
    if (solver.name != "ccp_apgd") solvers.push_back(solver);
  }
  return solvers;
}

TEST(ConeSolvers, SolveOneContactInClosedForm) {
  for (const ConeSolver& solver : exact_solvers()) {
    const auto expect = [&](const Vector3d& q, double mu, const Vector3d& wanted) {
      VectorXd r;
      const SolveReport report = solver.solve(single_contact(0.5, q, mu), limits, r);
      EXPECT_EQ(report.stop, Stop::solved) << solver.name;
      EXPECT_LT((r - wanted).norm(), 1e-7) << solver.name << ": " << r.transpose();
    };
    expect({2, 1, -1}, 0.3, {0, 0, 0});
    expect({-2, 0.3, -0.4}, 0.3, {4, -0.6, 0.8});
    expect({-2, 3, -4}, 0.3, {4, -0.72, 0.96});
    expect({-2, 3, -4}, 0, {4, 0, 0});
  }
}

// More rows than velocities. The impulses are not unique; the velocities need not be either, in these heaps they are.
TEST(ConeSolvers, AgreeOnAHeap) {
  for (const unsigned seed : {2u, 3u, 5u}) {
    const ConeProblem problem = local_form(random_heap(5, 20, 0.2, seed));
    VectorXd exact;
    ASSERT_EQ(solve_automatically(problem, {.tolerance = 1e-12, .iterations = 100000}, exact).stop, Stop::solved);
    const VectorXd u = problem.w.times(exact) + problem.q;
    for (const ConeSolver& solver : exact_solvers()) {
      VectorXd r;
      const SolveReport report = solver.solve(problem, limits, r);
      if (solver.name == "staggered" && report.stop == Stop::stalled) continue;  // no promise is made
      EXPECT_EQ(report.stop, Stop::solved) << solver.name << ", " << report.residual;
      EXPECT_LT((problem.w.times(r) + problem.q - u).norm(), 1e-6 * u.norm()) << solver.name << ", seed " << seed;
    }
  }
}

// What factorises through the velocities gives the same without knowing them.
TEST(ConeSolvers, AgreeWithAndWithoutVelocities) {
  const ConeProblem problem = local_form(random_heap(5, 20, 0.2, 2));
  ASSERT_LT(problem.velocities->m.rows(), problem.q.size());
  ConeProblem without = problem;
  without.velocities.reset();
  for (const auto solve : {admm, newton, proximal_point}) {
    VectorXd r, other;
    EXPECT_EQ(solve(problem, limits, r).stop, Stop::solved);
    EXPECT_EQ(solve(without, limits, other).stop, Stop::solved);
    const VectorXd u = problem.w.times(r) + problem.q;
    EXPECT_LT((problem.w.times(other) + problem.q - u).norm(), 1e-6 * u.norm());
  }
}

TEST(ConeSolvers, SolveStrongFriction) {
  for (const double mu : {0.8, 2.0}) {
    const ConeProblem problem = local_form(random_heap(5, 12, mu, 7));
    VectorXd r;
    EXPECT_EQ(solve_automatically(problem, limits, r).stop, Stop::solved) << mu;
    EXPECT_LT(cone_error(problem, r).residual, limits.tolerance);
  }
}

// Without friction: a quadratic programme, whose velocities are unique.
TEST(ConeSolvers, SolveWithoutFriction) {
  const ConeProblem problem = local_form(random_heap(4, 12, 0, 5));
  VectorXd u;
  for (const ConeSolver& solver : cone_solvers()) {  // the relaxed problem is the same one then
    VectorXd r;
    EXPECT_EQ(solver.solve(problem, limits, r).stop, Stop::solved) << solver.name;
    const VectorXd velocity = problem.w.times(r) + problem.q;
    if (u.size() == 0) u = velocity;
    EXPECT_LT((velocity - u).norm(), 1e-6 * u.norm()) << solver.name;
    for (std::uint32_t i = 0; i < problem.contacts(); ++i) {
      EXPECT_EQ(r.segment<2>(3 * i + 1).norm(), 0) << solver.name;
      EXPECT_GT(velocity[3 * i], -1e-7) << solver.name;
    }
  }
}

TEST(ConeSolvers, SolveNothing) {
  for (const ConeSolver& solver : cone_solvers()) {
    VectorXd r;
    const SolveReport report = solver.solve(ConeProblem(), limits, r);
    EXPECT_EQ(report.stop, Stop::solved) << solver.name;
    EXPECT_EQ(r.size(), 0);
  }
}

// A contact between bodies that nothing moves, beside one that can be solved.
TEST(ConeSolvers, LeaveImmovableContactsAlone) {
  ConeProblem problem = single_contact(0.5, {-2, 3, -4}, 0.3);
  problem.w.diagonal.push_back(1);
  problem.w.first.push_back(2);
  problem.w.column.push_back(1);
  problem.w.block.push_back(Eigen::Matrix3d::Zero());
  const Vector3d q = problem.q;
  problem.q = VectorXd::Zero(6);
  problem.q.head<3>() = q;
  problem.q[3] = -1;
  problem.mu = VectorXd::Constant(2, 0.3);
  for (const ConeSolver& solver : exact_solvers()) {
    VectorXd r;
    EXPECT_EQ(solver.solve(problem, limits, r).stop, Stop::solved) << solver.name;
    EXPECT_LT((r.head<3>() - Vector3d(4, -0.72, 0.96)).norm(), 1e-7) << solver.name;
    EXPECT_TRUE(r.allFinite()) << solver.name;
  }
}

// A sliding contact of the relaxed problem lifts by mu |u_t|.
TEST(ConeSolvers, RelaxedContactsLift) {
  const ConeProblem problem = single_contact(0.5, {-2, 3, -4}, 0.3);
  VectorXd r;
  const SolveReport report = accelerated_gradient(problem, limits, r, true);
  const Vector3d u = problem.w.times(r) + problem.q;
  EXPECT_NEAR(u[0], 0.3 * u.tail<2>().norm(), 1e-7);
  EXPECT_NEAR(r.tail<2>().norm(), 0.3 * r[0], 1e-7);
  EXPECT_NEAR(r.dot(u), 0, 1e-6);
  EXPECT_EQ(report.stop, Stop::stalled);
  EXPECT_NEAR(report.residual, cone_error(problem, r).residual, 1e-12);
  EXPECT_GT(report.residual, 0.01) << "it is not the solution of Coulomb's law";
}

TEST(ConeSolvers, GiveTheBestIterateAndStopWhenTold) {
  const ConeProblem problem = local_form(random_heap(8, 40, 0.5, 11));
  for (const ConeSolver& solver : exact_solvers()) {
    VectorXd r;
    const SolveReport report = solver.solve(problem, {.tolerance = 1e-300, .iterations = 12, .seconds = 600}, r);
    EXPECT_NE(report.stop, Stop::solved) << solver.name;
    EXPECT_LE(report.iterations, 12u) << solver.name;
    EXPECT_NEAR(cone_error(problem, r).residual, report.residual, 1e-12 + 1e-9 * report.residual) << solver.name;
    EXPECT_EQ(report.residual, *std::ranges::min_element(report.residuals)) << solver.name;
    // from there no solver may end anywhere worse
    VectorXd further = r;
    EXPECT_LE(solver.solve(problem, {.tolerance = 1e-300, .iterations = 3, .seconds = 600}, further).residual,
              report.residual * (1 + 1e-12))
        << solver.name;
  }
}

// Nearly symmetric, as some files are: solved as it stands.
TEST(ConeSolvers, SolveWhatIsNotQuiteSymmetric) {
  ConeProblem problem = local_form(random_heap(5, 12, 0.3, 4));
  problem.velocities.reset();
  for (std::uint32_t i = 0; i < 3; ++i) {
    Eigen::Matrix3d& block = problem.w.block[problem.w.diagonal[i]];
    block(1, 2) += 1e-3 * block.norm();
  }
  for (const char* name : {"auto", "nsgs", "admm", "newton"}) {
    VectorXd r;
    EXPECT_EQ(find_cone_solver(name)->solve(problem, limits, r).stop, Stop::solved) << name;
    EXPECT_LT(cone_error(problem, r).residual, limits.tolerance) << name;
  }
}

// Two balls on a rod, one of them on the ground: the joint is taken out and its impulse found again.
TEST(WholeProblem, SolvesWithJoints) {
  GlobalConeProblem global = random_heap(4, 8, 0.3, 6);
  std::vector<Eigen::Triplet<double>> g;
  for (int k = 0; k < 3; ++k) {  // the first three balls move together, and one row says it twice
    g.emplace_back(k, k, 1.0);
    g.emplace_back(6 + k, k, -1.0);
    g.emplace_back(6 + k, 3 + k, 1.0);
    g.emplace_back(12 + k, 3 + k, -1.0);
  }
  g.emplace_back(0, 6, 1.0);
  g.emplace_back(6, 6, -1.0);
  global.g = SparseMatrix(24, 7);
  global.g.setFromTriplets(g.begin(), g.end());
  global.b = VectorXd::Zero(7);
  const ConeProblem problem = local_form(global);
  for (const ConeSolver& solver : exact_solvers()) {
    const ConeSolution solution = solve_whole(problem, solver, limits);
    EXPECT_LE(solution.error.residual, limits.tolerance) << solver.name;
    // M v = f + H r + G l
    const VectorXd load = global.f + global.h * solution.r + global.g * solution.l;
    VectorXd v = load;
    for (Eigen::Index k = 0; k < v.size(); ++k) v[k] /= global.m.coeff(k, k);
    EXPECT_LT((global.g.transpose() * v).norm(), 1e-9) << solver.name;
  }
  global.b[6] = 0.1;  // says something else than row 0
  const ConeSolution middle = solve_whole(local_form(global), cone_solvers()[0], limits);
  EXPECT_EQ(middle.report.stop, Stop::stalled);
  EXPECT_TRUE(proves_contradiction(global, middle.beyond_joints));
  EXPECT_GT(middle.error.residual, 1e-4);
}

}  // namespace
}  // namespace lockstep::oracle::cone_solvers_test
