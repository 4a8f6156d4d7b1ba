#include "host/problems/rolling.hpp"

namespace lockstep {

namespace {

using Eigen::Index;
using Eigen::VectorXd;
using oracle::SparseMatrix;
using Triplets = std::vector<Eigen::Triplet<double>>;

// Where a row of the file is in the split problem: n, t, t and, behind the second normal, m, m.
Index split_row(Index row) { return row / 5 * 6 + row % 5 + (row % 5 > 2 ? 1 : 0); }

Triplets entries_of(const SparseMatrix& matrix, bool split_rows, bool split_columns) {
  Triplets triplets;
  for (int k = 0; k < matrix.outerSize(); ++k) {
    for (SparseMatrix::InnerIterator entry(matrix, k); entry; ++entry)
      triplets.emplace_back(split_rows ? split_row(entry.row()) : entry.row(),
                            split_columns ? split_row(entry.col()) : entry.col(), entry.value());
  }
  return triplets;
}

SparseMatrix from_triplets(Index rows, Index columns, const Triplets& triplets) {
  SparseMatrix matrix(rows, columns);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

VectorXd split_rows(const VectorXd& x) {
  VectorXd result = VectorXd::Zero(x.size() / 5 * 6);
  for (Index row = 0; row < x.size(); ++row) result[split_row(row)] = x[row];
  return result;
}

VectorXd joined_rows(const VectorXd& x) {
  VectorXd result(x.size() / 6 * 5);
  for (Index row = 0; row < result.size(); ++row) result[row] = x[split_row(row)];
  return result;
}

VectorXd alternating(const VectorXd& mu, const VectorXd& rolling) {
  VectorXd result(2 * mu.size());
  for (Index i = 0; i < mu.size(); ++i) result.segment<2>(2 * i) << mu[i], rolling[i];
  return result;
}

double positive_or_one(double c) { return c > 0 ? c : 1; }

}  // namespace

oracle::ConeProblem split_rolling(const SparseMatrix& w, const VectorXd& q, const VectorXd& mu, const VectorXd& rolling,
                                  std::optional<oracle::Bilateral> joints) {
  const Index n = mu.size();
  Triplets triplets = entries_of(w, true, true);
  for (Index i = 0; i < n; ++i) {
    const double c = positive_or_one(w.coeff(5 * i, 5 * i));
    const Index a = 6 * i, b = a + 3;
    for (const auto& [row, column, value] : {std::tuple(a, a, c), {a, b, -c}, {b, a, -c}, {b, b, c}})
      triplets.emplace_back(row, column, value);
  }
  if (joints) joints->v = from_triplets(6 * n, joints->v.cols(), entries_of(joints->v, true, false));
  return {oracle::block_matrix(from_triplets(6 * n, 6 * n, triplets)),
          split_rows(q),
          alternating(mu, rolling),
          std::move(joints),
          {}};
}

oracle::GlobalConeProblem split_rolling(const oracle::GlobalConeProblem& problem, const VectorXd& rolling) {
  const Index n = problem.mu.size(), velocities = problem.m.rows();
  Triplets masses = entries_of(problem.m, false, false), h = entries_of(problem.h, false, true);
  const VectorXd diagonal = problem.m.diagonal();
  for (Index i = 0; i < n; ++i) {
    double mobility = 0;  // of the normal, were M diagonal: the size of c does not matter, its order may
    for (SparseMatrix::InnerIterator entry(problem.h, 5 * i); entry; ++entry)
      mobility += entry.value() * entry.value() / diagonal[entry.row()];
    masses.emplace_back(velocities + i, velocities + i, 1 / positive_or_one(mobility));
    h.emplace_back(velocities + i, 6 * i, 1.0);
    h.emplace_back(velocities + i, 6 * i + 3, -1.0);
  }
  oracle::GlobalConeProblem result;
  result.m = from_triplets(velocities + n, velocities + n, masses);
  result.h = from_triplets(velocities + n, 6 * n, h);
  result.f = VectorXd::Zero(velocities + n);
  result.f.head(velocities) = problem.f;
  result.w = split_rows(problem.w);
  result.mu = alternating(problem.mu, rolling);
  result.g = from_triplets(velocities + n, problem.g.cols(), entries_of(problem.g, false, false));
  result.b = problem.b;
  result.first = problem.first;
  return result;
}

VectorXd split_impulses(const VectorXd& r) {
  VectorXd result = split_rows(r);
  for (Index i = 0; i < result.size(); i += 6) result[i + 3] = result[i];
  return result;
}

VectorXd joined_impulses(const VectorXd& r) { return joined_rows(r); }

VectorXd joined_velocities(const VectorXd& u) {
  VectorXd result = joined_rows(u);
  for (Index i = 0; i < u.size() / 6; ++i) result[5 * i] += u[6 * i + 3];
  return result;
}

}  // namespace lockstep
