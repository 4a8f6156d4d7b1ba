// The error measures on problems small enough to be solved by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "cpu_reference/oracle/cone/solvers.hpp"
#include "cpu_reference/oracle/error.hpp"
#include "tests/oracle/cone_problems.hpp"

namespace lockstep::oracle::cone_error_test {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

void expect_solved(const ConeProblem& problem, const Vector3d& r) {
  const ConeError error = cone_error(problem, r);
  for (const double measure : {error.residual, error.defect_max, error.natural_map, error.natural_largest,
                               error.alart_curnier, error.jean_moreau, error.merit_1})
    EXPECT_LT(measure, 1e-15);
}

TEST(ConeError, IsZeroAtSolutions) {
  expect_solved(single_contact(0.5, {2, 1, -1}, 0.3), {0, 0, 0});            // leaves
  expect_solved(single_contact(0.5, {-2, 0.3, -0.4}, 0.3), {4, -0.6, 0.8});  // sticks, within 1.2
  expect_solved(single_contact(0.5, {-2, 3, -4}, 0.3), {4, -0.72, 0.96});    // slides on, |r_t| = 1.2
  expect_solved(single_contact(0.5, {-2, 3, -4}, 0), {4, 0, 0});
  // nothing that an impulse could move
  EXPECT_EQ(cone_error(single_contact(0, {-1, 0, 0}, 0.5), Vector3d::Zero()).residual, 0);
}

// Half of the impulse that stops a fall of 2 m/s leaves a fall of 1 m/s.
TEST(ConeError, OfHalfAnImpulseIsTheVelocityThatIsLeft) {
  const ConeError error = cone_error(single_contact(0.25, {-2, 0, 0}, 0.5), Vector3d(4, 0, 0));
  EXPECT_DOUBLE_EQ(error.defect_max, 1);
  EXPECT_DOUBLE_EQ(error.residual, 0.5);
  EXPECT_DOUBLE_EQ(error.natural_map, 0.5);  // |F| = 1 for rho = 1, |q| = 2
  EXPECT_DOUBLE_EQ(error.natural_largest, 0.25);
  EXPECT_DOUBLE_EQ(error.merit_1, 1 / (1 + std::sqrt(2.0)));
}

TEST(ConeError, DoesNotDependOnUnits) {
  const ConeProblem problem = local_form(random_heap(6, 16, 0.4, 1));
  VectorXd r;
  nsgs(problem, {.tolerance = 1e-12, .iterations = 5}, r);
  const ConeError error = cone_error(problem, r);
  ASSERT_GT(error.residual, 1e-6);
  const double mass = 1000, length = 0.01;
  ConeProblem other = problem;
  for (Eigen::Matrix3d& block : other.w.block) block /= mass;
  other.q *= length;
  const ConeError scaled = cone_error(other, r * mass * length);
  EXPECT_NEAR(scaled.residual, error.residual, 1e-12 * error.residual);
  EXPECT_NEAR(scaled.rounding, error.rounding, 1e-12 * error.rounding);
  EXPECT_NEAR(scaled.defect_max, error.defect_max * length, 1e-12 * error.defect_max);
  EXPECT_GT(std::abs(scaled.natural_largest - error.natural_largest), 0.5 * error.natural_largest)
      << "it compares impulses with velocities";
}

TEST(ConeError, DoesNotDependOnTheOrderOfContacts) {
  const ConeProblem problem = local_form(random_heap(6, 16, 0.4, 2));
  VectorXd r, moved;
  nsgs(problem, {.tolerance = 1e-12, .iterations = 5}, r);
  std::vector<std::uint32_t> order(problem.contacts());
  std::iota(order.begin(), order.end(), 0u);
  std::rotate(order.begin(), order.begin() + 5, order.end());
  std::swap(order[1], order[9]);
  moved.resize(r.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) moved.segment<3>(3 * i) = r.segment<3>(3 * order[i]);
  const ConeError error = cone_error(problem, r), other = cone_error(reordered(problem, order), moved);
  EXPECT_NEAR(other.residual, error.residual, 1e-12 * error.residual);
  EXPECT_NEAR(other.natural_map, error.natural_map, 1e-12 * error.natural_map);
  EXPECT_NEAR(other.merit_1, error.merit_1, 1e-12 * error.merit_1);
  EXPECT_EQ(order[other.worst], error.worst);
}

// A heavy body lies as it should, a light one falls as if nothing were below it.
TEST(ConeError, SeesALightBodyBesideAHeavyOne) {
  ConeProblem problem = single_contact(1e-3, {-1, 0, 0}, 0.5);
  problem.w.diagonal.push_back(1);
  problem.w.first.push_back(2);
  problem.w.column.push_back(1);
  problem.w.block.push_back(1e3 * Eigen::Matrix3d::Identity());
  problem.q = VectorXd::Zero(6);
  problem.q[0] = problem.q[3] = -1;
  problem.mu = VectorXd::Constant(2, 0.5);
  VectorXd r = VectorXd::Zero(6);
  r[0] = 1e3;
  const ConeError error = cone_error(problem, r);
  EXPECT_NEAR(error.residual, std::sqrt(0.5), 1e-12);
  EXPECT_EQ(error.worst, 1u);
  EXPECT_LT(error.natural_largest, 2e-3) << "where impulses are compared with velocities it is hardly there";
}

// A bilateral row counts with what is left of its velocity.
TEST(ConeError, CountsJoints) {
  ConeProblem problem = single_contact(1, {-1, 0, 0}, 0.5);
  problem.joints.emplace();
  problem.joints->v = SparseMatrix(3, 2);
  problem.joints->r = SparseMatrix(2, 2);
  problem.joints->r.setIdentity();
  problem.joints->s = Eigen::Vector2d(3, 4);
  problem.joints->first = {0, 2};
  const ConeError error = cone_error(problem, Vector3d(1, 0, 0), Eigen::Vector2d(-2.4, -3.2));
  EXPECT_NEAR(error.defect_max, 1, 1e-15);  // a fifth of |(3, 4)|
  EXPECT_EQ(error.worst, 1u);
  EXPECT_NEAR(error.residual, 1 / std::sqrt(26.0), 1e-15);
}

TEST(ConeError, OfNoContactIsZero) { EXPECT_EQ(cone_error(ConeProblem(), VectorXd()).residual, 0); }

}  // namespace
}  // namespace lockstep::oracle::cone_error_test
