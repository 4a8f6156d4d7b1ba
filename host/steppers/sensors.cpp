#include "host/steppers/sensors.hpp"

#include <algorithm>
#include <optional>

#include "host/report/joint_wrench.hpp"
#include "host/scene/sensors.hpp"
#include "host/steppers/reported_contacts.hpp"

namespace lockstep {

template <class real>
SensorReading joint_reading(const SensorDescription& sensor, const JointSource<real>& source,
                            const StepParams<real>& params) {
  const JointWrench wrench = joint_wrench(source.buffers, params, sensor.joint, source.impulses);
  const Eigen::Vector3d &f = wrench.force, &t = wrench.torque;
  return reading_of(sensor, {f.x(), f.y(), f.z()}, {t.x(), t.y(), t.z()});
}

template <class real>
std::vector<SensorReading> sensor_readings(std::span<const Scene> worlds, Backend<real>& backend,
                                           const StepParams<real>& params, const Counters& counters, bool has_stepped) {
  const std::vector<SensorDescription>& sensors = worlds[0].sensors;
  if (sensors.empty()) return {};
  std::vector<ReportedContact> contacts;
  std::vector<Vector3> centers;
  if (std::ranges::any_of(sensors, [](const SensorDescription& sensor) { return sensor.body != NONE; })) {
    const Buffer wanted[] = {Buffer::positions, Buffer::shape_infos};
    const Buffers<real>& b = backend.download(wanted);
    for (const Vec4<real>& p : b.positions) centers.push_back({double(p.x), double(p.y), double(p.z)});
    contacts = reported_contacts(backend, params, counters, std::vector(b.shape_infos), DescribedShapes(worlds));
    std::erase_if(contacts, [](const ReportedContact& contact) { return contact.world != 0; });
  }
  std::optional<JointSources<real>> joints;
  if (std::ranges::any_of(sensors, [](const SensorDescription& sensor) { return sensor.joint != NONE; }))
    joints.emplace(backend, has_stepped);
  const double time = impulse_time(worlds[0]);
  std::vector<SensorReading> readings;
  for (const SensorDescription& sensor : sensors)
    readings.push_back(sensor.joint == NONE ? reading_of(sensor, contacts, centers[sensor.body], time)
                                            : joint_reading(sensor, joints->of(sensor.joint), params));
  return readings;
}

#define INSTANTIATE(real)                                                                                              \
  template SensorReading joint_reading(const SensorDescription&, const JointSource<real>&, const StepParams<real>&);   \
  template std::vector<SensorReading> sensor_readings(std::span<const Scene>, Backend<real>&, const StepParams<real>&, \
                                                      const Counters&, bool);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep
