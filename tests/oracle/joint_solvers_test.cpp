// Direct and iterative solves of joints alone, against dense ones.
#include <gtest/gtest.h>

#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "cpu_reference/oracle/dense.hpp"
#include "cpu_reference/oracle/joints/contradiction.hpp"
#include "cpu_reference/oracle/joints/joint_ldlt.hpp"
#include "tests/oracle/joint_problems.hpp"

namespace lockstep::oracle::joint_solvers_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

JointLdlt ldlt_of(const GlobalConeProblem& p) {
  return JointLdlt(p.m, p.g, mechanism_of(p.m, p.g, p.bodies, joint_blocks(p)));
}

struct Solution {
  VectorXd v, l;
};

// Of M v = f + G l, G^T v + b = 0.
Solution solve_by(const JointLdlt& ldlt, const GlobalConeProblem& p) {
  Solution s = {p.f, p.b};
  ldlt.solve(s.v, s.l);
  return s;
}

Solution solve_densely(const GlobalConeProblem& p) {
  const Index n = p.m.rows(), rows = p.g.cols();
  MatrixXd k = MatrixXd::Zero(n + rows, n + rows);
  k.topLeftCorner(n, n) = p.m;
  k.topRightCorner(n, rows) = -MatrixXd(p.g);
  k.bottomLeftCorner(rows, n) = -MatrixXd(p.g).transpose();
  VectorXd right(n + rows);
  right << p.f, p.b;
  const VectorXd x = solve_by_lu(k, right);
  return {x.head(n), x.tail(rows)};
}

void expect_same(const Solution& a, const Solution& b, double relative) {
  EXPECT_LE((a.v - b.v).norm(), relative * b.v.norm());
  EXPECT_LE((a.l - b.l).norm(), relative * b.l.norm());
}

TEST(JointLdlt, SolvesTreesAndForestsAsADenseSolverDoes) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    const int bodies = 1 + int(seed * 2);
    const GlobalConeProblem p = jointed_bodies(bodies, random_forest(bodies, 3 + int(seed % 5), seed), seed);
    if (p.g.cols() == 0) continue;
    const JointLdlt ldlt = ldlt_of(p);
    EXPECT_TRUE(ldlt.tree().left_out().empty());
    expect_same(solve_by(ldlt, p), solve_densely(p), 1e-10);
  }
}

// A second solve with the same factors, and bodies that no joint holds.
TEST(JointLdlt, SolvesAgainAndWithoutJoints) {
  GlobalConeProblem p = jointed_bodies(7, {}, 3);
  expect_same(solve_by(ldlt_of(p), p), solve_densely(p), 1e-10);
  p = jointed_bodies(30, random_forest(30, 4, 9), 9);
  const JointLdlt ldlt = ldlt_of(p);
  p.f *= -3;
  p.b.reverseInPlace();
  expect_same(solve_by(ldlt, p), solve_densely(p), 1e-10);
}

// Of a chain of 1,000 the dense matrix has 9,000 rows: what is compared is K x with its right side, and with a chain's
// own recursion, that of a band.
TEST(JointLdlt, SolvesAChainOfAThousand) {
  for (const int rows : {3, 5}) {
    const GlobalConeProblem p = jointed_bodies(1000, chain_of(1000, rows), 5);
    const Solution s = solve_by(ldlt_of(p), p);
    EXPECT_LE((p.m * s.v - p.f - p.g * s.l).norm(), 1e-10 * p.f.norm());
    EXPECT_LE((p.g.transpose() * s.v + p.b).norm(), 1e-10 * p.b.norm());
    Eigen::SparseLU<SparseMatrix> lu;
    std::vector<Eigen::Triplet<double>> k;
    const auto add = [&](const SparseMatrix& a, Index row, Index column, bool both) {
      for (int c = 0; c < a.outerSize(); ++c) {
        for (SparseMatrix::InnerIterator entry(a, c); entry; ++entry) {
          k.emplace_back(int(row + entry.row()), int(column + c), both ? -entry.value() : entry.value());
          if (both) k.emplace_back(int(column + c), int(row + entry.row()), -entry.value());
        }
      }
    };
    add(p.m, 0, 0, false);
    add(p.g, 0, p.m.rows(), true);
    SparseMatrix kkt(p.m.rows() + p.g.cols(), p.m.rows() + p.g.cols());
    kkt.setFromTriplets(k.begin(), k.end());
    lu.compute(kkt);
    VectorXd right(kkt.rows());
    right << p.f, p.b;
    const VectorXd x = lu.solve(right);
    expect_same(s, {x.head(p.m.rows()), x.tail(p.g.cols())}, 1e-10);
  }
}

