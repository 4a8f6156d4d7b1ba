// Random complementarity problems of known kinds, for the tests of their solvers.
#pragma once

#include <Eigen/Core>
#include <random>
#include <string>
#include <utility>

#include "cpu_reference/oracle/lcp/solvers.hpp"

namespace lockstep::oracle::lcp::test {

class Random {
 public:
  explicit Random(unsigned seed) : bits_(seed) {}
  double between(double low, double high) { return low + (high - low) * (bits_() >> 8) / 16777216.0; }
  VectorXd vector(Index n) {
    return VectorXd::NullaryExpr(n, [&] { return between(-1, 1); });
  }
  MatrixXd matrix(Index rows, Index columns) {
    return MatrixXd::NullaryExpr(rows, columns, [&] { return between(-1, 1); });
  }

 private:
  std::mt19937 bits_;
};

/// Positive definite: a P matrix; `skew` makes it unsymmetric.
inline Lcp random_p_matrix(Random& random, Index n, double skew) {
  const MatrixXd a = random.matrix(n, n), b = random.matrix(n, n);
  const MatrixXd m = a * a.transpose() / double(n) + 0.1 * MatrixXd::Identity(n, n) + skew * (b - b.transpose());
  return {m, random.vector(n)};
}

/// Symmetric, positive semidefinite, of this rank, with a solution: half of the unknowns of it positive, a quarter of
/// the rows degenerate (z = w = 0). The unknowns are not unique, w is.
inline Lcp random_degenerate(Random& random, Index n, Index rank) {
  const MatrixXd a = random.matrix(n, rank);
  VectorXd z = VectorXd::Zero(n), w = VectorXd::Zero(n);
  for (Index i = 0; i < n; ++i) {
    if (i % 4 < 2) z[i] = random.between(0.1, 1);
    if (i % 4 == 2) w[i] = random.between(0.1, 1);
  }
  const MatrixXd m = a * a.transpose();
  return {m, w - m * z};
}

/// Murty's matrix: 1 on the diagonal, 2 above it, q = -1 (1988, chapter 6).
inline Lcp murty_exponential(Index n) {
  MatrixXd m = MatrixXd::Identity(n, n);
  for (Index j = 0; j < n; ++j) m.col(j).head(j).setConstant(2);
  return {m, -VectorXd::Ones(n)};
}

struct Solved {
  VectorXd z;
  SolveReport report;
};

template <class Problem, class Method>
Solved solve(Method method, const Problem& problem, const SolveLimits& limits = {.tolerance = 1e-11}) {
  Solved s;
  s.report = method(problem, limits, s.z);
  return s;
}

inline const NamedSolver& solver(std::string_view name) {
  for (const NamedSolver& s : solvers()) {
    if (s.name == name) return s;
  }
  throw std::out_of_range(std::string(name));
}

}  // namespace lockstep::oracle::lcp::test
