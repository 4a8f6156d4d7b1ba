// The solvers of linear complementarity problems against each other, and against solutions that can be written down.
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "tests/oracle/lcp_problems.hpp"

namespace lockstep::oracle::lcp::lcp_solvers_test {
namespace {

using test::Random;
using test::solve;
using test::Solved;

constexpr std::array exact = {"lemke", "baraff", "murty", "fischer_newton", "keller"};  // for P matrices of any size

// Keller's method is for symmetric matrices: on others the objective that it lowers is none.
bool takes(std::string_view name, double skew) { return name != "keller" || skew == 0; }

TEST(LcpSolvers, AgreeOnSmallPMatrices) {
  Random random(1);
  for (const double skew : {0.0, 0.5}) {
    for (const Index n : {1, 2, 3, 5, 8, 11}) {
      for (int k = 0; k < 10; ++k) {
        const Lcp p = test::random_p_matrix(random, n, skew);
        const Solved all = solve(enumeration, p);
        ASSERT_EQ(all.report.stop, Stop::solved);
        for (const char* name : exact) {
          if (!takes(name, skew)) continue;
          const Solved s = solve(test::solver(name).solve, p);
          EXPECT_EQ(s.report.stop, Stop::solved) << name << ", n " << n << ", skew " << skew;
          EXPECT_LT((s.z - all.z).norm(), 1e-10 * (1 + all.z.norm())) << name << ", n " << n << ", skew " << skew;
        }
      }
    }
  }
}

TEST(LcpSolvers, AgreeOnLargerPMatrices) {
  Random random(2);
  for (const double skew : {0.0, 0.1}) {
    const Lcp p = test::random_p_matrix(random, 120, skew);
    const Solved first = solve(lemke, p);
    ASSERT_EQ(first.report.stop, Stop::solved);
    for (const char* name : exact) {
      if (!takes(name, skew)) continue;
      const Solved s = solve(test::solver(name).solve, p);
      EXPECT_EQ(s.report.stop, Stop::solved) << name;
      EXPECT_LT((s.z - first.z).norm(), 1e-10 * first.z.norm()) << name << ", skew " << skew;
    }
  }
}

// Where it cannot act, it says so, and does not return something for a solution.
TEST(LcpSolvers, KellerOnUnsymmetricMatrices) {
  Random random(9);
  int unsolved = 0;
  for (int k = 0; k < 100; ++k) {
    const Lcp p = test::random_p_matrix(random, 11, 1);
    const Solved s = solve(test::solver("keller").solve, p);
    EXPECT_EQ(s.report.stop == Stop::solved, residual(p, s.z) <= 1e-11);
    unsolved += s.report.stop != Stop::solved;
  }
  EXPECT_GT(unsolved, 0);
}

// Symmetric and positive definite: every method there is converges, but for plain Jacobi.
TEST(LcpSolvers, IterationsArriveAtTheSame) {
  Random random(3);
  Lcp p = test::random_p_matrix(random, 40, 0);
  p.m.array() += 0.5;
  const Solved first = solve(lemke, p);
  for (const char* name : {"damped_jacobi", "pgs", "psor", "pgs_sm", "nncg", "fischer_newton"}) {
    const Solved s = solve(test::solver(name).solve, p, {.tolerance = 1e-12, .iterations = 100'000});
    EXPECT_EQ(s.report.stop, Stop::solved) << name;
    EXPECT_LT((s.z - first.z).norm(), 1e-9 * first.z.norm()) << name;
    EXPECT_EQ(s.report.residuals.size(), s.report.iterations) << name;
    EXPECT_EQ(s.report.residual, residual(p, s.z)) << name;
  }
  EXPECT_LT((2 * MatrixXd(p.m.diagonal().asDiagonal()) - p.m).sum(), 0) << "2 D - M is not positive definite, so";
  EXPECT_EQ(solve(test::solver("jacobi").solve, p).report.stop, Stop::stalled);
}

// Rank-deficient and degenerate: z is not unique, w is, and complementarity holds.
TEST(LcpSolvers, SolveDegenerateProblems) {
  Random random(4);
  for (const Index rank : {1, 4, 10, 20}) {
    for (int k = 0; k < 5; ++k) {
      const Lcp p = test::random_degenerate(random, 20, rank);
      const VectorXd w = p.m * solve(lemke, p).z + p.q;
      for (const char* name : {"lemke", "keller", "baraff", "pgs_sm"}) {
        const Solved s = solve(test::solver(name).solve, p);
        EXPECT_EQ(s.report.stop, Stop::solved) << name << ", rank " << rank;
        EXPECT_LT(s.report.residual, 1e-11) << name << ", rank " << rank;
        EXPECT_LT((p.m * s.z + p.q - w).norm(), 1e-10 * p.q.norm()) << name << ", rank " << rank;
        EXPECT_GE(s.z.minCoeff(), 0) << name;
        EXPECT_LT(s.z.cwiseProduct(p.m * s.z + p.q).cwiseAbs().maxCoeff(), 1e-10 * p.q.norm() * s.z.norm()) << name;
      }
    }
  }
}

// Ties in every ratio test: all rows alike.
TEST(LcpSolvers, BreakTies) {
  for (const double off_diagonal : {1.0, 0.5, 0.0}) {
    const Index n = 12;
    MatrixXd m = MatrixXd::Constant(n, n, off_diagonal);
    m.diagonal().setOnes();
    const Lcp p = {m, -VectorXd::Ones(n)};
    for (const char* name : {"enumeration", "lemke", "keller", "baraff"}) {
      const Solved s = solve(test::solver(name).solve, p);
      EXPECT_EQ(s.report.stop, Stop::solved) << name << ", " << off_diagonal;
      EXPECT_NEAR(off_diagonal * s.z.sum() + (1 - off_diagonal) * s.z[0], 1, 1e-12) << name;
      EXPECT_TRUE(name == std::string_view("enumeration") || s.report.iterations <= 30) << name;
    }
  }
}

TEST(LcpSolvers, TakeProblemsOfOneRow) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const NamedSolver& s : solvers()) {
    const auto one = [&](double m, double q) {
      return solve(s.solve, Lcp{MatrixXd::Constant(1, 1, m), VectorXd::Constant(1, q)});
    };
    EXPECT_NEAR(one(4, -8).z[0], 2, 1e-10) << s.name;
    EXPECT_EQ(one(4, -8).report.stop, Stop::solved) << s.name;
    EXPECT_EQ(one(4, 8).z[0], 0) << s.name;
    EXPECT_EQ(one(4, 0).z[0], 0) << s.name;
    EXPECT_EQ(one(0, 3).report.stop, Stop::solved) << s.name;
    EXPECT_NE(one(0, -3).report.stop, Stop::solved) << s.name << ": w = -3 has no solution";
    EXPECT_LT(one(0, -3).z[0], inf) << s.name;
  }
}

TEST(LcpSolvers, TakeProblemsOfNoRows) {
  for (const NamedSolver& s : solvers()) {
    const Solved solved = solve(s.solve, Lcp{MatrixXd(0, 0), VectorXd(0)});
    EXPECT_EQ(solved.report.stop, Stop::solved) << s.name;
    EXPECT_EQ(solved.z.size(), 0) << s.name;
  }
}

// Two plates that press a body between them: w_1 = z_1 - z_2 - 1, w_2 = -z_1 + z_2 - 1 cannot both be positive.
TEST(LcpSolvers, SayThatThereIsNoSolution) {
  Lcp p = {MatrixXd(2, 2), -VectorXd::Ones(2)};
  p.m << 1, -1, -1, 1;
  for (const char* name : {"enumeration", "lemke", "keller", "baraff"}) {
    const Solved s = solve(test::solver(name).solve, p);
    EXPECT_EQ(s.report.stop, Stop::infeasible) << name;
    EXPECT_GT(s.report.residual, 0.1) << name;
    EXPECT_TRUE(s.z.allFinite()) << name;
  }
  for (const char* name : {"pgs", "psor", "nncg", "pgs_sm", "fischer_newton"}) {
    const Solved s = solve(test::solver(name).solve, p);
    EXPECT_EQ(s.report.stop, Stop::stalled) << name;
    EXPECT_TRUE(s.z.allFinite()) << name;
  }
}

// A solution without a basis: z = (1, 0), w = 0, where the only set that could give it has M_AA = 0.
TEST(LcpSolvers, EnumerationFindsSolutionsOfSingularSets) {
  Lcp p = {MatrixXd(2, 2), VectorXd(2)};
  p.m << 0, 0, 1, 0;
  p.q << 0, -1;
  const Solved s = solve(enumeration, p);
  EXPECT_EQ(s.report.stop, Stop::solved);
  EXPECT_GE(s.z[0], 1 - 1e-12);
}

// Murty's example makes the least-index method visit all 2^n - 1 further bases; its transpose does the same to Lemke's.
TEST(LcpSolvers, MurtysExampleTakesAllBases) {
  for (const Index n : {3, 6, 10}) {
    const Lcp p = test::murty_exponential(n), transposed = {p.m.transpose(), p.q};
    const Solved least_index = solve(murty, p), path = solve(lemke, transposed);
    EXPECT_EQ(least_index.report.stop, Stop::solved);
    EXPECT_EQ(least_index.report.iterations, (1u << n) - 1);
    EXPECT_EQ(least_index.z, VectorXd(VectorXd::Unit(n, n - 1)));
    EXPECT_EQ(path.report.stop, Stop::solved);
    EXPECT_EQ(path.report.iterations, 1u << n);
    EXPECT_EQ(path.z, VectorXd(VectorXd::Unit(n, 0)));
  }
  const Lcp large = test::murty_exponential(30);
  EXPECT_EQ(solve(murty, large).report.stop, Stop::limit) << "a thousand million pivots are not made";
  EXPECT_EQ(solve(lemke, large).report.stop, Stop::solved);
  EXPECT_EQ(solve(test::solver("baraff").solve, large).report.stop, Stop::solved);
}

TEST(LcpSolvers, HeedTheirLimits) {
  Random random(5);
  const Lcp p = test::random_p_matrix(random, 60, 0);
  for (const NamedSolver& s : solvers()) {
    if (s.name == "enumeration") continue;  // looks at all sets, or at none
    const Solved one = solve(s.solve, p, {.tolerance = 1e-15, .iterations = 1});
    EXPECT_LE(one.report.iterations, 1u) << s.name;
    if (s.name == "pgs_sm") continue;  // may be done by then
    EXPECT_EQ(one.report.stop, Stop::limit) << s.name;
  }
  EXPECT_EQ(solve(enumeration, p).report.stop, Stop::limit) << "out of its reach";
}

// Iterations start from what they are given.
TEST(LcpSolvers, IterationsStartWarm) {
  Random random(6);
  const Lcp p = test::random_p_matrix(random, 30, 0);
  const VectorXd solution = solve(lemke, p).z;
  for (const NamedSolver& s : solvers()) {
    if (s.direct) continue;
    VectorXd z = solution;
    const SolveReport report = s.solve(p, {.tolerance = 1e-10}, z);
    EXPECT_EQ(report.iterations, 0u) << s.name;
    EXPECT_EQ(z, solution) << s.name;
  }
}

// All masses and lengths scaled: the same steps lead to the same solution in the other unit.
TEST(LcpSolvers, DoNotDependOnUnits) {
  Random random(7);
  const Lcp p = test::random_p_matrix(random, 15, 0);
  for (const NamedSolver& s : solvers()) {
    if (s.name == "jacobi") continue;  // does not converge on it
    const Solved plain = solve(s.solve, p, {.tolerance = 1e-9});
    for (const double unit : {1e-6, 1e6}) {
      const Solved other = solve(s.solve, Lcp{unit * p.m, p.q}, {.tolerance = 1e-9});
      EXPECT_EQ(other.report.stop, plain.report.stop) << s.name;
      EXPECT_LE(std::abs(int(other.report.iterations) - int(plain.report.iterations)), 1) << s.name;
      EXPECT_LT((unit * other.z - plain.z).norm(), 1e-7 * plain.z.norm()) << s.name;
    }
  }
}

// Quadratic convergence: near a solution the residual of an iteration is about the square of the one before.
TEST(FischerNewton, ConvergesQuadratically) {
  Random random(8);
  for (int k = 0; k < 10; ++k) {
    const Solved s = solve(test::solver("fischer_newton").solve, test::random_p_matrix(random, 20, 0.3));
    ASSERT_EQ(s.report.stop, Stop::solved);
    EXPECT_LE(s.report.iterations, 15u);
    const std::vector<double>& r = s.report.residuals;
    ASSERT_GE(r.size(), 3u);
    const double before = r[r.size() - 2], last = r.back();
    EXPECT_LT(last, 1e-3 * before);
  }
}

}  // namespace
}  // namespace lockstep::oracle::lcp::lcp_solvers_test
