// Loops closed in the coordinates: Newton's method on the errors of their rows.
#pragma once

#include "cpu_reference/oracle/articulated/step.hpp"

namespace lockstep::oracle::articulated {

/// Rows, and by how much they are off at a configuration, m and rad.
struct ErrorRows {
  std::vector<Row> rows;
  std::vector<double> errors;
  double largest() const;
};

/// `expected`: the acting coordinates of the joints, to half a revolution. What is farther off than a radian from them
/// counts as a radian, so that closing keeps the revolutions.
ErrorRows closure_rows(const std::vector<Closure>& closures, const Tree& tree, const std::vector<double>& expected,
                       const Configuration& at);

/// The same with the limits that a configuration is beyond.
ErrorRows with_limits(ErrorRows closed, const std::vector<Limit>& limits, const Tree& tree,
                      const std::vector<double>& expected, const Configuration& at);

/// Moves the configuration, in each iteration by the least that takes the errors of its rows away to first order,
/// weighed by the inertia, until none is above 1e-13 or for 20 iterations. `limits`: null, or to be kept as well.
/// Returns the largest error that is left.
double close_loops(const Tree& tree, const std::vector<Closure>& closures, const std::vector<Limit>* limits,
                   const std::vector<double>& expected, Configuration& configuration);

}  // namespace lockstep::oracle::articulated
