// Baraff's incremental pivoting (Baraff 1994, "Fast contact force computation for nonpenetrating rigid bodies"; the
// principal pivoting of Dantzig and Cottle), in a box. Rows are taken up one by one. A row that was taken up keeps its
// law: it is free (w = 0), at its lower bound (w >= 0) or at its upper one (w <= 0). To take up row r, z_r is driven
// against w_r, and the free rows A answer,
//   z_A' = -M_AA^-1 M_Ar z_r',   w' = M_.r z_r' + M_.A z_A',
// until w_r = 0 or z_r meets its bound; where a free row meets a bound, or the w of a bound one reaches 0, it changes
// sides, and r drives on. M_AA is kept factored. Ties go to r, then to the least index.
// For a P matrix |w_r| falls throughout, so that no set comes back; for a symmetric positive semidefinite one a row
// whose w_r does not move is stopped by the others, or shows that there is no solution. Bounds that hang on a normal
// are frozen, and frozen anew after each solve until they stay: exact where that settles, which needs little friction
// or little coupling.
#include <cmath>

#include "cpu_reference/oracle/lcp/certificate.hpp"
#include "cpu_reference/oracle/lcp/principal_factor.hpp"
#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "cpu_reference/oracle/lcp/watch.hpp"

namespace lockstep::oracle::lcp {

namespace {

constexpr double singular = 1e-11;
constexpr int most_freezes = 200;

// What stops a drive, and when.
struct Event {
  double step = infinity;
  Index row = -1;
  bool at_bound = false;  // z reaches a bound; else w reaches 0
  double bound = 0;

  void offer(double t, Index i, bool meets_bound, double where) {
    t = std::max(t, 0.0);
    if (t < step) *this = {t, i, meets_bound, where};
  }
};

enum class Side { waiting, low, high, free };

class Pivoting {
 public:
  // `low`, `high` in the scaled problem.
  Pivoting(DirectSolve& solve, VectorXd low, VectorXd high)
      : solve_(solve),
        p_(solve.scaled()),
        low_(std::move(low)),
        high_(std::move(high)),
        factor_(p_.m, singular),
        side_(std::size_t(p_.size()), Side::waiting),
        x_(VectorXd::Zero(p_.size()).cwiseMax(low_).cwiseMin(high_)),
        w_(p_.m * x_ + p_.q) {}

  /// `solved` where all rows keep their law.
  Stop run() {
    while (true) {
      const Index r = worst_waiting();
      if (r < 0) return Stop::solved;
      const Stop why = take_up(r);
      if (why != Stop::solved) return why;
    }
  }

  const VectorXd& x() const { return x_; }

 private:
  // The waiting row that breaks its law most, -1 where none does.
  Index worst_waiting() const {
    Index worst = -1;
    double most = solve_.zero();
    for (Index i = 0; i < p_.size(); ++i) {
      if (side_[std::size_t(i)] != Side::waiting) continue;
      const double wrong = w_[i] < 0 ? (x_[i] < high_[i] ? -w_[i] : 0) : (x_[i] > low_[i] ? w_[i] : 0);
      if (wrong > most) {
        most = wrong;
        worst = i;
      }
    }
    return worst;
  }

  Event next_event(Index r, double sign, const VectorXd& rate_a, const VectorXd& rate_w) const {
    const std::vector<Index>& a = factor_.set();
    Event event;
    if (sign * rate_w[r] > singular) event.offer(-w_[r] / rate_w[r], r, false, 0);
    const double bound = sign > 0 ? high_[r] : low_[r];
    event.offer(sign * (bound - x_[r]), r, true, bound);

    Event other;
    const auto offer = [&](double t, Index i, bool meets_bound, double where) {
      if (t < other.step || (t == other.step && i < other.row)) other.offer(t, i, meets_bound, where);
    };
    for (Index k = 0; k < Index(a.size()); ++k) {
      const Index i = a[std::size_t(k)];
      if (rate_a[k] > singular) offer((high_[i] - x_[i]) / rate_a[k], i, true, high_[i]);
      if (rate_a[k] < -singular) offer((low_[i] - x_[i]) / rate_a[k], i, true, low_[i]);
    }
    for (Index i = 0; i < p_.size(); ++i) {
      const Side side = side_[std::size_t(i)];
      if (low_[i] == high_[i] || dependent_[std::size_t(i)]) continue;  // w may have any sign; or stays 0
      if ((side == Side::low && rate_w[i] < -singular) || (side == Side::high && rate_w[i] > singular))
        offer(-w_[i] / rate_w[i], i, false, 0);
    }
    return other.step < event.step ? other : event;
  }

