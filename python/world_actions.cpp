// What acts on the bodies of a world.
#include "python/shared_world.hpp"

namespace lockstep::python {

namespace {

std::function<Wrench(double)> table_of(const std::vector<double>& times,
                                       const std::vector<std::array<double, 6>>& loads) {
  if (times.size() != loads.size()) throw Error(Failure::input, "load table", "must have as many loads as times");
  std::vector<std::pair<double, Wrench>> rows;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const std::array<double, 6>& l = loads[i];
    rows.push_back({times[i], {{l[0], l[1], l[2]}, {l[3], l[4], l[5]}}});
  }
  return load_table(std::move(rows));
}

}  // namespace

void add_actions(WorldClass& world) {
  world
      .def(
          "apply_impulse",
          [](SharedWorld& shared, BodyHandle body, const Vector3& impulse, const std::optional<Vector3>& point) {
            if (point)
              shared.use().apply_impulse(body, impulse, *point);
            else
              shared.use().apply_impulse(body, impulse);
          },
          py::arg("body"), py::arg("impulse"), py::arg("point") = py::none(),
          "Changes the velocity of a dynamic body at once; N s, at a point of the world, m, or at its centre of mass.")
      .def(
          "apply_force",
          [](SharedWorld& shared, BodyHandle body, const Vector3& force, const std::optional<Vector3>& point) {
            if (point)
              shared.use().apply_force(body, force, *point);
            else
              shared.use().apply(body, {force, {0, 0, 0}});
          },
          py::arg("body"), py::arg("force"), py::arg("point") = py::none(),
          "Acts on a dynamic body during the next step, spread over its sub-steps; several add up. N, at a point of "
          "the\n"
          "world, m, or at its centre of mass.")
      .def(
          "apply_torque",
          [](SharedWorld& shared, BodyHandle body, const Vector3& torque) {
            shared.use().apply(body, {{0, 0, 0}, torque});
          },
          py::arg("body"), py::arg("torque"), "The same of a torque, N m.")
      .def(
          "set_load",
          [](SharedWorld& shared, BodyHandle body, const std::optional<py::function>& load) {
            shared.use().set_load(body, load ? PythonLoad(*load) : std::function<Wrench(double)>());
          },
          py::arg("body"), py::arg("load"),
          "What acts on a dynamic body until it is replaced, or taken away by None: a function that is given a time, "
          "s,\n"
          "the middle of each step, and gives six numbers, a force through the centre of mass, N, and a torque, N m.\n"
          "What it raises, step() raises. It may not use the world.")
      .def(
          "set_load_table",
          [](SharedWorld& shared, BodyHandle body, const std::vector<double>& times,
             const std::vector<std::array<double, 6>>& loads) { shared.use().set_load(body, table_of(times, loads)); },
          py::arg("body"), py::arg("times"), py::arg("loads"),
          "The same by a table: rising times, shape (m,), s, and loads, shape (m, 6); straight lines between them.")
      .def(
          "set_velocity",
          [](SharedWorld& shared, BodyHandle body, const Vector3& velocity, const Vector3& angular_velocity) {
            shared.use().set_velocity(body, {velocity, angular_velocity});
          },
          py::arg("body"), py::arg("velocity"), py::arg("angular_velocity") = Vector3{0, 0, 0},
          "Of a dynamic or kinematic body, m/s and rad/s.")
      .def(
          "wake", [](SharedWorld& shared, BodyHandle body) { shared.use().wake(body); }, py::arg("body"),
          "Wakes the island that a dynamic body sleeps in, with the next step.")
      .def(
          "set_kinematic_target",
          [](SharedWorld& shared, BodyHandle body, const Vector3& position, const Quaternion& orientation) {
            shared.use().set_kinematic_target(body, {position, orientation});
          },
          py::arg("body"), py::arg("position"), py::arg("orientation") = Quaternion{0, 0, 0, 1},
          "A kinematic body moves evenly so that it is there at the end of the next step, to rounding, and then "
          "stands.");
}

}  // namespace lockstep::python
