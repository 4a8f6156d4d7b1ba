// How well a frictional contact problem was solved: the residual of docs/reference/error_measures.md, and beside it the
// forms of FCLIB, Siconos and the literature. With F the natural map of cone/cone.hpp:
//   residual       rms(w) / U, w_i = |F_i(rho_i)| / rho_i, rho_i = 1 / lambda_max(W_ii), U = rms|q| (else rms|W r|);
//                  a block of rows of joints counts with |V^T r + R l + s|
//   natural_map    |F(1)| / |q|: Acary, Bremond, Huber (2018), eq. 6.1
//   natural_largest  |F(1)| / max(|q|, |r|, |u|): what Siconos 4.4 reports
//   alart_curnier  |Phi| / |q|, Phi_n = r_n - max(0, r_n - u_n), Phi_t = r_t - P_D(mu max(0, r_n - u_n))(r_t - u_t)
//   jean_moreau    the same with P_D(mu max(0, r_n))
//   merit_1        |F(1)| / (1 + sqrt|q|) + |V^T r + R l + s| / (1 + |s|), as FCLIB computes it
// All but the first depend on the units: they compare impulses with velocities.
#pragma once

#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep::oracle {

struct ConeError {
  double residual = 0;
  double defect_max = 0, defect_rms = 0;  // m/s
  std::uint32_t worst = 0;                // contact, or, counted on, block of joints
  double scale = 0;                       // U, m/s
  double rounding = 0;                    // what rounding alone can make of the residual
  double natural_map = 0, natural_largest = 0, alart_curnier = 0, jean_moreau = 0, merit_1 = 0;
};

/// Evaluates the residual of a problem, which must outlive it, again and again.
class ResidualMeter {
 public:
  explicit ResidualMeter(const ConeProblem& problem);

  /// Of impulses r and the velocities u = W r + q; of a problem without joints.
  double residual(const Eigen::VectorXd& r, const Eigen::VectorXd& u) const;

  /// lambda_max(W_ii), 1/kg
  const Eigen::VectorXd& mobility() const { return mobility_; }

 private:
  const ConeProblem& problem_;
  Eigen::VectorXd mobility_;
  double q_rms_;
};

/// All measures of impulses r of the contacts and l of the joints (empty: there are none).
ConeError cone_error(const ConeProblem& problem, const Eigen::VectorXd& r, const Eigen::VectorXd& l = {});

}  // namespace lockstep::oracle
