// The solver of docs/tutorials/add_a_solver.md, against a method that shares nothing with it.
#include "examples/symmetric_pgs.hpp"

#include <gtest/gtest.h>

#include "tests/oracle/lcp_problems.hpp"

namespace lockstep::oracle::lcp::symmetric_pgs_test {
namespace {

using test::Random;
using test::solve;
using test::Solved;

SolveReport solve_symmetrically(const Lcp& problem, const SolveLimits& limits, VectorXd& z) {
  return symmetric_pgs(problem, limits, z);
}

TEST(SymmetricPgs, FindsWhatLemkeFinds) {
  Random random(3);
  Lcp p = test::random_p_matrix(random, 40, 0);
  p.m.array() += 0.5;
  const Solved exact = solve(lemke, p);
  const Solved found = solve(solve_symmetrically, p, {.tolerance = 1e-12, .iterations = 100'000});
  EXPECT_EQ(found.report.stop, Stop::solved);
  EXPECT_LT((found.z - exact.z).norm(), 1e-9 * exact.z.norm());
}

TEST(SymmetricPgs, StopsAtItsLimit) {
  Random random(4);
  const Lcp p = test::random_p_matrix(random, 40, 0);
  EXPECT_EQ(solve(solve_symmetrically, p, {.tolerance = 1e-12, .iterations = 1}).report.stop, Stop::limit);
}

}  // namespace
}  // namespace lockstep::oracle::lcp::symmetric_pgs_test
