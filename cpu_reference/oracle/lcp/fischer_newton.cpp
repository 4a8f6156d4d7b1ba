// Newton's method on Fischer's function (survey 4.3): a and b solve 0 <= a, 0 <= b, a b = 0 if and only if
//   phi(a, b) = sqrt(a^2 + b^2) - a - b = 0.
// A row with bounds 0 and infinity asks for phi(z_i, w_i) = 0, a free row for w_i = 0: F(z) = 0, in the scaled problem.
//   J = diag(a) + diag(b) M,   a_i = z_i / |(z_i, w_i)| - 1,   b_i = w_i / |(z_i, w_i)| - 1,
// and where z_i = w_i = 0, both are 1 / sqrt(2) - 1, a member of the generalised Jacobian. J d = -F gives the
// direction; the merit Psi = 1/2 |F|^2 has the gradient J^T F, so that its slope along d is -2 Psi, and along -J^T F it
// falls as well, the way out where J is singular. The step t is the first of 1, 1/2, 1/4, ... with Armijo's
//   Psi(z + t d) <= Psi(z) + c t grad Psi . d.
// The t on the left is missing in the survey's (77): without it halving t changes only the right side, which rises to
// Psi(z), and the test says nothing about the step that is taken. With it some t passes whenever the slope is negative:
// Psi(z + t d) = Psi + t grad Psi . d + o(t), and c < 1.
#include <cmath>
#include <limits>

#include "cpu_reference/oracle/dense.hpp"
#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "cpu_reference/oracle/lcp/watch.hpp"

namespace lockstep::oracle::lcp {

namespace {

constexpr double sufficient_decrease = 1e-4;  // c
constexpr double shortest_step = 0x1p-40;

// F and J of a problem in which `free` rows are equations.
struct Fischer {
  const MatrixXd& m;
  const VectorXd& q;
  const std::vector<bool>& free;

  VectorXd value(const VectorXd& z) const {
    VectorXd f = m * z + q;
    for (Index i = 0; i < z.size(); ++i) {
      if (!free[std::size_t(i)]) f[i] = std::hypot(z[i], f[i]) - z[i] - f[i];
    }
    return f;
  }

  MatrixXd jacobian(const VectorXd& z) const {
    const VectorXd w = m * z + q;
    MatrixXd j = m;
    for (Index i = 0; i < z.size(); ++i) {
      if (free[std::size_t(i)]) continue;
      const double length = std::hypot(z[i], w[i]), both = std::sqrt(0.5);
      const double a = (length > 0 ? z[i] / length : both) - 1, b = (length > 0 ? w[i] / length : both) - 1;
      j.row(i) *= b;
      j(i, i) += a;
    }
    return j;
  }
};

// Goes along d by the first step that Armijo's condition accepts. False where none does.
bool search_line(const Fischer& fischer, const VectorXd& f, double slope, const VectorXd& d, VectorXd& z) {
  if (!(slope < 0)) return false;
  const double merit = 0.5 * f.squaredNorm();
  for (double t = 1; t >= shortest_step; t /= 2) {
    const VectorXd next = z + t * d;
    if (0.5 * fischer.value(next).squaredNorm() <= merit + sufficient_decrease * t * slope) {
      z = next;
      return true;
    }
  }
  return false;
}

}  // namespace

SolveReport fischer_newton(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z) {
  Watch watch(problem, limits);
  const Index n = problem.size();
  std::vector<bool> free(static_cast<std::size_t>(n));
  bool takes_all = !problem.has_friction();
  for (Index i = 0; i < n; ++i) {
    free[std::size_t(i)] = std::isinf(problem.low[i]) && std::isinf(problem.high[i]);
    takes_all = takes_all && (free[std::size_t(i)] || (problem.low[i] == 0 && std::isinf(problem.high[i])));
  }
  start_from(z, n);
  if (watch.start(z)) return watch.finish(z);
  if (!takes_all) {
    watch.end(Stop::stalled);  // out of its reach
    return watch.finish(z);
  }
  const VectorXd& s = watch.measure().scale();
  const MatrixXd m = s.asDiagonal() * problem.m * s.asDiagonal();
  VectorXd q = s.cwiseProduct(problem.q);
  const double unit = q.cwiseAbs().maxCoeff() > 0 ? q.cwiseAbs().maxCoeff() : 1;
  q /= unit;
  const Fischer fischer = {m, q, free};
  VectorXd x = z.cwiseQuotient(s) / unit;
  while (true) {
    const VectorXd f = fischer.value(x);
    const MatrixXd j = fischer.jacobian(x);
    const VectorXd gradient = j.transpose() * f, d = solve_or_least_norm(j, -f, 1e-14);
    if (!search_line(fischer, f, gradient.dot(d), d, x) &&
        !search_line(fischer, f, -gradient.squaredNorm(), -gradient, x)) {
      watch.end(Stop::stalled);  // Psi is stationary, or rounding hides its fall
      break;
    }
    VectorXd found = unit * x.cwiseProduct(s);
    for (Index i = 0; i < n; ++i) {
      if (!free[std::size_t(i)]) found[i] = std::max(found[i], 0.0);
    }
    if (watch.stop_after(found)) break;
  }
  return watch.finish(z);
}

SolveReport fischer_newton(const Lcp& problem, const SolveLimits& limits, VectorXd& z) {
  return fischer_newton(boxed(problem), limits, z);
}

}  // namespace lockstep::oracle::lcp
