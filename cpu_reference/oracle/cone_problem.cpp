#include "cpu_reference/oracle/cone_problem.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "cpu_reference/oracle/dense.hpp"
#include "cpu_reference/oracle/inverse_mass.hpp"
#include "cpu_reference/oracle/joints/joint_solver.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Triplets = std::vector<Eigen::Triplet<double>>;

constexpr int refinements = 5;  // of what joints cannot change

SparseMatrix from_triplets(Eigen::Index rows, Eigen::Index columns, const Triplets& triplets) {
  SparseMatrix matrix(rows, columns);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

}  // namespace

std::vector<std::uint32_t> joint_blocks(const GlobalConeProblem& problem) {
  if (!problem.first.empty()) return problem.first;
  std::vector<std::uint32_t> first(static_cast<std::size_t>(problem.g.cols()) + 1);
  std::iota(first.begin(), first.end(), 0u);
  return first;
}

SparseMatrix BlockMatrix::sparse() const {
  Triplets triplets;
  triplets.reserve(9 * block.size());
  for (std::uint32_t i = 0; i < rows(); ++i) {
    for (std::uint32_t k = first[i]; k < first[i + 1]; ++k) {
      for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) triplets.emplace_back(3 * i + a, 3 * column[k] + b, block[k](a, b));
      }
    }
  }
  return from_triplets(3 * rows(), 3 * rows(), triplets);
}

SparseMatrix BlockMatrix::skew() const {
  const SparseMatrix w = sparse();
  SparseMatrix result = 0.5 * (w - SparseMatrix(w.transpose()));
  double largest = 0;
  for (const Matrix3d& b : block) largest = std::max(largest, b.cwiseAbs().maxCoeff());
  const double rounding = 1e-12 * largest;
  result.prune([&](Eigen::Index, Eigen::Index, double value) { return std::abs(value) > rounding; });
  return result;
}

MatrixXd BlockMatrix::dense() const {
  MatrixXd matrix = MatrixXd::Zero(3 * rows(), 3 * rows());
  for (std::uint32_t i = 0; i < rows(); ++i) {
    for (std::uint32_t k = first[i]; k < first[i + 1]; ++k) matrix.block<3, 3>(3 * i, 3 * column[k]) = block[k];
  }
  return matrix;
}

BlockMatrix block_matrix(const SparseMatrix& matrix) {
  const auto n = static_cast<std::uint32_t>(matrix.rows() / 3);
  const Eigen::SparseMatrix<double, Eigen::RowMajor> by_rows = matrix;
  BlockMatrix result;
  std::vector<std::uint32_t> slot(n, ~0u);  // of each column's block in this row
  for (std::uint32_t i = 0; i < n; ++i) {
    std::vector<std::uint32_t> columns = {i};
    for (int a = 0; a < 3; ++a) {
      for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(by_rows, 3 * i + a); entry; ++entry) {
        if (entry.value() != 0) columns.push_back(static_cast<std::uint32_t>(entry.col() / 3));
      }
    }
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
    for (const std::uint32_t c : columns) {
      slot[c] = static_cast<std::uint32_t>(result.block.size());
      if (c == i) result.diagonal.push_back(slot[c]);
      result.column.push_back(c);
      result.block.push_back(Matrix3d::Zero());
    }
    for (int a = 0; a < 3; ++a) {
      for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(by_rows, 3 * i + a); entry; ++entry) {
        if (entry.value() != 0) result.block[slot[entry.col() / 3]](a, entry.col() % 3) = entry.value();
      }
    }
    result.first.push_back(static_cast<std::uint32_t>(result.block.size()));
  }
  return result;
}

ConeProblem local_form(const GlobalConeProblem& problem) {
  const InverseMass inverse(problem.m);
  const VectorXd free = inverse.times(problem.f);
  const SparseMatrix response = inverse.times(problem.h);  // M^-1 H
  const SparseMatrix w = SparseMatrix(problem.h.transpose()) * response;
  const VectorXd q = problem.h.transpose() * free + problem.w;
  std::optional<Bilateral> joints;
  if (problem.g.cols() > 0) {
    const SparseMatrix joint_response = inverse.times(problem.g);
    joints.emplace();
    joints->v = SparseMatrix(problem.h.transpose()) * joint_response;
    joints->r = SparseMatrix(problem.g.transpose()) * joint_response;
    joints->s = problem.g.transpose() * free + problem.b;
    joints->first = joint_blocks(problem);
  }
  if (problem.dimension == 2) return embed_plane(w, q, problem.mu, std::move(joints));
  ConeProblem local = {block_matrix(w), q, problem.mu, std::move(joints), {}};
  if (!inverse.skew()) local.velocities = VelocityForm{problem.m, problem.h};
  return local;
}