// No fill: factors of twice the chain are twice as large, and as large as the blocks of K.
TEST(JointLdlt, FillsNothingIn) {
  const auto stored = [](int bodies) {
    return ldlt_of(jointed_bodies(bodies, chain_of(bodies, 5), 1)).tree().stored();
  };
  EXPECT_EQ(stored(200) - stored(100), 100 * (36 + 25 + 2 * 30));
  EXPECT_EQ(stored(400) - stored(200), 2 * (stored(200) - stored(100)));
}

// Rings, both ends of a chain in the world, and two joints between the same bodies.
TEST(JointLdlt, ClosesLoops) {
  std::vector<std::vector<Link>> mechanisms = {
      {{0, 1, 3}, {1, 2, 3}, {2, 3, 3}, {3, 0, 3}},
      {{-1, 0, 3}, {0, 1, 3}, {1, 2, 3}, {2, -1, 3}},
      {{0, 1, 2}, {1, 0, 2}, {-1, 1, 2}, {1, -1, 2}},
      {{0, 1, 3}, {1, 2, 3}, {2, 0, 2}, {2, 3, 4}, {3, 4, 3}, {4, 2, 2}, {-1, 4, 1}, {5, 6, 3}, {6, -1, 3}, {5, -1, 2}},
  };
  for (std::size_t k = 0; k < mechanisms.size(); ++k) {
    SCOPED_TRACE(k);
    const GlobalConeProblem p = jointed_bodies(7, mechanisms[k], unsigned(k));
    const JointLdlt ldlt = ldlt_of(p);
    EXPECT_EQ(ldlt.tree().left_out().empty(), k == 2)
        << "between two bodies, or a body and the world, rows are one joint";
    expect_same(solve_by(ldlt, p), solve_densely(p), 1e-9);
  }
}

// Rows that say a thing twice: velocities are those without them, impulses the least that do it.
TEST(JointLdlt, TakesRedundantRows) {
  for (const bool in_a_loop : {false, true}) {
    SCOPED_TRACE(in_a_loop);
    const std::vector<Link> links = in_a_loop ? std::vector<Link>{{-1, 0, 3}, {0, 1, 3}, {1, 2, 3}, {2, -1, 3}}
                                              : std::vector<Link>{{-1, 0, 5}, {0, 1, 5}, {1, 2, 4}};
    GlobalConeProblem p = jointed_bodies(3, links, 8);
    const Solution wanted = solve_densely(p);
    const Index rows = p.g.cols(), last = p.first[p.first.size() - 2];
    SparseMatrix wider(p.g.rows(), rows + 1);
    wider.leftCols(rows) = p.g;
    wider.col(rows) = SparseMatrix(2 * p.g.col(last) - p.g.col(last + 1));
    p.g = wider;
    p.b.conservativeResize(rows + 1);
    p.b[rows] = 2 * p.b[last] - p.b[last + 1];
    p.first.back() += 1;
    const JointLdlt ldlt = ldlt_of(p);
    EXPECT_FALSE(ldlt.tree().left_out().empty());
    const Solution s = solve_by(ldlt, p);
    EXPECT_LE((s.v - wanted.v).norm(), 1e-12 * wanted.v.norm());
    EXPECT_LE((p.m * s.v - p.f - p.g * s.l).norm(), 1e-13 * p.f.norm());
  }
}

// Without being told which velocities are a body's: those of six in a row, those that M couples, and a wrong guess.
TEST(JointLdlt, FindsBodiesByItself) {
  GlobalConeProblem p = jointed_bodies(20, random_forest(20, 4, 2), 2);
  const Solution wanted = solve_densely(p);
  p.bodies.clear();
  EXPECT_EQ(mechanism_of(p.m, p.g, p.bodies, p.first).bodies.size(), 20u);
  expect_same(solve_by(ldlt_of(p), p), wanted, 1e-10);
  p.bodies = {0, 3, 9};
  expect_same(solve_by(ldlt_of(p), p), wanted, 1e-9);
}

