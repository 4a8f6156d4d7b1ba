// Linear complementarity problems, plain and boxed, and how far a vector is from solving one. Dense, in double.
// Theory: Cottle, Pang, Stone, "The Linear Complementarity Problem" (1992); Murty, "Linear Complementarity, Linear and
// Nonlinear Programming" (1988). docs/theory/lcp.md says which solver to take.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "cpu_reference/oracle/solve.hpp"

namespace lockstep::oracle::lcp {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// w = M z + q,  0 <= z,  0 <= w,  z . w = 0.
struct Lcp {
  MatrixXd m;
  VectorXd q;

  Index size() const { return q.size(); }
};

/// w = M z + q,  low <= z <= high;  w_i >= 0 where z_i = low_i, w_i <= 0 where z_i = high_i, w_i = 0 between. Bounds
/// may be infinite. A row i whose `normal[i]` is another row n is bounded by it instead: |z_i| <= friction[i] z_n.
struct BoxedLcp {
  MatrixXd m;
  VectorXd q;
  VectorXd low, high;
  std::vector<Index> normal;  // or -1
  VectorXd friction;          // mu; 0 where there is no normal

  Index size() const { return q.size(); }
  bool has_friction() const;

  /// The bounds of row i while the unknowns are z.
  double low_at(Index i, const VectorXd& z) const;
  double high_at(Index i, const VectorXd& z) const;
};

/// The same problem with bounds 0 and infinity.
BoxedLcp boxed(const Lcp& problem);

/// Sizes s with which M_ij s_i s_j, q_i s_i and z_i / s_i have one unit: 1 / sqrt |M_ii|; where the diagonal is zero,
/// what makes the row's largest coupling to a row with a diagonal 1; else 1.
VectorXd natural_scale(const MatrixXd& m);

/// How far z is from solving a problem: max |F(z)| / |F(0)| with the natural map F_i = min(z_i / s_i, s_i w_i), in a
/// box z_i / s_i less its projection after a step by -s_i w_i: the share of the defect of no impulse at all that is
/// left. (Where 0 solves the problem, max |s q|, or else max |z / s|, takes the place of |F(0)|.) With s =
/// natural_scale it does not depend on the units of any row. The problem is kept by reference. Throws Error where sizes
/// do not match or a number is not finite.
class Measure {
 public:
  explicit Measure(const Lcp& problem);
  explicit Measure(const BoxedLcp& problem);
  double operator()(const VectorXd& z) const;
  const VectorXd& scale() const { return scale_; }

 private:
  VectorXd natural_map(const VectorXd& z) const;

  const MatrixXd& m_;
  const VectorXd& q_;
  const BoxedLcp* box_ = nullptr;
  VectorXd scale_;
  double unit_ = 0;
};

double residual(const Lcp& problem, const VectorXd& z);
double residual(const BoxedLcp& problem, const VectorXd& z);

/// z := the solution, from z where it has the right size (iterative methods), from 0 otherwise.
using Solver = SolveReport (*)(const Lcp& problem, const SolveLimits& limits, VectorXd& z);
using BoxedSolver = SolveReport (*)(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z);

}  // namespace lockstep::oracle::lcp
