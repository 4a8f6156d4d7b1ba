// The sensors of a scene (docs/reference/forces.md).
#pragma once

#include <span>
#include <vector>

#include "host/scene/json_node.hpp"
#include "host/scene/reported_contact.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// Reads the array of them, for a scene whose bodies and joints are known. Refuses, at its place in the file, what
/// validate_sensors() does.
std::vector<SensorDescription> read_sensors(const JsonNode& array, const Scene& scene);

/// Throws Error (input), naming the sensor, where one measures what the scene does not have or what exerts no force,
/// and where two have one name.
void validate_sensors(const Scene& scene);

/// What a sensor of a body or a shape reads of contacts that gave their impulses within `time`, s; `center` is the
/// body's centre of mass, m.
SensorReading reading_of(const SensorDescription& sensor, std::span<const ReportedContact> contacts,
                         const Vector3& center, double time);
/// What a sensor of a joint reads of its force and torque, N and N m.
SensorReading reading_of(const SensorDescription& sensor, const Vector3& force, const Vector3& torque);

/// The time in which contacts and joints gave the impulses that they tell, s: a step, or a sub-step.
inline double impulse_time(const Scene& scene) {
  return wants_step_forces(scene) ? scene.settings.dt : scene.settings.dt / substeps_of(scene.settings);
}

}  // namespace lockstep
