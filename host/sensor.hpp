// What sensors measure, and what they read (docs/forces.md).
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace lockstep {

/// Of the contacts of a body or a shape, or of a joint; touch is of contacts alone.
enum class SensorKind { force, torque, touch };

inline constexpr std::pair<const char*, SensorKind> sensor_kind_names[] = {
    {"force", SensorKind::force}, {"torque", SensorKind::torque}, {"touch", SensorKind::touch}};

inline const char* name_of(SensorKind kind) {
  for (const auto& [name, each] : sensor_kind_names)
    if (each == kind) return name;
  return "";
}

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