ConeProblem embed_plane(const SparseMatrix& w, const VectorXd& q, const VectorXd& mu, std::optional<Bilateral> joints) {
  const Eigen::Index n = mu.size();
  const auto in_space = [](Eigen::Index row) { return row / 2 * 3 + row % 2; };
  const auto spread = [&](const SparseMatrix& matrix, bool columns_too) {
    Triplets triplets;
    for (int k = 0; k < matrix.outerSize(); ++k) {
      for (SparseMatrix::InnerIterator entry(matrix, k); entry; ++entry)
        triplets.emplace_back(in_space(entry.row()), columns_too ? in_space(entry.col()) : entry.col(), entry.value());
    }
    return triplets;
  };
  Triplets triplets = spread(w, true);
  for (Eigen::Index i = 0; i < n; ++i) triplets.emplace_back(3 * i + 2, 3 * i + 2, w.coeff(2 * i + 1, 2 * i + 1));
  ConeProblem problem;
  problem.w = block_matrix(from_triplets(3 * n, 3 * n, triplets));
  problem.q = VectorXd::Zero(3 * n);
  for (Eigen::Index row = 0; row < 2 * n; ++row) problem.q[in_space(row)] = q[row];
  problem.mu = mu;
  problem.joints = std::move(joints);
  if (problem.joints)
    problem.joints->v = from_triplets(3 * n, problem.joints->v.cols(), spread(problem.joints->v, false));
  return problem;
}

JointElimination::JointElimination(const ConeProblem& problem) : reduced_(problem) {
  if (!problem.joints) return;
  reduced_.joints.reset();
  reduced_.velocities.reset();  // those of W alone
  v_ = problem.joints->v;
  s_ = problem.joints->s;
  r_ = problem.joints->r;
  // joints are few, and redundant ones common: a dense factorisation that tells its rank, of rows scaled to a mobility
  // of 1, so that their masses and units do not matter to it
  const VectorXd scale = inverse_roots(r_.diagonal());
  inverse_ = pseudo_inverse(scale.asDiagonal() * MatrixXd(r_) * scale.asDiagonal(), redundant_rows);
  inverse_ = scale.asDiagonal() * inverse_ * scale.asDiagonal();
  const MatrixXd response = product(inverse_, v_.transpose());
  const SparseMatrix correction = MatrixXd(v_ * response).sparseView();
  reduced_.w = block_matrix(problem.w.sparse() - correction);
  reduced_.q = problem.q - v_ * (inverse_ * s_);
}

VectorXd JointElimination::joint_impulses(const VectorXd& r) const {
  if (s_.size() == 0) return {};
  return -inverse_ * (v_.transpose() * r + s_);
}

VectorXd JointElimination::beyond_joints() const {
  if (s_.size() == 0) return {};
  VectorXd left = s_;
  for (int k = 0; k < refinements; ++k) left -= r_ * (inverse_ * left);
  const VectorXd scale = inverse_roots(r_.diagonal());  // what is left is of the null space of R scaled
  return scale.cwiseProduct(scale.cwiseProduct(left));
}

ConeProblem reordered(const ConeProblem& problem, std::span<const std::uint32_t> order) {
  std::vector<std::uint32_t> rank(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) rank[order[i]] = i;
  const auto moved = [&](const SparseMatrix& matrix, bool columns_too) {
    const auto to = [&](Eigen::Index row) { return 3 * Eigen::Index(rank[row / 3]) + row % 3; };
    Triplets triplets;
    for (int k = 0; k < matrix.outerSize(); ++k) {
      for (SparseMatrix::InnerIterator entry(matrix, k); entry; ++entry)
        triplets.emplace_back(to(entry.row()), columns_too ? to(entry.col()) : entry.col(), entry.value());
    }
    return from_triplets(matrix.rows(), matrix.cols(), triplets);
  };
  ConeProblem result = problem;
  result.velocities.reset();
  result.w = block_matrix(moved(problem.w.sparse(), true));
  if (result.joints) result.joints->v = moved(problem.joints->v, false);
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    result.q.segment<3>(3 * i) = problem.q.segment<3>(3 * order[i]);
    result.mu[i] = problem.mu[order[i]];
  }
  return result;
}

}  // namespace lockstep::oracle
