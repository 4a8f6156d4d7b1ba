// Joints by a parallel sparse direct solver, where the survey (section 5) names PARDISO: CHOLMOD's supernodal Cholesky
// factorisation of R (Chen, Davis, Hager, Rajamanickam, ACM TOMS 35, 2008), whose dense work is that of a BLAS with
// threads. R rather than the indefinite K, for R asks for no pivots: the pattern alone orders it. Loops need no care,
// and whether a singular R factorises, which is rounding, does not matter (refined_solver.hpp).
#include <Eigen/CholmodSupport>

#include "cpu_reference/oracle/joints/refined_solver.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::VectorXd;

class Supernodal final : public RefinedSolver {
 public:
  explicit Supernodal(const GlobalConeProblem& problem) : RefinedSolver(problem, 1e-14) {
    cholmod_.cholmod().print = 0;
    cholmod_.analyzePattern(mobility());
    choose_shift(0);
  }

 private:
  bool prepare(double delta) override {
    cholmod_.setShift(delta);
    cholmod_.factorize(mobility());
    return cholmod_.info() == Eigen::Success;
  }
  VectorXd inverse(const VectorXd& c) const override { return cholmod_.solve(c); }

  Eigen::CholmodSupernodalLLT<SparseMatrix> cholmod_;
};

}  // namespace

std::unique_ptr<JointSolver> make_supernodal(const GlobalConeProblem& problem) {
  return std::make_unique<Supernodal>(problem);
}

}  // namespace lockstep::oracle
