// What dense.hpp says of matrices that are singular, against answers that can be written down.
#include "cpu_reference/oracle/dense.hpp"

#include <gtest/gtest.h>

namespace lockstep::oracle::dense_test {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double regular = 1e-12;

const MatrixXd twice = MatrixXd::Ones(2, 2);  // the same row twice

TEST(Dense, ARegularSystemHasOneAnswer) {
  MatrixXd a(2, 2);
  a << 0, 2, 3, 1;  // without pivoting there would be none
  const VectorXd x = Vector2d(5, -7), b = a * x;
  EXPECT_LE((solve_by_lu(a, b) - x).norm(), 1e-14);
  EXPECT_LE((solve_by_lu(a, MatrixXd(b)) - x).norm(), 1e-14);
  EXPECT_LE((solve_or_least_norm(a, b, regular) - x).norm(), 1e-14);
  EXPECT_LE((solve_by_least_squares(a, b) - x).norm(), 1e-14);
  ASSERT_TRUE(solve_if_regular(a, b, regular));
  EXPECT_LE((*solve_if_regular(a, b, regular) - x).norm(), 1e-14);
}

// x_1 + x_2 = 4 and = 8: least squares say 6, the least x is (3, 3).
TEST(Dense, ASingularSystemHasAnAnswerOfLeastNorm) {
  const VectorXd b = Vector2d(4, 8);
  EXPECT_LE((solve_by_least_norm(twice, b) - Vector2d(3, 3)).norm(), 1e-14);
  EXPECT_LE((solve_or_least_norm(twice, b, regular) - Vector2d(3, 3)).norm(), 1e-14);
}

TEST(Dense, LeastSquaresLeaveWhatSaysNothingNewAtZero) {
  const VectorXd x = solve_by_least_squares(twice, Vector2d(4, 8));
  EXPECT_NEAR(x.sum(), 6, 1e-14);
  EXPECT_EQ(x.minCoeff(), 0);
}

TEST(Dense, ASingularMatrixIsToldFromARegularOne) {
  EXPECT_FALSE(solve_if_regular(twice, Vector2d(1, 1), regular));
  EXPECT_FALSE(inverse_if_regular(twice));
  EXPECT_EQ(rank_and_inverse(twice, regular).rank, 1);
  EXPECT_EQ(rank_and_inverse(twice, regular).inverse.size(), 0);

  const Matrix3d d = Vector3d(2, 4, 1e-9).asDiagonal(), inverse = Vector3d(0.5, 0.25, 1e9).asDiagonal();
  ASSERT_TRUE(inverse_if_regular(d));
  EXPECT_TRUE(inverse_if_regular(d)->isApprox(inverse));
  EXPECT_EQ(rank_and_inverse(d, regular).rank, 3);
  EXPECT_TRUE(rank_and_inverse(d, regular).inverse.isApprox(inverse));
  EXPECT_EQ(rank_and_inverse(d, 1e-8).rank, 2) << "a pivot below this share of the largest";
}

TEST(Dense, ProductsOfAnySizeAgreeWithSums) {
  for (const Eigen::Index n : {0, 1, 3, 40}) {
    const MatrixXd a = MatrixXd::Random(5, n), b = MatrixXd::Random(n, 7);
    MatrixXd sum = MatrixXd::Zero(5, 7);
    for (Eigen::Index k = 0; k < n; ++k) sum += a.col(k) * b.row(k);
    EXPECT_LE((product(a, b) - sum).norm(), 1e-13);
    EXPECT_LE((transposed_product(a.transpose(), b) - sum).norm(), 1e-13);
  }
}

TEST(Dense, EigenvaluesRise) {
  Matrix3d a;  // 1 about (1, 1, 0), 3 about (1, -1, 0), -2 about z
  a << 2, -1, 0, -1, 2, 0, 0, 0, -2;
  const SymmetricEigen eigen = symmetric_eigen<3>(a);
  EXPECT_LE((eigen.values - Vector3d(-2, 1, 3)).norm(), 1e-14);
  EXPECT_LE((a * eigen.vectors - eigen.vectors * eigen.values.asDiagonal()).norm(), 1e-14);
  EXPECT_NEAR(largest_eigenvalue(a), 3, 1e-14);
  const SymmetricEigen any = symmetric_eigen<Eigen::Dynamic>(a);
  EXPECT_LE((any.values - eigen.values).norm(), 1e-14);
}

// The inverse on what a matrix does not lose, and nothing of what it does: A X A = A, X A X = X.
TEST(Dense, PseudoInversesLeaveOutWhatIsLost) {
  const MatrixXd root = MatrixXd::Random(6, 4), a = root * root.transpose(), x = pseudo_inverse(a, 1e-12);
  EXPECT_LE((a * x * a - a).norm(), 1e-12 * a.norm());
  EXPECT_LE((x * a * x - x).norm(), 1e-12 * x.norm());
  EXPECT_LE((x - x.transpose()).norm(), 1e-13 * x.norm());
  EXPECT_EQ(pseudo_inverse(MatrixXd::Zero(3, 3), 1e-12).norm(), 0);
  EXPECT_EQ(pseudo_inverse(MatrixXd(), 1e-12).size(), 0);
}

}  // namespace
}  // namespace lockstep::oracle::dense_test
