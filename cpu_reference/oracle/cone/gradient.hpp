// What the gradient methods share: impulses measured by sqrt(lambda_max(W_ii)) of their contact, in which a projection
// onto the cones is still one contact by contact, and which makes light and heavy bodies alike.
#pragma once

#include "cpu_reference/oracle/cone/cone.hpp"
#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep::oracle {

/// De Saxce's shift of normal velocities: mu |u_t| in the normal rows.
inline Eigen::VectorXd de_saxce_shift(const ConeProblem& problem, const Eigen::VectorXd& u) {
  Eigen::VectorXd shift = Eigen::VectorXd::Zero(u.size());
  for (std::uint32_t i = 0; i < problem.contacts(); ++i) shift[3 * i] = problem.mu[i] * u.segment<2>(3 * i + 1).norm();
  return shift;
}

/// P_K(r - step g / mobility), contact by contact.
inline Eigen::VectorXd gradient_step(const ConeProblem& problem, const Eigen::VectorXd& mobility,
                                     const Eigen::VectorXd& r, const Eigen::VectorXd& g, double step) {
  Eigen::VectorXd result = r;
  for (std::uint32_t i = 0; i < problem.contacts(); ++i) {
    if (mobility[i] <= 0) continue;
    const Eigen::Vector3d x = r.segment<3>(3 * i) - step / mobility[i] * g.segment<3>(3 * i);
    result.segment<3>(3 * i) = project_on_cone(x, problem.mu[i]);
  }
  return result;
}

/// Square of the length of a change of impulses in that measure.
inline double squared_length(const Eigen::VectorXd& mobility, const Eigen::VectorXd& change) {
  double sum = 0;
  for (Eigen::Index i = 0; i < mobility.size(); ++i) sum += mobility[i] * change.segment<3>(3 * i).squaredNorm();
  return sum;
}

}  // namespace lockstep::oracle
