// Joints by a parallel sparse direct solver, where the survey (section 5) names PARDISO: CHOLMOD's supernodal Cholesky
// factorisation of R (Chen, Davis, Hager, Rajamanickam, ACM TOMS 35, 2008), whose dense work is that of a BLAS with
// threads. R rather than the indefinite K, for R asks for no pivots: the pattern alone orders it. Loops need no care.
//
// Redundant rows make R singular, and whether it factorises then is rounding. Its least eigenvalue tells, which inverse
// iteration with the factor itself finds: where R is singular a single solve turns any vector into its null space. Such
// an R is factorised as R + delta. What c has of the null space no x can meet: it stays in the residual of
//   x <- x + (R + delta)^-1 r,   r <- c - R x = delta (R + delta)^-1 r,
// while the rest of r vanishes by delta / (eigenvalue + delta) a time. So this is done twice: first to find what stays,
// then for c without it, so that x gets nothing of the null space but rounding.
#include <Eigen/CholmodSupport>
#include <stdexcept>

#include "cpu_reference/oracle/joints/joint_solver.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int most_refinements = 30, sure_refinements = 3, inverse_iterations = 4;
constexpr double accuracy = 1e-14;    // of |c - R x| / |c|
constexpr double shift_share = 1e-8;  // delta, of the largest eigenvalue

// Rows are scaled to a mobility of 1, so that their masses and units do not matter to the rank.
class Supernodal final : public JointSolver {
 public:
  explicit Supernodal(const GlobalConeProblem& problem)
      : r_(joint_mobility(problem)), scale_(inverse_roots(r_.diagonal())) {
    r_ = scale_.asDiagonal() * r_ * scale_.asDiagonal();
    const double largest = r_.cols() > 0 ? VectorXd(r_.cwiseAbs() * VectorXd::Ones(r_.cols())).maxCoeff() : 1;
    cholmod_.cholmod().print = 0;
    cholmod_.analyzePattern(r_);
    cholmod_.factorize(r_);
    is_regular_ = cholmod_.info() == Eigen::Success && least_eigenvalue() > redundant_rows * largest;
    if (is_regular_) return;
    cholmod_.setShift(shift_share * largest);
    cholmod_.factorize(r_);
    if (cholmod_.info() != Eigen::Success) throw std::runtime_error("the joints' rows cannot be factorised");
  }

  VectorXd solve(const VectorXd& c) const override {
    const VectorXd scaled = scale_.cwiseProduct(c);
    VectorXd left;
    VectorXd x = refined(scaled, left);
    if (!is_regular_) x = refined(scaled - left, left);
    return scale_.cwiseProduct(x);
  }

 private:
  // As far as inverse iteration gets; where it is rounding it may come out below 0.
  double least_eigenvalue() const {
    VectorXd x(r_.rows());
    for (Index i = 0; i < x.size(); ++i) x[i] = 1 + double((i * 7919) % 101) / 101;  // along no vector in particular
    for (int k = 0; k < inverse_iterations; ++k) {
      x = VectorXd(cholmod_.solve(x.normalized()));
      if (!x.allFinite()) return 0;
    }
    x.normalize();
    return x.dot(r_ * x);
  }

  // x, and what is left of c, which each refinement has to halve.
  VectorXd refined(const VectorXd& c, VectorXd& left) const {
    VectorXd x = VectorXd::Zero(c.size());
    left = c;
    for (int k = 0; k < most_refinements && left.norm() > accuracy * c.norm(); ++k) {
      const VectorXd next = x + VectorXd(cholmod_.solve(left)), still = c - r_ * next;
      if (!(still.norm() < (k < sure_refinements ? 1 : 0.5) * left.norm())) break;
      x = next;
      left = still;
    }
    return x;
  }

  SparseMatrix r_;
  const VectorXd scale_;
  Eigen::CholmodSupernodalLLT<SparseMatrix> cholmod_;
  bool is_regular_ = false;
};

}  // namespace

std::unique_ptr<JointSolver> make_supernodal(const GlobalConeProblem& problem) {
  return std::make_unique<Supernodal>(problem);
}

}  // namespace lockstep::oracle
