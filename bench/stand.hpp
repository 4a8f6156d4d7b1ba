// How well a scene that is built at rest stands: shared by bench/stability_bench.cpp and tests/stacks_test.cpp.
#pragma once

#include <string>

#include "host/scene/scene.hpp"

namespace lockstep::bench {

struct Stood {
  double ms = 0;              // of a step, median
  double moved = 0;           // m, the farthest that a body has been seen from where it started
  double mean_depth = 0;      // m, over contacts that overlap, the mean over the last second
  double deepest = 0;         // m, in the last second
  double deepest_of_all = 0;  // m
  double kinetic = 0;         // J a body, the largest in the last second
};

/// Runs the steps that the scene asks for. It is looked at every tenth step, and at each one of the last second.
template <class real>
Stood stand(const Scene& scene, const std::string& device = "reference");

}  // namespace lockstep::bench
