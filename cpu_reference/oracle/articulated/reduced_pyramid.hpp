// Model-DCA-LCP (survey 3.7; Bhalerao, Anderson, Trinkle 2009): the friction pyramid of models/friction_pyramid.hpp in
// reduced coordinates. The impulses of the joints are gone and so are the velocities; what is left are the survey's
// unknowns x = (p_n, alpha of joints, alpha of contacts, beta of joints, beta of contacts), and behind them one for
// each bound of an acting coordinate, which the survey's models do not have.
#pragma once

#include "cpu_reference/oracle/articulated/reduced_problem.hpp"
#include "cpu_reference/oracle/lcp/lcp.hpp"

namespace lockstep::oracle::articulated {

class ReducedPyramid {
 public:
  /// `directions` as in FrictionPyramid. The problem is kept by reference. Throws Error for fewer than 3.
  ReducedPyramid(const ReducedProblem& problem, int directions);

  /// Of the problem's W.
  lcp::Lcp lcp() const;

  /// Impulses of the problem's rows, from an x.
  VectorXd impulses(const VectorXd& x) const { return spread_ * x; }

  /// What takes x to impulses of the problem's rows, and what couples unknowns without any motion: alpha, beta, p_n.
  const MatrixXd& spread() const { return spread_; }
  MatrixXd couplings() const;
  /// The constants of x's rows without the problem's q.
  VectorXd constants() const;

  Index size() const { return spread_.cols(); }

 private:
  const ReducedProblem& problem_;
  Index directions_;
  MatrixXd spread_;
};

}  // namespace lockstep::oracle::articulated
