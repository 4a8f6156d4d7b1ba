// Lemke's complementary pivoting (Cottle, Pang, Stone 1992, algorithm 4.4.1). An artificial variable z_0 makes
//   w - M z - d z_0 = q,   d > 0,
// feasible; then the complement of what left the basis enters it, until z_0 leaves. The ratio test is lexicographic
// (section 4.9 there): ties between the right-hand sides are broken by the rows of B^-1, so that no basis comes back.
// Where nothing blocks what enters, the path ends in a secondary ray; for a copositive-plus matrix that proves that
// w >= 0, z >= 0 cannot be (theorem 4.4.11). The tableau is made anew from the basis now and then, against rounding.
#include <Eigen/LU>

#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "cpu_reference/oracle/lcp/watch.hpp"

namespace lockstep::oracle::lcp {

namespace {

constexpr std::uint32_t refresh_every = 100;  // pivots
constexpr double smallest_pivot = 1e-10;
constexpr double tie = 1e-12;

// B^-1 [ 1  -M  -d | q ]: columns w_0 .. w_n-1, z_0 .. z_n-1, the artificial variable, the right-hand side.
class Tableau {
 public:
  explicit Tableau(const Lcp& p) : n_(p.size()), original_(n_, 2 * n_ + 2), basis_(static_cast<std::size_t>(n_)) {
    original_ << MatrixXd::Identity(n_, n_), -p.m, VectorXd::Constant(n_, -1), p.q;
    now_ = original_;
    for (Index i = 0; i < n_; ++i) basis_[std::size_t(i)] = i;
  }

  Index artificial() const { return 2 * n_; }
  Index complement(Index variable) const { return variable < n_ ? variable + n_ : variable - n_; }
  double value(Index row) const { return now_(row, 2 * n_ + 1); }

  /// The row that lets the artificial variable in and keeps all others lexicographically positive: of the smallest q,
  /// the last among equals, for the rows of the identity break the tie.
  Index first_row() const {
    Index row = 0;
    for (Index i = 1; i < n_; ++i) {
      if (value(i) <= value(row)) row = i;
    }
    return row;
  }

  /// The row whose variable leaves when `column` enters; -1 where none does. The artificial variable goes first.
  Index leaving_row(Index column) const {
    std::vector<Index> rows;
    for (Index i = 0; i < n_; ++i) {
      if (now_(i, column) > smallest_pivot) rows.push_back(i);
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
    now_.row(row) /= now_(row, column);
    VectorXd factors = now_.col(column);
    factors[row] = 0;
    now_.noalias() -= factors * now_.row(row).eval();
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

 private:
  void keep_smallest(std::vector<Index>& rows, Index column, Index by) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Index i : rows) least = std::min(least, now_(i, by) / now_(i, column));
    std::erase_if(rows, [&](Index i) { return now_(i, by) / now_(i, column) > least + tie * (1 + std::abs(least)); });
  }

  void refresh() {
    const Eigen::PartialPivLU<MatrixXd> lu(MatrixXd(original_(Eigen::all, basis_)));
    now_ = lu.solve(original_);
  }

  Index n_;
  MatrixXd original_, now_;
  std::vector<Index> basis_;  // the variable of each row
  std::uint32_t pivots_ = 0;
};

}  // namespace

SolveReport lemke(const Lcp& problem, const SolveLimits& limits, VectorXd& z) {
  DirectSolve solve(problem, limits);
  const Index n = problem.size();
  if (n == 0 || solve.scaled().q.minCoeff() >= 0) return solve.finish(VectorXd::Zero(n), Stop::stall, z);
  Tableau tableau(solve.scaled());
  Index row = tableau.first_row(), entering = tableau.artificial();
  while (solve.may_pivot()) {
    const Index left = tableau.pivot(row, entering);
    if (left == tableau.artificial()) return solve.finish(tableau.z(), Stop::stall, z);
    entering = tableau.complement(left);
    row = tableau.leaving_row(entering);
    if (row < 0) return solve.finish(tableau.z(), Stop::infeasible, z);
  }
  return solve.finish(tableau.z(), Stop::limit, z);
}

}  // namespace lockstep::oracle::lcp