TEST(JointLdlt, RefusesMassesThatAreNone) {
  GlobalConeProblem p = jointed_bodies(3, chain_of(3, 3), 1);
  p.m.coeffRef(7, 7) = -1e3;
  EXPECT_THROW(ldlt_of(p), std::runtime_error);
  EXPECT_THROW(inverse_times(p.m, p.g), std::runtime_error);
}

// R x = c by each method: of trees and loops, and of redundant rows as far as they ask what can be.
TEST(JointMethods, AgreeWithADenseSolve) {
  std::vector<GlobalConeProblem> problems;
  for (const unsigned seed : {1u, 2u, 3u}) problems.push_back(jointed_bodies(40, random_forest(40, 5, seed), seed));
  problems.push_back(jointed_bodies(4, {{0, 1, 3}, {1, 2, 3}, {2, 3, 3}, {3, 0, 3}}, 4));
  problems.push_back(jointed_bodies(200, chain_of(200, 3), 6));
  for (const GlobalConeProblem& p : problems) {
    const MatrixXd r = joint_mobility(p);
    const VectorXd x = solve_by_lu(r, p.b);
    for (const JointMethod& method : joint_methods()) {
      SCOPED_TRACE(method.name);
      EXPECT_LE((method.make(p, 1e-14)->solve(p.b) - x).norm(), 1e-11 * x.norm());
    }
  }
}

TEST(JointMethods, TakeRedundantRows) {
  GlobalConeProblem p = jointed_bodies(2, {{-1, 0, 4}, {0, 1, 4}}, 5);
  SparseMatrix twice(p.g.rows(), 12);
  twice.leftCols(8) = p.g;
  twice.rightCols(4) = p.g.rightCols(4);
  p.g = twice;
  p.first = {0, 4, 8, 12};
  p.b = p.g.transpose() * p.f;
  const SparseMatrix r = joint_mobility(p);
  for (const JointMethod& method : joint_methods()) {
    SCOPED_TRACE(method.name);
    const VectorXd x = method.make(p, 1e-14)->solve(p.b);
    EXPECT_LE((r * x - p.b).norm(), 1e-12 * p.b.norm());
    EXPECT_LE(x.norm(), 10 * p.b.norm()) << "no impulses that only work against each other";
  }
}

// A ring with a row that says what two others say, and one that says something else: each method finds what proves it.
TEST(JointMethods, FindWhatContradictsItself) {
  for (const JointMethod& method : joint_methods()) {
    for (const bool contradicts : {false, true}) {
      SCOPED_TRACE(std::string(method.name) + (contradicts ? ", contradicts" : ""));
      GlobalConeProblem p = jointed_bodies(3, {{-1, 0, 3}, {0, 1, 3}, {1, 2, 3}, {2, -1, 3}}, 8);
      const Index rows = p.g.cols(), last = p.first[p.first.size() - 2];
      SparseMatrix wider(p.g.rows(), rows + 1);
      wider.leftCols(rows) = p.g;
      wider.col(rows) = SparseMatrix(2 * p.g.col(last) - p.g.col(last + 1));
      p.g = wider;
      p.b.conservativeResize(rows + 1);
      p.b[rows] = 2 * p.b[last] - p.b[last + 1] + (contradicts ? 0.1 : 0);
      p.first.back() += 1;
      const std::unique_ptr<JointSolver> solver = method.make(p, 1e-12);
      const VectorXd c = VectorXd(p.g.transpose() * inverse_times(p.m, SparseMatrix(p.f.sparseView()))) + p.b;
      const VectorXd y = solver->beyond(c);
      EXPECT_EQ(proves_contradiction(p, y), contradicts);
      const VectorXd x = solver->solve(c), left = c - joint_mobility(p) * x;
      EXPECT_EQ(left.norm() > 1e-9 * c.norm(), contradicts);
      EXPECT_LT(x.norm(), 1e6 * c.norm()) << "no impulses without bounds";
      if (!contradicts) continue;
      EXPECT_NEAR(std::abs(y[rows] / y[last + 1]), 1, 1e-9);
      EXPECT_NEAR(std::abs(y[last] / y[last + 1]), 2, 1e-9);
    }
  }
}

}  // namespace
}  // namespace lockstep::oracle::joint_solvers_test
