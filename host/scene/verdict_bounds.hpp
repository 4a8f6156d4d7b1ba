// The bounds that a scene sets for its verdict.
#pragma once

#include "host/scene/settings.hpp"
#include "host/verdict.hpp"

namespace lockstep {

/// A verdict of nothing yet, with the bounds of the settings.
inline Verdict verdict_bounds(const Settings& settings) {
  Verdict verdict;
#define CRITERION(name, bound_setting, unit, meaning) verdict[Criterion::name].bound = settings.bound_setting;
#include "host/verdict.def"
  return verdict;
}

}  // namespace lockstep
