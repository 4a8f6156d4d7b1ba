// A length or speed of contacts that a scene gives, or that follows its shapes.
#pragma once

#include <optional>

namespace lockstep {

/// As it is given, m or m/s; or else a share of a radius of the smaller shape of each pair, 1 or 1/s
/// (host/scene/shape_tolerances.hpp).
struct ShapeTolerance {
  const char* name = "";
  std::optional<double> given = {};
  double share = 0;
};

}  // namespace lockstep
