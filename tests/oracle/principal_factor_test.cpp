// The factor of a principal submatrix that grows and shrinks, against factors made anew.
#include "cpu_reference/oracle/lcp/principal_factor.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "tests/oracle/lcp_problems.hpp"

namespace lockstep::oracle::lcp::principal_factor_test {
namespace {

// What a solve with the set leaves of b.
double defect(const MatrixXd& m, const PrincipalFactor& factor, const VectorXd& b) {
  const MatrixXd sub = m(factor.set(), factor.set());
  const VectorXd x = factor.solve(b);
  return factor.size() > 0 ? (sub * x - b).norm() / (sub.norm() * x.norm() + b.norm()) : 0;
}

TEST(PrincipalFactor, SolvesAfterEveryChange) {
  for (const double skew : {0.0, 1.0}) {
    test::Random random(3);
    const MatrixXd m = test::random_p_matrix(random, 30, skew).m;
    PrincipalFactor factor(m, 1e-11);
    for (int change = 0; change < 400; ++change) {
      const Index i = Index(random.between(0, 30));
      const auto& set = factor.set();
      const auto at = std::find(set.begin(), set.end(), i);
      if (at != set.end())
        factor.remove(at - set.begin());
      else
        ASSERT_TRUE(factor.append(i));
      ASSERT_LT(defect(m, factor, random.vector(factor.size())), 1e-14) << "skew " << skew << ", change " << change;
    }
  }
}

TEST(PrincipalFactor, RefusesWhatWouldBeSingular) {
  MatrixXd m(3, 3);
  m << 1, 1, 0, 1, 1, 0, 0, 0, 1;  // rows 0 and 1 are the same
  PrincipalFactor symmetric(m, 1e-11);
  EXPECT_TRUE(symmetric.append(0));
  EXPECT_FALSE(symmetric.append(1));
  EXPECT_TRUE(symmetric.append(2));
  EXPECT_LT(defect(m, symmetric, VectorXd::Ones(2)), 1e-15) << "the refusal left nothing behind";

  m << 0, 1, 0, -1, 0, 0, 0, 1, 1;
  PrincipalFactor skew(m, 1e-11);
  EXPECT_FALSE(skew.append(0));
  EXPECT_TRUE(skew.append(2));
  EXPECT_FALSE(skew.append(0));
  EXPECT_LT(defect(m, skew, VectorXd::Ones(1)), 1e-15);
}

}  // namespace
}  // namespace lockstep::oracle::lcp::principal_factor_test
