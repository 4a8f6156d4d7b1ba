// The residual of a complementarity problem.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "cpu_reference/oracle/lcp/lcp.hpp"
#include "host/error.hpp"
#include "tests/oracle/lcp_problems.hpp"

namespace lockstep::oracle::lcp::lcp_measure_test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

Lcp one_row(double m, double q) { return {MatrixXd::Constant(1, 1, m), VectorXd::Constant(1, q)}; }
VectorXd value(double z) { return VectorXd::Constant(1, z); }

TEST(LcpMeasure, IsTheShareThatIsLeft) {
  const Lcp p = one_row(4, -8);  // z = 2
  EXPECT_EQ(residual(p, value(2)), 0);
  EXPECT_DOUBLE_EQ(residual(p, value(0)), 1);
  EXPECT_DOUBLE_EQ(residual(p, value(1.5)), 0.25);
  EXPECT_DOUBLE_EQ(residual(p, value(2.5)), 0.25);
  EXPECT_EQ(residual(p, value(std::nan(""))), infinity);
}

TEST(LcpMeasure, SeesWhatPulls) {
  const Lcp p = one_row(4, 8);  // z = 0
  EXPECT_EQ(residual(p, value(0)), 0);
  EXPECT_GT(residual(p, value(-1)), 0.4);
  EXPECT_GT(residual(p, value(1)), 0.4);
}

TEST(LcpMeasure, OfNothingIsZero) {
  EXPECT_EQ(residual(Lcp{MatrixXd(0, 0), VectorXd(0)}, VectorXd(0)), 0);
  EXPECT_EQ(residual(one_row(1, 0), value(0)), 0);
  EXPECT_EQ(residual(one_row(1, 0), value(3)), 1) << "q = 0 has no scale but that of z";
}

// Rows in other units: z_i in units of s_i, w_i in units of 1 / s_i (their product is an energy), and another unit for
// that. A pyramid's rows have two kinds of units, and zeros on the diagonal.
TEST(LcpMeasure, DoesNotDependOnUnits) {
  test::Random random(1);
  Lcp p = test::random_p_matrix(random, 6, 1);
  p.m(4, 4) = p.m(5, 5) = p.m(4, 5) = p.m(5, 4) = 0;
  const VectorXd z = random.vector(6).cwiseAbs();
  VectorXd s(6);
  s << 1e-3, 1e3, 7, 1e-2, 50, 1e4;
  for (const double energy : {1.0, 1e-6}) {
    const Lcp other = {s.asDiagonal() * p.m * s.asDiagonal(), energy * s.cwiseProduct(p.q)};
    EXPECT_NEAR(residual(other, energy * z.cwiseQuotient(s)), residual(p, z), 1e-12 * residual(p, z));
  }
}

TEST(LcpMeasure, KnowsBoxes) {
  BoxedLcp p = boxed(one_row(2, -8));
  p.high[0] = 3;  // below 4, where w = 0: at the bound w <= 0
  EXPECT_EQ(residual(p, value(3)), 0);
  EXPECT_GT(residual(p, value(2)), 0.1);
  EXPECT_GT(residual(p, value(4)), 0.1) << "outside";
  p.low[0] = -infinity;
  p.high[0] = infinity;
  EXPECT_EQ(residual(p, value(4)), 0) << "a free row is an equation";
}

TEST(LcpMeasure, KnowsFriction) {
  BoxedLcp p = boxed(Lcp{MatrixXd::Identity(2, 2), (VectorXd(2) << -2, 5).finished()});
  p.normal[1] = 0;
  p.friction[1] = 0.5;
  EXPECT_EQ(residual(p, (VectorXd(2) << 2, -1).finished()), 0) << "slides: at the bound that the normal gives";
  EXPECT_GT(residual(p, (VectorXd(2) << 2, -5).finished()), 0.5) << "would stick, beyond the bound";
}

template <class Problem>
std::string refusal(const Problem& p) {
  try {
    Measure{p};
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(LcpMeasure, RefusesWhatIsNoProblem) {
  EXPECT_NE(refusal(Lcp{MatrixXd::Zero(2, 3), VectorXd::Zero(2)}).find("2 x 3"), std::string::npos);
  EXPECT_NE(refusal(one_row(std::nan(""), 1)).find("not finite"), std::string::npos);
  EXPECT_NE(refusal(one_row(1, infinity)).find("not finite"), std::string::npos);
  BoxedLcp p = boxed(one_row(1, 1));
  p.low[0] = 1;
  p.high[0] = 0;
  EXPECT_NE(refusal(p).find("row 0: its lower bound"), std::string::npos);
  p = boxed(one_row(1, 1));
  p.normal[0] = 0;
  EXPECT_NE(refusal(p).find("no such normal"), std::string::npos);
}

}  // namespace
}  // namespace lockstep::oracle::lcp::lcp_measure_test
