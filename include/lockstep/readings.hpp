// What a world tells of a step: impacts and sensors.
#pragma once

#include <string>
#include <vector>

#include "scene.hpp"
#include "types.hpp"

namespace lockstep {

/// How two came together: how fast along the normal, at the fastest of their points, before anything stopped them; and
/// what their contacts gave. World frame.
struct Impact {
  double speed = 0;             // m/s
  Vector3 point = {0, 0, 0};    // m
  Vector3 normal = {0, 0, 0};   // from b to a, unit
  Vector3 impulse = {0, 0, 0};  // on a, of all their points, N s: of the whole step (docs/reference/forces.md)
};

/// What a sensor reads of the last step; 0 before the first.
struct SensorReading {
  std::string name;
  SensorKind kind = SensorKind::force;
  // 3 of force, N, and of torque, N m: of a joint on its second body, in the joint's frame as that body carries it,
  // the torque about that body's anchor; of contacts on the body, world frame, the torque about its centre of mass.
  // 1 of touch, N: the sum of the normal forces
  std::vector<double> values;
};

}  // namespace lockstep
