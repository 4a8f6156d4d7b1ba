// One step of the semi-smooth Newton method on the function of Alart and Curnier (1991), of the problem with W + alpha.
#pragma once

#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep::oracle {

/// W + diag(alpha), q - diag(alpha) centre: what a proximal point iteration asks for. alpha = 0: the problem itself.
struct NewtonProblem {
  const ConeProblem& problem;
  const Eigen::VectorXd& mobility;  // lambda_max(W_ii)
  Eigen::VectorXd alpha, centre;    // 3n

  Eigen::VectorXd velocity(const Eigen::VectorXd& r) const {
    return problem.w.times(r) + problem.q + alpha.cwiseProduct(r - centre);
  }
};

/// Phi / rho, in m/s, rho_i = 1 / lambda_max(W_ii):
///   Phi_n = r_n - max(0, x_n),   Phi_t = r_t - P_D(mu max(0, x_n))(x_t),   x = r - rho u
double newton_merit(const NewtonProblem& newton, const Eigen::VectorXd& r, const Eigen::VectorXd& u);

/// The direction dr in which the linearised function vanishes, where W carries `damping` mobility on its diagonal.
/// False where the linear system could not be solved.
bool newton_direction(const NewtonProblem& newton, double damping, const Eigen::VectorXd& r, const Eigen::VectorXd& u,
                      Eigen::VectorXd& direction);

}  // namespace lockstep::oracle
