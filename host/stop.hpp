// How a solve ended: the one list of it, for all solvers, their reports and their tables.
#pragma once

#include <string_view>

namespace lockstep {

/// In the order in which one is worse than another.
enum class Stop {
  solved,      // to the residual, or to the tolerance, that was asked for
  limit,       // at its limit of iterations or of time, or too large for the method
  stalled,     // nothing gained any more; or the method cannot act on the problem
  infeasible,  // there is no solution: a certificate of that was found and checked
  bad,         // not a number, or the step was aborted
};
inline constexpr unsigned stop_count = 5;

constexpr std::string_view stop_name(Stop stop) {
  switch (stop) {
    case Stop::solved: return "solved";
    case Stop::limit: return "limit";
    case Stop::stalled: return "stalled";
    case Stop::infeasible: return "infeasible";
    case Stop::bad: return "bad";
  }
  return "unknown";
}

}  // namespace lockstep