  Stop take_up(Index r) {
    const double sign = w_[r] < 0 ? 1 : -1;
    dependent_.assign(std::size_t(p_.size()), false);
    while (solve_.may_pivot()) {
      const std::vector<Index> a = factor_.set();
      const VectorXd rate_a = factor_.solve(-sign * p_.m(a, r));
      const VectorXd rate_w = sign * p_.m.col(r) + p_.m(Eigen::all, a) * rate_a;
      const Event event = next_event(r, sign, rate_a, rate_w);
      if (event.step == infinity) {
        VectorXd ray = VectorXd::Zero(p_.size());
        ray(a) = rate_a;
        ray[r] = sign;
        return proves_infeasible(p_, low_, high_, ray) ? Stop::infeasible : Stop::stalled;
      }
      x_(a) += event.step * rate_a;
      x_[r] += event.step * sign;
      w_ += event.step * rate_w;
      w_(a).setZero();
      if (event.at_bound) {
        x_[event.row] = event.bound;
        side_[std::size_t(event.row)] = event.bound == low_[event.row] ? Side::low : Side::high;
        if (event.row != r) factor_.remove(std::find(a.begin(), a.end(), event.row) - a.begin());
      } else {
        w_[event.row] = 0;
        if (factor_.append(event.row)) {
          side_[std::size_t(event.row)] = Side::free;
        } else if (symmetric_ && event.row != r) {
          dependent_[std::size_t(event.row)] = true;
        } else {
          return Stop::stalled;  // neither a P matrix nor a symmetric one
        }
      }
      if (event.row == r) {
        solve_for_free_rows();
        return Stop::solved;
      }
    }
    return Stop::limit;
  }

  // x_A and w anew, from the matrix: rounding does not add up.
  void solve_for_free_rows() {
    const std::vector<Index>& a = factor_.set();
    x_(a).setZero();
    const VectorXd rest = p_.m * x_ + p_.q;
    x_(a) = factor_.solve(-rest(a)).cwiseMax(low_(a)).cwiseMin(high_(a));
    w_ = p_.m * x_ + p_.q;
    w_(a).setZero();
  }

  DirectSolve& solve_;
  const Lcp& p_;
  bool symmetric_ = p_.m.isApprox(p_.m.transpose(), 1e-13);
  VectorXd low_, high_;
  PrincipalFactor factor_;
  std::vector<Side> side_;
  std::vector<bool> dependent_;
  VectorXd x_, w_;
};

}  // namespace

SolveReport baraff(const Lcp& problem, const SolveLimits& limits, VectorXd& z) {
  DirectSolve solve(problem, limits);
  const Index n = problem.size();
  Pivoting pivoting(solve, VectorXd::Zero(n), VectorXd::Constant(n, infinity));
  const Stop why = pivoting.run();
  return solve.finish(pivoting.x(), why == Stop::solved ? Stop::stalled : why, z);
}

SolveReport baraff(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z) {
  const Measure measure(problem);
  const Index n = problem.size();
  const Lcp unbounded = {problem.m, problem.q};
  DirectSolve solve(unbounded, limits);
  SolveReport report;
  report.residual = infinity;
  VectorXd current = VectorXd::Zero(n);
  z = current;
  for (int freeze = 0; freeze < most_freezes; ++freeze) {
    VectorXd low(n), high(n);
    for (Index i = 0; i < n; ++i) {
      const double size = measure.scale()[i] * solve.unit();
      low[i] = problem.low_at(i, current) / size;
      high[i] = problem.high_at(i, current) / size;
    }
    Pivoting pivoting(solve, low, high);
    const Stop why = pivoting.run();
    current = solve.unit() * pivoting.x().cwiseProduct(measure.scale());
    const double found = measure(current);
    report.residuals.push_back(found);
    const bool better = found < report.residual;
    if (better) {
      z = current;
      report.residual = found;
    }
    // what is shown with frozen bounds is shown of them alone
    const bool is_of_frozen = why == Stop::infeasible && problem.has_friction();
    report.stop = why == Stop::solved || is_of_frozen ? Stop::stalled : why;
    if (report.residual <= limits.tolerance) report.stop = Stop::solved;
    if (report.stop != Stop::stalled || is_of_frozen || !problem.has_friction()) break;
  }
  report.iterations = solve.pivots();
  report.seconds = solve.seconds();
  return report;
}

}  // namespace lockstep::oracle::lcp
