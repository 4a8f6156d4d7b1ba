#include "host/scene/sensors.hpp"

#include <algorithm>

#include "host/scene/compile_particles.hpp"

namespace lockstep {

namespace {

// The index of what has this name. Refuses a name that nothing has, or several have.
template <class Item>
u32 find_named(const JsonNode& node, const char* what, const std::vector<Item>& items) {
  const std::string name = node.text();
  const auto found = std::ranges::find(items, name, &Item::name);
  if (found == items.end()) {
    std::vector<std::string> names;
    for (const Item& item : items)
      if (!item.name.empty() && names.size() < 64) names.push_back(item.name);
    node.unknown(what, name, names);
  }
  if (std::ranges::count(items, name, &Item::name) > 1)
    node.fail("names several " + std::string(what) + "s; what a sensor measures needs a name of its own");
  return static_cast<u32>(found - items.begin());
}

// What is wrong with a sensor, or nothing. Names are looked for among the sensors before it.
std::string fault_of(const SensorDescription& sensor, std::span<const SensorDescription> before, const Scene& scene) {
  if (sensor.name.empty()) return "needs a name";
  if (std::ranges::find(before, sensor.name, &SensorDescription::name) != before.end())
    return "names the sensor " + quote(sensor.name) + " again; names must differ";
  if ((sensor.body == NONE) == (sensor.joint == NONE)) return "measures a body or a joint; give one of them";
  if (sensor.joint != NONE) {
    if (sensor.joint >= scene.joints.size()) return "measures a joint that the scene does not have";
    if (sensor.kind == SensorKind::touch) return "touch is of a body or a shape; of a joint take force or torque";
    return sensor.shape ? "a joint has no shapes; leave \"shape\" out" : "";
  }
  if (sensor.body >= scene.bodies.size()) return "measures a body that the scene does not have";
  if (is_penalty(scene)) return "no contacts push particles of the model penalty; measure a joint, or use constraints";
  const std::vector<ShapeDescription>& shapes = scene.bodies[sensor.body].shapes;
  if (sensor.shape && !shapes.empty() && *sensor.shape >= shapes.size())
    return "its shape must be one of the body's, which count from 0 to " + std::to_string(shapes.size() - 1);
  if (std::ranges::all_of(shapes, &ShapeDescription::trigger) || (sensor.shape && shapes[*sensor.shape].trigger))
    return "measures no shape that anything pushes";
  return "";
}

}  // namespace

std::vector<SensorDescription> read_sensors(const JsonNode& array, const Scene& scene) {
  std::vector<SensorDescription> sensors;
  for (const JsonNode& node : array.elements()) {
    node.expect_object({"name", "kind", "body", "shape", "joint"});
    SensorDescription sensor;
    sensor.name = node.at("name").text();
    sensor.kind = node.at("kind").choice<SensorKind>("kind of sensor", sensor_kind_names);
    if (node.has("body")) sensor.body = find_named(node.at("body"), "body", scene.bodies);
    if (node.has("joint")) sensor.joint = find_named(node.at("joint"), "joint", scene.joints);
    if (node.has("shape")) sensor.shape = node.at("shape").integer(0, NONE - 1);
    if (const std::string fault = fault_of(sensor, sensors, scene); !fault.empty()) node.fail(fault);
    sensors.push_back(std::move(sensor));
  }
  return sensors;
}

void validate_sensors(const Scene& scene) {
  const std::span<const SensorDescription> sensors = scene.sensors;
  for (std::size_t i = 0; i < sensors.size(); ++i)
    if (const std::string fault = fault_of(sensors[i], sensors.first(i), scene); !fault.empty())
      throw Error(Failure::input, "sensor " + quote(sensors[i].name), fault);
}

SensorReading reading_of(const SensorDescription& sensor, std::span<const ReportedContact> contacts,
                         const Vector3& center, double time) {
  Vector3 force = {0, 0, 0}, torque = {0, 0, 0};
  double touch = 0;
  const auto is_measured = [&](const DescribedShape& side) {
    return side.body == sensor.body && (!sensor.shape || side.shape == *sensor.shape);
  };
  for (const ReportedContact& contact : contacts) {
    const bool is_a = is_measured(contact.a);
    if (!is_a && !is_measured(contact.b)) continue;
    const Vector3 on_body = exact::scale((is_a ? 1 : -1) / time, contact.impulse);
    force = exact::add(force, on_body);
    torque = exact::add(torque, exact::cross(exact::subtract(contact.point, center), on_body));
    for (unsigned k = 0; k < 3; ++k) touch += contact.normal[k] * contact.impulse[k] / time;
  }
  if (sensor.kind == SensorKind::touch) return {sensor.name, sensor.kind, {touch}};
  return reading_of(sensor, force, torque);
}

SensorReading reading_of(const SensorDescription& sensor, const Vector3& force, const Vector3& torque) {
  const Vector3& values = sensor.kind == SensorKind::force ? force : torque;
  return {sensor.name, sensor.kind, {values.begin(), values.end()}};
}

}  // namespace lockstep
