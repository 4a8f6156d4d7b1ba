// Names of what sensors measure (docs/reference/forces.md).
#pragma once

#include <utility>

#include "include/lockstep/readings.hpp"
#include "include/lockstep/scene.hpp"

namespace lockstep {

inline constexpr std::pair<const char*, SensorKind> sensor_kind_names[] = {
    {"force", SensorKind::force}, {"torque", SensorKind::torque}, {"touch", SensorKind::touch}};

inline const char* name_of(SensorKind kind) {
  for (const auto& [name, each] : sensor_kind_names)
    if (each == kind) return name;
  return "";
}

}  // namespace lockstep
