// What can be another while a world runs.
#include "python/shared_world.hpp"

namespace lockstep::python {

namespace {

void set_material(World& world, const std::string& name, const std::optional<double>& friction,
                  const std::optional<double>& restitution, const FurtherFriction& further) {
  const u32 index = world.material(name);
  Material material = world.materials()[index];
  const auto set = [](auto& to, const std::optional<double>& value) {
    if (value) to = *value;
  };
  set(material.friction, friction);
  set(material.restitution, restitution);
  set(material.further.static_friction, further.static_friction);
  set(material.further.stick_speed, further.stick_speed);
  set(material.further.torsional_friction, further.torsional_friction);
  set(material.further.rolling_friction, further.rolling_friction);
  set(material.further.friction_across, further.friction_across);
  world.set_material(index, material);
}

}  // namespace

void add_changes(WorldClass& world) {
  using Value = std::optional<double>;
  world
      .def(
          "change_body",
          [](SharedWorld& shared, BodyHandle body, const py::object& description) {
            shared.change_body(body, description);
          },
          py::arg("body"), py::arg("description"),
          "Describes a body anew, as an entry of 'bodies' in a scene file: type, mass and moments, shapes with\n"
          "materials and filters. Where it stands and how it moves stays as it is, whatever the entry says, and so "
          "does\n"
          "a name that it leaves out; what is static stands still. Takes effect, and costs, as add_body() does.")
      .def(
          "change_joint",
          [](SharedWorld& shared, JointHandle joint, const py::object& description) {
            shared.change_joint(joint, description);
          },
          py::arg("joint"), py::arg("description"),
          "Describes a joint anew, as an entry of 'joints' in a scene file but for 'bodies': limits, motor, friction,\n"
          "spring, armature, how soft it is. What it leaves out it has no more, but for its name and type; anchors, "
          "axes, pitch "
          "and\n"
          "radius stay, whatever it says, and another type is refused. Takes effect, and costs, as add_joint() does.")
      .def_property_readonly(
          "gravity", [](SharedWorld& shared) { return to_array(shared.use().gravity()); }, "Shape (3,), m/s^2.")
      .def(
          "set_gravity", [](SharedWorld& shared, const Vector3& gravity) { shared.use().set_gravity(gravity); },
          py::arg("gravity"), "From the next step on, m/s^2. Costs little, and wakes all.")
      .def(
          "set_material",
          [](SharedWorld& shared, const std::string& name, const Value& friction, const Value& restitution,
             const Value& static_friction, const Value& stick_speed, const Value& torsional_friction,
             const Value& rolling_friction, const Value& friction_across) {
            set_material(shared.use(), name, friction, restitution,
                         {static_friction, stick_speed, torsional_friction, rolling_friction, friction_across});
          },
          py::arg("name"), py::kw_only(), py::arg("friction") = py::none(), py::arg("restitution") = py::none(),
          py::arg("static_friction") = py::none(), py::arg("stick_speed") = py::none(),
          py::arg("torsional_friction") = py::none(), py::arg("rolling_friction") = py::none(),
          py::arg("friction_across") = py::none(),
          "What is given is another from the next step on, in the units of scene files; the rest stays. 'default' is\n"
          "that of a scene that names none. Wakes what rests on it, and costs as add_body() does.")
      .def(
          "set_material_pair",
          [](SharedWorld& shared, const std::string& a, const std::string& b, double friction, double restitution) {
            World& of = shared.use();
            of.set_material_pair({of.material(a), of.material(b), friction, restitution});
          },
          py::arg("a"), py::arg("b"), py::arg("friction"), py::arg("restitution"),
          "A rule for two materials in the place of what they combine to, and of a rule that there was.")
      .def_property_readonly(
          "speed_limit", [](SharedWorld& shared) { return shared.use().speed_limit(); }, "m/s.")
      .def(
          "set_speed_limit", [](SharedWorld& shared, double speed) { shared.use().set_speed_limit(speed); },
          py::arg("speed"), "Bodies that are faster end the run, m/s. Costs as add_body() does.");
}

}  // namespace lockstep::python
