// Whether joints contradict each other, by a certificate that is checked (Fredholm's alternative, which is Farkas'
// lemma for equations): there are no velocities v with G^T v + b = 0 if and only if there is a y with
//   G y = 0,   y . b != 0.
// The part of G^T M^-1 f + b that no impulses of joints change is such a y, where there is one.
#pragma once

#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep::oracle {

/// Whether y proves it, as far as rounding lets see: each sum of G y is within 1e-12 of what it would add up were all
/// of y as large as the largest, y . b is not within 1e-9 of what it adds up. Where joints have drifted, rows that were
/// redundant say a little more than each other: what keeps them all are large velocities, but there are such, and
/// nothing is proven.
bool proves_contradiction(const GlobalConeProblem& problem, const Eigen::VectorXd& y);

}  // namespace lockstep::oracle
