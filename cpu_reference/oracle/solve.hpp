// What every oracle is asked and what it answers, whatever its problem: limits in, a report out.
#pragma once

#include <cstdint>
#include <vector>

#include "host/stop.hpp"

namespace lockstep::oracle {

/// When to stop, which a request to end (host/stop_request.hpp) says too. A direct method heeds `iterations` (its
/// pivots) and uses `tolerance` to tell zero from not.
struct SolveLimits {
  double tolerance = 1e-8;           // of the residual, in the measure of the problem
  std::uint32_t iterations = 10000;  // of the outer loop
  double seconds = 60;               // of wall time; looked at between iterations
};

using lockstep::Stop;
using lockstep::stop_name;

/// How a solve went. `residual` is that of what was returned, which is the best iterate seen.
struct SolveReport {
  Stop stop = Stop::limit;
  std::uint32_t iterations = 0;
  double residual = 0;
  std::vector<double> residuals;  // after each iteration; empty for direct methods
  double seconds = 0;             // wall time of the solve, residuals included
};

}  // namespace lockstep::oracle
