// Where an iteration starts: the impulses that it was given, or zero.
#pragma once

#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep::oracle {

inline Eigen::VectorXd start_of(const ConeProblem& problem, const Eigen::VectorXd& r) {
  return r.size() == problem.q.size() ? r : Eigen::VectorXd(Eigen::VectorXd::Zero(problem.q.size()));
}

}  // namespace lockstep::oracle
