// What the sensors of a scene read, wherever it is computed.
#pragma once

#include <span>
#include <vector>

#include "host/backends/backend.hpp"
#include "host/scene/scene.hpp"
#include "host/steppers/joint_source.hpp"

namespace lockstep {

/// Of the first of the worlds that the backend simulates, after a step with these parameters and counters; a run that
/// is resumed may not have stepped.
template <class real>
std::vector<SensorReading> sensor_readings(std::span<const Scene> worlds, Backend<real>& backend,
                                           const StepParams<real>& params, const Counters& counters, bool has_stepped);

/// The force and the torque of a joint (host/report/joint_wrench.hpp).
template <class real>
SensorReading joint_reading(const SensorDescription& sensor, const JointSource<real>& source,
                            const StepParams<real>& params);

}  // namespace lockstep
