// Accelerated projected gradient (Mazhar, Heyn, Negrut, Tasora, "Using Nesterov's method to accelerate multibody
// dynamics with friction and contact", ACM TOG 2015) with its line search and its restarts (O'Donoghue, Candes):
//   x_k+1 = P_K(y_k - step rho g(y_k)),   y_k+1 = x_k+1 + beta (x_k+1 - x_k),   g = W y + q + shift
//   theta_k+1^2 = (1 - theta_k+1) theta_k^2,   beta = theta_k (1 - theta_k) / (theta_k^2 + theta_k+1)
// Without shift this solves the cone complementarity problem (Tasora and Anitescu 2011), a convex relaxation in which
// contacts lift by mu |u_t| as they slide. With De Saxce's shift mu |u_t| as a fixed point around it, Coulomb's law;
// the shift is moved part of the way where whole moves go in circles.
#include <algorithm>
#include <cmath>
#include <limits>

#include "cpu_reference/oracle/cone/gradient.hpp"
#include "cpu_reference/oracle/cone/solvers.hpp"
#include "cpu_reference/oracle/cone/start.hpp"
#include "cpu_reference/oracle/cone/watch.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// rms of the defect velocity of the convex problem with this shift, over U
double convex_residual(const ConeProblem& problem, const VectorXd& mobility, const VectorXd& r, const VectorXd& u,
                       const VectorXd& shift) {
  double sum = 0;
  for (std::uint32_t i = 0; i < problem.contacts(); ++i) {
    if (mobility[i] <= 0) continue;
    const Vector3d r_i = r.segment<3>(3 * i), g = u.segment<3>(3 * i) + shift.segment<3>(3 * i);
    sum += (mobility[i] * (r_i - project_on_cone(r_i - g / mobility[i], problem.mu[i]))).squaredNorm();
  }
  return problem.q.norm() > 0 ? std::sqrt(sum) / problem.q.norm() : 0;
}

}  // namespace

SolveReport accelerated_gradient(const ConeProblem& problem, const SolveLimits& limits, VectorXd& r, bool relaxed) {
  Watch watch(problem, limits);
  const VectorXd& mobility = watch.meter().mobility();
  VectorXd x = start_of(problem, r), w_x = problem.w.times(x), y = x, w_y = w_x;
  VectorXd shift = VectorXd::Zero(x.size());
  if (!relaxed) shift = de_saxce_shift(problem, w_x + problem.q);
  double theta = 1, step = 1, blend = 1, at_last_shift = std::numeric_limits<double>::infinity();
  bool done = watch.look(x, 0);
  for (std::uint32_t iteration = 1; !done; ++iteration) {
    const VectorXd g = w_y + problem.q + shift;
    VectorXd next, w_next;
    for (;; step *= 0.5) {
      next = gradient_step(problem, mobility, y, g, step);
      w_next = problem.w.times(next);
      const VectorXd d = next - y;
      if (d.dot(w_next - w_y) <= squared_length(mobility, d) / step || step < 1e-12) break;
    }
    const double theta_next = 0.5 * (std::sqrt(theta * theta * (theta * theta + 4)) - theta * theta);
    double beta = theta * (1 - theta) / (theta * theta + theta_next);
    theta = theta_next;
    if (g.dot(next - x) > 0) {  // uphill: the momentum has led astray
      beta = 0;
      theta = 1;
    }
    y = next + beta * (next - x);
    w_y = w_next + beta * (w_next - w_x);
    x = next;
    w_x = w_next;
    step *= 1.1;

    done = watch.look_seldom(x, iteration);
    if (iteration % 5 != 0 || done) continue;
    const VectorXd u = w_x + problem.q;
    const double convex = convex_residual(problem, mobility, x, u, shift);
    if (relaxed) {  // what the watch sees includes what the relaxation costs
      done = convex <= limits.tolerance;
      if (done) watch.look(x, iteration);
    } else if (const double current = watch.meter().residual(x, u); convex < 0.3 * current) {
      blend = current < 0.9 * at_last_shift ? std::min(1.0, 1.5 * blend) : std::max(0.05, 0.5 * blend);
      at_last_shift = current;
      shift += blend * (de_saxce_shift(problem, u) - shift);
      y = x;
      w_y = w_x;
      theta = 1;
    }
  }
  SolveReport report = watch.finish(r);
  if (relaxed) {  // its own solution, which is not that of Coulomb's law
    r = x;
    report.residual = watch.meter().residual(x, w_x + problem.q);
    const bool solved = report.iterations < limits.iterations && report.seconds < limits.seconds;
    report.stop = report.residual <= limits.tolerance ? Stop::solved : solved ? Stop::stalled : Stop::limit;
  }
  return report;
}

}  // namespace lockstep::oracle
