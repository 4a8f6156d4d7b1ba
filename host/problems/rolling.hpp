// Contacts with rolling friction, as Siconos and FCLIB have them, by the solvers of ordinary ones. A contact has five
// rows: r = (r_n, r_t, m) in { |r_t| <= mu r_n, |m| <= mu_r r_n }, 0 <= u_n _|_ r_n >= 0, with r_t against the slip u_t
// and the moments m against the rolling velocity. It is split into two contacts of three rows, a = (r_n, r_t) with mu
// and b = (r', m) with mu_r, and a velocity of its own presses the two normal impulses against each other, c > 0:
//   u_a,n = u_n + c (r_n - r'),   u_b,n = c (r' - r_n)
// That is the same problem, whatever c: where r' > 0, u_b,n = 0 and so r' = r_n; where r' = 0, u_b,n >= 0 and so r_n =
// 0.
#pragma once

#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep {

/// W, q and the rows of V with five rows a contact, as a problem of twice as many contacts: a, b, a, b ...
oracle::ConeProblem split_rolling(const oracle::SparseMatrix& w, const Eigen::VectorXd& q, const Eigen::VectorXd& mu,
                                  const Eigen::VectorXd& rolling, std::optional<oracle::Bilateral> joints);

/// The same of the global form. Its velocities are those of the problem and then one for each contact.
oracle::GlobalConeProblem split_rolling(const oracle::GlobalConeProblem& problem, const Eigen::VectorXd& rolling);

/// Impulses from five rows a contact to those of the split problem, and back; velocities back.
Eigen::VectorXd split_impulses(const Eigen::VectorXd& r);
Eigen::VectorXd joined_impulses(const Eigen::VectorXd& r);
Eigen::VectorXd joined_velocities(const Eigen::VectorXd& u);

}  // namespace lockstep
