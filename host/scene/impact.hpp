// What an event tells of an impact (docs/events.md).
#pragma once

#include "host/scene/exact_math.hpp"

namespace lockstep {

/// How two came together: how fast along the normal, at the fastest of their points, before anything stopped them; and
/// what their contacts gave. World frame.
struct Impact {
  double speed = 0;             // m/s
  Vector3 point = {0, 0, 0};    // m
  Vector3 normal = {0, 0, 0};   // from b to a, unit
  Vector3 impulse = {0, 0, 0};  // on a, of all their points, N s: of the whole step (docs/forces.md)
};

}  // namespace lockstep
