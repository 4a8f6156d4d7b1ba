// The matrix splittings, and what is built on their sweeps, in a box.
#include "cpu_reference/oracle/lcp/splitting.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>

#include "tests/oracle/lcp_problems.hpp"

namespace lockstep::oracle::lcp::splitting_test {
namespace {

using test::Random;
using test::solve;
using test::Solved;

// A sweep is the projection of M^-1 (N z - q) with M - N = A: for Gauss-Seidel N = -U, where the survey prints U.
TEST(Splitting, SweepsAreTheSplittingsOfTheMatrix) {
  Random random(1);
  Lcp p = test::random_p_matrix(random, 8, 0.2);
  BoxedLcp unbounded = boxed(p);
  unbounded.low.setConstant(-std::numeric_limits<double>::infinity());
  const VectorXd z = random.vector(8);
  const MatrixXd lower = p.m.triangularView<Eigen::StrictlyLower>(), upper = p.m.triangularView<Eigen::StrictlyUpper>();
  const MatrixXd diagonal = p.m.diagonal().asDiagonal();
  for (const double g : {1.0, 1.3, 0.7}) {
    const MatrixXd m = diagonal + g * lower, n = (1 - g) * diagonal - g * upper;
    EXPECT_LT((m - n - g * p.m).norm(), 1e-14);
    VectorXd swept = z;
    gauss_seidel_sweep(unbounded, g, swept);
    EXPECT_LT((swept - m.lu().solve(n * z - g * p.q)).norm(), 1e-13) << g;
  }
  VectorXd once = z;
  projected_jacobi(unbounded, {.tolerance = 0, .iterations = 1}, once);
  const VectorXd jacobi = diagonal.inverse() * (-(lower + upper) * z - p.q);
  VectorXd best = residual(unbounded, jacobi) < residual(unbounded, z) ? jacobi : z;  // what a solver returns
  EXPECT_LT((once - best).norm(), 1e-13);
}

TEST(Splitting, RefusesAZeroDiagonal) {
  Lcp p = {MatrixXd(2, 2), -VectorXd::Ones(2)};
  p.m << 0, 1, 1, 1;
  for (const char* name : {"jacobi", "damped_jacobi", "pgs", "psor", "pgs_sm", "nncg"}) {
    const Solved s = solve(test::solver(name).solve, p);
    EXPECT_EQ(s.report.stop, Stop::stalled) << name;
    EXPECT_EQ(s.report.iterations, 0u) << name;
  }
  p.m << 0, 0, 0, 1;  // a row that nothing moves is left alone
  p.q[0] = 1;
  EXPECT_EQ(solve(test::solver("pgs").solve, p).report.stop, Stop::solved);
}

// A box of constants: free rows, rows below, above and within two bounds; the direct method against the iterations.
TEST(BoxedSolvers, AgreeInABox) {
  Random random(2);
  for (int k = 0; k < 10; ++k) {
    const Lcp p = test::random_p_matrix(random, 24, 0);
    BoxedLcp b = boxed(p);
    const double inf = std::numeric_limits<double>::infinity();
    for (Index i = 0; i < b.size(); ++i) {
      if (i % 4 == 1) b.low[i] = -inf;
      if (i % 4 == 2) b.high[i] = random.between(0, 0.3);
      if (i % 4 == 3) {
        b.low[i] = random.between(-0.3, 0.1);
        b.high[i] = b.low[i] + (i % 8 == 3 ? 0 : 0.2);
      }
    }
    VectorXd first;
    EXPECT_EQ(baraff(b, {.tolerance = 1e-12}, first).stop, Stop::solved);
    for (const NamedBoxedSolver& s : boxed_solvers()) {
      if (s.name == "jacobi" || s.name == "fischer_newton") continue;
      VectorXd z;
      const SolveReport r = s.solve(b, {.tolerance = 1e-12, .iterations = 100'000}, z);
      EXPECT_EQ(r.stop, Stop::solved) << s.name;
      EXPECT_LT((z - first).norm(), 1e-9 * (1 + first.norm())) << s.name;
    }
  }
}

TEST(BoxedSolvers, TakeProblemsOfNoRows) {
  const BoxedLcp none = boxed(Lcp{MatrixXd(0, 0), VectorXd(0)});
  for (const NamedBoxedSolver& s : boxed_solvers()) {
    VectorXd z;
    EXPECT_EQ(s.solve(none, {}, z).stop, Stop::solved) << s.name;
  }
}

// Free rows are equations: Newton's method on them is a linear solve.
TEST(BoxedSolvers, NewtonSolvesMixedProblems) {
  Random random(3);
  const Lcp p = test::random_p_matrix(random, 20, 0.3);
  BoxedLcp mixed = boxed(p);
  mixed.low.tail(8).setConstant(-std::numeric_limits<double>::infinity());
  VectorXd z;
  const SolveReport r = fischer_newton(mixed, {.tolerance = 1e-12}, z);
  EXPECT_EQ(r.stop, Stop::solved);
  EXPECT_LT((p.m * z + p.q).tail(8).norm(), 1e-11);
  EXPECT_GE(z.head(12).minCoeff(), 0);
  mixed.high[0] = 1;
  EXPECT_EQ(fischer_newton(mixed, {}, z = VectorXd()).stop, Stop::stalled) << "a second bound is out of its reach";
}

}  // namespace
}  // namespace lockstep::oracle::lcp::splitting_test
