// Names of the ends of a solve: the one list of them, for all solvers, their reports and their tables.
#pragma once

#include <string_view>

#include "include/lockstep/verdict.hpp"

namespace lockstep {

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
