// Lemke's complementary pivoting (Cottle, Pang, Stone 1992, algorithm 4.4.1). An artificial variable z_0 makes
//   w - M z - d z_0 = q,   d > 0,
// feasible; then the complement of what left the basis enters it, until z_0 leaves. The ratio test is lexicographic
// (section 4.9 there): ties between the right-hand sides are broken by the rows of B^-1, so that no basis comes back.
// Where nothing blocks what enters, the path ends in a secondary ray; for a copositive-plus matrix its z part proves
// that w >= 0, z >= 0 cannot be (theorem 4.4.11), and whatever the matrix, that is looked at (certificate.hpp). The
// tableau is made anew from the basis now and then, against rounding.
//
// Scenes with more contacts than degrees of freedom have singular matrices and ties everywhere. What should be 0 is
// then rounding, a pivot on it spoils the tableau, and the path ends in a ray that is none, or in a basis that solves
// nothing. So pivots below 1e-6 are not made, and a path that did not arrive is tried again with another covering
// vector d.
#include <cmath>
#include <limits>

#include "cpu_reference/oracle/dense.hpp"
#include "cpu_reference/oracle/lcp/certificate.hpp"
#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "cpu_reference/oracle/lcp/watch.hpp"

namespace lockstep::oracle::lcp {

namespace {

constexpr std::uint32_t refresh_every = 100;  // pivots
constexpr double smallest_pivot = 1e-6;
constexpr double tie = 1e-10;
constexpr int most_paths = 8;

// d: 1, then vectors between 1 and 2 that break ties, of the fractions of multiples of the golden ratio.
VectorXd covering_vector(Index n, int path) {
  constexpr double golden = 0.6180339887498949;
  VectorXd d = VectorXd::Ones(n);
  for (Index i = 0; i < n && path > 0; ++i) d[i] += std::fmod(golden * double(i + 1) * (1 + path), 1.0);
  return d;
}

// B^-1 [ 1  -M  -d | q ]: columns w_0 .. w_n-1, z_0 .. z_n-1, the artificial variable, the right-hand side.
class Tableau {
 public:
  Tableau(const Lcp& p, const VectorXd& d)
      : n_(p.size()), original_(n_, 2 * n_ + 2), basis_(static_cast<std::size_t>(n_)) {
    original_ << MatrixXd::Identity(n_, n_), -p.m, -d, p.q;
    current_ = original_;
    for (Index i = 0; i < n_; ++i) basis_[std::size_t(i)] = i;
  }

  Index artificial() const { return 2 * n_; }
  Index complement(Index variable) const { return variable < n_ ? variable + n_ : variable - n_; }
  double value(Index row) const { return current_(row, 2 * n_ + 1); }

  /// The row that lets the artificial variable in and keeps all others lexicographically positive: of the smallest q /
  /// d, the last among equals, for the rows of the identity break the tie.
  Index first_row() const {
    Index row = 0;
    const auto ratio = [&](Index i) { return -value(i) / current_(i, artificial()); };
    for (Index i = 1; i < n_; ++i) {
      if (ratio(i) <= ratio(row)) row = i;
    }
    return row;
  }

  /// The row whose variable leaves when `column` enters; -1 where none does. The artificial variable goes first.
  Index leaving_row(Index column) const {
    std::vector<Index> rows;
    for (Index i = 0; i < n_; ++i) {
      if (current_(i, column) > smallest_pivot) rows.push_back(i);
    }
    keep_smallest(rows, column, 2 * n_ + 1);
    for (const Index i : rows) {
      if (basis_[std::size_t(i)] == artificial()) return i;
    }
    for (Index k = 0; k < n_ && rows.size() > 1; ++k) keep_smallest(rows, column, k);
    return rows.empty() ? -1 : rows.front();
  }

  /// `column` enters in this row; what leaves is returned.
  Index pivot(Index row, Index column) {
    current_.row(row) /= current_(row, column);
    VectorXd factors = current_.col(column);
    factors[row] = 0;
    current_.noalias() -= factors * current_.row(row).eval();
    std::swap(basis_[std::size_t(row)], column);
    if (++pivots_ % refresh_every == 0) refresh();
    return column;
  }

  VectorXd z() const {
    VectorXd z = VectorXd::Zero(n_);
    for (Index i = 0; i < n_; ++i) {
      const Index variable = basis_[std::size_t(i)];
      if (variable >= n_ && variable < 2 * n_) z[variable - n_] = std::max(0.0, value(i));
    }
    return z;
  }

  /// How z moves while `column` enters and nothing blocks it.
  VectorXd ray(Index column) const {
    VectorXd z = VectorXd::Zero(n_);
    for (Index i = 0; i < n_; ++i) {
      const Index variable = basis_[std::size_t(i)];
      if (variable >= n_ && variable < 2 * n_) z[variable - n_] = std::max(0.0, -current_(i, column));
    }
    if (column >= n_ && column < 2 * n_) z[column - n_] = 1;
    return z;
  }

 private:
  void keep_smallest(std::vector<Index>& rows, Index column, Index by) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Index i : rows) least = std::min(least, current_(i, by) / current_(i, column));
    std::erase_if(rows,
                  [&](Index i) { return current_(i, by) / current_(i, column) > least + tie * (1 + std::abs(least)); });
  }

  void refresh() { current_ = solve_by_lu(original_(Eigen::all, basis_), original_); }

  Index n_;
  MatrixXd original_, current_;
  std::vector<Index> basis_;  // the variable of each row
  std::uint32_t pivots_ = 0;
};

// One path. `stalled` where the artificial variable left, the tableau's z is then to solve the problem; and where it
// ends in a ray that proves nothing.
Stop follow_path(DirectSolve& solve, int path, VectorXd& x) {
  Tableau tableau(solve.scaled(), covering_vector(solve.scaled().size(), path));
  Index row = tableau.first_row(), entering = tableau.artificial();
  Stop why = Stop::limit;
  while (solve.may_pivot()) {
    const Index left = tableau.pivot(row, entering);
    why = Stop::stalled;
    if (left == tableau.artificial()) break;
    entering = tableau.complement(left);
    row = tableau.leaving_row(entering);
    if (row < 0) {
      if (proves_infeasible(solve.scaled(), tableau.ray(entering))) why = Stop::infeasible;
      break;
    }
    why = Stop::limit;
  }
  x = tableau.z();
  return why;
}

}  // namespace

SolveReport lemke(const Lcp& problem, const SolveLimits& limits, VectorXd& z) {
  DirectSolve solve(problem, limits);
  const Index n = problem.size();
  if (n == 0 || solve.scaled().q.minCoeff() >= 0) return solve.finish(VectorXd::Zero(n), Stop::stalled, z);
  SolveReport best;
  for (int path = 0; path < most_paths; ++path) {
    VectorXd x, found;
    const Stop why = follow_path(solve, path, x);
    const SolveReport report = solve.finish(x, why, found);
    if (path == 0 || report.residual < best.residual) {
      best = report;
      z = found;
    }
    if (report.stop == Stop::solved) break;
    best.stop = why;
    if (why != Stop::stalled) break;
  }
  best.iterations = solve.pivots();
  best.seconds = solve.seconds();
  return best;
}

}  // namespace lockstep::oracle::lcp
