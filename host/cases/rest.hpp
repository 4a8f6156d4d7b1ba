// How well a scene that is built at rest stands.
#pragma once

#include "host/cases/trial.hpp"

namespace lockstep {

struct RestMeasures {
  double ms = 0;              // of a step, median
  double moved = 0;           // m, the farthest that a body has been seen from where it started
  double mean_depth = 0;      // m, over contacts that overlap, the mean over the last second
  double deepest = 0;         // m, in the last second
  double deepest_of_all = 0;  // m
  double kinetic = 0;         // J a body, the largest in the last second
};

/// Runs the scene for so long (s). It is looked at every tenth step, and at each one of the last second.
RestMeasures measure_rest(const Scene& scene, double duration, Trial& trial);

/// The same with the scene's own settings and steps. `device`: nothing for the reference.
RestMeasures measure_rest(const Scene& scene, const std::string& precision = "float",
                          const std::optional<DeviceInfo>& device = std::nullopt);

}  // namespace lockstep
