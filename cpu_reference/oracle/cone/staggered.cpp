// Staggered projections (Kaufman, Sueda, James, Pai 2008; Haslinger's fixed point on the friction bounds): in turn
//   normal    r_n = argmin 1/2 r_n W_nn r_n + (q_n + W_nt r_t) r_n,  r_n >= 0
//   friction  r_t = argmin 1/2 r_t W_tt r_t + (q_t + W_tn r_n) r_t,  |r_t,i| <= mu_i r_n,i
// each a convex quadratic programme, solved by Gauss-Seidel from where it was left, as accurately as the whole needs by
// then. A fixed point solves the contact problem; that there is convergence to one is not promised.
#include <algorithm>
#include <cmath>
#include <vector>

#include "cpu_reference/oracle/cone/cone.hpp"
#include "cpu_reference/oracle/cone/solvers.hpp"
#include "cpu_reference/oracle/cone/start.hpp"
#include "cpu_reference/oracle/cone/watch.hpp"
#include "cpu_reference/oracle/dense.hpp"
#include "host/stop_request.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::uint32_t most_sweeps = 200;

// min 1/2 t A t + b t over the disc of a radius: (A + lambda) t = -b with lambda >= 0, |t| = radius where lambda > 0.
// 1 / |t| is nearly a straight line of lambda (More and Sorensen 1983).
class Disc {
 public:
  explicit Disc(const Matrix2d& a) : eigen_(symmetric_eigen<2>(a)) {}

  Vector2d solve(const Vector2d& b_world, double radius) const {
    if (radius <= 0 || eigen_.values[1] <= 0) return Vector2d::Zero();
    const Vector2d b = eigen_.vectors.transpose() * b_world;
    const double least = 1e-13 * eigen_.values[1];
    double lambda = std::max(0.0, least - eigen_.values[0]);
    Vector2d t;
    for (int iteration = 0; iteration < 50; ++iteration) {
      const Vector2d a = eigen_.values.array() + lambda;
      t = -b.cwiseQuotient(a);
      const double length = t.norm();
      if (length <= radius * (1 + 1e-15)) break;
      // the function is convex and the iteration comes from the left: no safeguard is needed
      lambda += (length / radius - 1) * length * length / (t.array().square() / a.array()).sum();
    }
    return eigen_.vectors * project_on_disc(t, radius);
  }

 private:
  SymmetricEigen<2> eigen_;
};

// The two programmes; a sweep returns the sum of squares of the changes of velocity that it made of its own rows.
class Halves {
 public:
  explicit Halves(const ConeProblem& problem) : problem_(problem) {
    discs_.reserve(problem.contacts());
    for (std::uint32_t i = 0; i < problem.contacts(); ++i)
      discs_.emplace_back(Matrix2d(problem.w.symmetric_diagonal(i).bottomRightCorner<2, 2>()));
  }

  double sweep_normal(VectorXd& r) const {
    double sum = 0;
    for (std::uint32_t i = 0; i < problem_.contacts(); ++i) {
      const double mobility = problem_.w.on_diagonal(i)(0, 0);
      if (mobility <= 0) continue;
      const double u = problem_.q[3 * i] + problem_.w.row_times(i, r)[0];
      const double change = std::max(0.0, r[3 * i] - u / mobility) - r[3 * i];
      r[3 * i] += change;
      sum += change * change * mobility * mobility;
    }
    return sum;
  }

  double sweep_friction(VectorXd& r) const {
    double sum = 0;
    for (std::uint32_t i = 0; i < problem_.contacts(); ++i) {
      const Matrix2d a = problem_.w.symmetric_diagonal(i).bottomRightCorner<2, 2>();
      const Vector2d own = r.segment<2>(3 * i + 1);
      const Vector2d u = problem_.q.segment<2>(3 * i + 1) + problem_.w.row_times(i, r).tail<2>();
      const Vector2d change = discs_[i].solve(u - a * own, problem_.mu[i] * r[3 * i]) - own;
      r.segment<2>(3 * i + 1) += change;
      sum += (a * change).squaredNorm();
    }
    return sum;
  }

 private:
  const ConeProblem& problem_;
  std::vector<Disc> discs_;
};

}  // namespace

SolveReport staggered(const ConeProblem& problem, const SolveLimits& limits, VectorXd& r) {
  Watch watch(problem, limits, 100);
  VectorXd x = start_of(problem, r);
  const Halves halves(problem);
  for (std::uint32_t round = 1; !watch.look(x, round - 1); ++round) {
    const double wanted = 0.01 * watch.residual() * problem.q.norm();
    for (std::uint32_t k = 0; k < most_sweeps && !stop_asked() && std::sqrt(halves.sweep_normal(x)) > wanted; ++k) {
    }
    for (std::uint32_t k = 0; k < most_sweeps && !stop_asked() && std::sqrt(halves.sweep_friction(x)) > wanted; ++k) {
    }
  }
  return watch.finish(r);
}

}  // namespace lockstep::oracle
