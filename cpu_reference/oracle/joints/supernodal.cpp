// Joints by a parallel sparse direct solver, where the survey (section 5) names PARDISO: CHOLMOD's supernodal Cholesky
// factorisation of R (Chen, Davis, Hager, Rajamanickam, ACM TOMS 35, 2008), whose dense work is that of a BLAS with
// threads. R rather than the indefinite K, for R asks for no pivots: the pattern alone orders it. Loops need no care;
// redundant rows make R singular, and then R + delta is factorised and refined by
//   x <- x + (R + delta)^-1 (c - R x),
// which converges to a solution, for all that c has of the null space is rounding. Whether a singular R
// factorises by itself is rounding too, and impulses are then without bounds: its pivots tell.
#include <Eigen/CholmodSupport>
#include <stdexcept>

#include "cpu_reference/oracle/joints/joint_solver.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::VectorXd;

constexpr int most_refinements = 30;
constexpr double accuracy = 1e-14;  // of |c - R x| / |c|
constexpr double singular = 1e-13;  // a condition that is rounding

class Factor : public Eigen::CholmodSupernodalLLT<SparseMatrix> {
 public:
  /// The square of the ratio of the least and the largest entry of L's diagonal.
  double condition() { return cholmod_rcond(m_cholmodFactor, &cholmod()); }
};

class Supernodal final : public JointSolver {
 public:
  explicit Supernodal(const GlobalConeProblem& problem) : r_(joint_mobility(problem)) {
    cholmod_.cholmod().print = 0;
    cholmod_.analyzePattern(r_);
    const double largest = VectorXd(r_.diagonal()).maxCoeff();
    for (const double delta : {0.0, 1e-12, 1e-10, 1e-8}) {
      cholmod_.setShift(delta * largest);
      cholmod_.factorize(r_);
      if (cholmod_.info() == Eigen::Success && (delta > 0 || cholmod_.condition() > singular)) return;
    }
    throw std::runtime_error("the joints' rows cannot be factorised");
  }

  VectorXd solve(const VectorXd& c) const override {
    VectorXd x = cholmod_.solve(c), left = c - r_ * x;
    for (int k = 0; k < most_refinements && left.norm() > accuracy * c.norm(); ++k) {
      const VectorXd next = x + VectorXd(cholmod_.solve(left)), still = c - r_ * next;
      if (!(still.norm() < 0.5 * left.norm())) break;
      x = next;
      left = still;
    }
    return x;
  }

 private:
  const SparseMatrix r_;
  Factor cholmod_;
};

}  // namespace

std::unique_ptr<JointSolver> make_supernodal(const GlobalConeProblem& problem) {
  return std::make_unique<Supernodal>(problem);
}

}  // namespace lockstep::oracle
