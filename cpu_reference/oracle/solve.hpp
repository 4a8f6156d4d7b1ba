// What every oracle is asked and what it answers, whatever its problem: limits in, a report out.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace lockstep::oracle {

/// When to stop, which a request to end (host/stop.hpp) says too. A direct method heeds `iterations` (its pivots) and
/// uses `tolerance` to tell zero from not.
struct SolveLimits {
  double tolerance = 1e-8;           // of the residual, in the measure of the problem
  std::uint32_t iterations = 10000;  // of the outer loop
  double seconds = 60;               // of wall time; looked at between iterations
};

/// Why a solver stopped.
enum class Stop {
  tolerance,    // the residual asked for was reached
  stall,        // nothing gained any more
  limit,        // of iterations or of time
  infeasible,   // shown to have no solution, or out of the method's reach
  interrupted,  // a limit that was set meanwhile: the program was asked to end
};

std::string_view stop_name(Stop stop);

/// How a solve went. `residual` is that of what was returned, which is the best iterate seen.
struct SolveReport {
  Stop stop = Stop::limit;
  std::uint32_t iterations = 0;
  double residual = 0;
  std::vector<double> residuals;  // after each iteration; empty for direct methods
  double seconds = 0;             // wall time of the solve, residuals included
};

}  // namespace lockstep::oracle
