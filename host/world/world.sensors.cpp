// What the sensors of a world read.
#include "host/scene/sensors.hpp"
#include "host/world/impl.hpp"

namespace lockstep {

// Those of a body or joint go with it; those behind it have moved up.
void World::Impl::remove_from_sensors(u32 SensorDescription::*measured, u32 gone, const std::string& name) {
  std::erase_if(scene.sensors, [&](const SensorDescription& sensor) {
    if (sensor.*measured != gone) return false;
    sensors_gone[sensor.name] = name;
    return true;
  });
  for (SensorDescription& sensor : scene.sensors)
    if (sensor.*measured != NONE && sensor.*measured > gone) --(sensor.*measured);
}

SensorReading World::Impl::reading(const SensorDescription& sensor) {
  if (sensor.joint != NONE) return ready().joint_reading(sensor);
  keep_contacts_and_events();
  const auto side = [&](BodyHandle body, u32 shape) {
    return DescribedShape{bodies.contains(body) ? bodies.index(body) : NONE, shape};
  };
  std::vector<ReportedContact> told;
  for (const BodyContact& contact : contacts)
    told.push_back({0, side(contact.a, contact.shape_a), side(contact.b, contact.shape_b), contact.point,
                    contact.normal, contact.impulse});
  return reading_of(sensor, told, current_poses()[sensor.body].position, impulse_time(scene));
}

std::vector<SensorReading> World::sensors() {
  std::vector<SensorReading> readings;
  for (const SensorDescription& sensor : impl_->scene.sensors) readings.push_back(impl_->reading(sensor));
  return readings;
}

SensorReading World::sensor(const std::string& name) {
  const std::vector<SensorDescription>& sensors = impl_->scene.sensors;
  const auto found = std::ranges::find(sensors, name, &SensorDescription::name);
  if (found != sensors.end()) return impl_->reading(*found);
  const std::string where = "sensor " + quote(name);
  if (const auto gone = impl_->sensors_gone.find(name); gone != impl_->sensors_gone.end())
    throw Error(Failure::input, where, "measured " + gone->second + ", which was removed");
  std::vector<std::string> names;
  for (const SensorDescription& sensor : sensors) names.push_back(sensor.name);
  throw Error(Failure::input, where, "is not in this world; " + suggestion(name, names));
}

}  // namespace lockstep
