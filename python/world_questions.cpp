// What is in a world, between two steps.
#include <fmt/format.h>

#include <cstring>

#include "python/shared_world.hpp"

namespace lockstep::python {

namespace {

using Vectors = py::array_t<double, py::array::c_style | py::array::forcecast>;

// `out`, or a new array of shape (rows, columns), filled with records that are nothing but that many doubles.
template <py::ssize_t columns, class Record>
py::array_t<double> fill(std::span<const Record> records, const std::optional<py::array_t<double>>& out) {
  static_assert(sizeof(Record) == columns * sizeof(double));
  const auto rows = static_cast<py::ssize_t>(records.size());
  py::array_t<double> array = out ? *out : py::array_t<double>({rows, columns});
  if (array.ndim() != 2 || array.shape(0) != rows || array.shape(1) != columns ||
      !(array.flags() & py::array::c_style) || !array.writeable())
    throw Error(Failure::input, "out",
                fmt::format("must be a writeable array of shape ({}, {}), float64 in C order", rows, columns));
  if (rows > 0) std::memcpy(array.mutable_data(), records.data(), records.size_bytes());
  return array;
}

// `noconvert` keeps a caller's array from being copied to another type, which would be filled in its place.
py::arg out_argument() { return py::arg("out").noconvert(); }

std::vector<BodyRay> rays_of(const Vectors& origins, const Vectors& directions, double length, u32 mask) {
  for (const Vectors* vectors : {&origins, &directions})
    if (vectors->ndim() != 2 || vectors->shape(1) != 3 || vectors->shape(0) != origins.shape(0))
      throw Error(Failure::input, "rays", "origins and directions must be arrays of one shape (n, 3)");
  std::vector<BodyRay> rays(static_cast<std::size_t>(origins.shape(0)));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double *origin = origins.data() + 3 * i, *direction = directions.data() + 3 * i;
    rays[i] = {{origin[0], origin[1], origin[2]}, {direction[0], direction[1], direction[2]}, length, mask};
  }
  return rays;
}

std::array<double, 7> row_of(const Pose& pose) {
  const auto& [p, q] = pose;
  return {p[0], p[1], p[2], q[0], q[1], q[2], q[3]};
}

std::array<double, 6> row_of(const Twist& twist) {
  const auto& [v, w] = twist;
  return {v[0], v[1], v[2], w[0], w[1], w[2]};
}

void add_states(WorldClass& world) {
  world
      .def(
          "poses",
          [](SharedWorld& shared, const std::optional<py::array_t<double>>& out) {
            return fill<7>(shared.use_ready().poses(), out);
          },
          out_argument() = py::none(),
          "Shape (n, 7): position of the centre of mass, m, and quaternion x y z w, a row for each of `bodies`. A "
          "copy\n"
          "of what is now; `out`, an array of that shape in float64, is filled instead of a new one.")
      .def(
          "velocities",
          [](SharedWorld& shared, const std::optional<py::array_t<double>>& out) {
            return fill<6>(shared.use_ready().velocities(), out);
          },
          out_argument() = py::none(),
          "Shape (n, 6): velocity of the centre of mass, m/s, and angular velocity, rad/s, world frame. As poses().")
      .def(
          "pose", [](SharedWorld& shared, BodyHandle body) { return to_array(row_of(shared.use_ready().pose(body))); },
          py::arg("body"), "A row of poses(), shape (7,).")
      .def(
          "velocity",
          [](SharedWorld& shared, BodyHandle body) { return to_array(row_of(shared.use_ready().velocity(body))); },
          py::arg("body"), "A row of velocities(), shape (6,).")
      .def(
          "is_asleep", [](SharedWorld& shared, BodyHandle body) { return shared.use_ready().is_asleep(body); },
          py::arg("body"), "Whether a dynamic body sleeps (docs/how_to/let_bodies_sleep.md).")
      .def(
          "state_hash",
          [](SharedWorld& shared) {
            return fmt::format("{:016x}", shared.ask([](World& of) { return of.state_hash(); }));
          },
          "Of everything that lives on between steps, 16 hex digits as in the report of `lockstep run`; equal where\n"
          "every bit is.")
      .def(
          "errors", [](SharedWorld& shared) { return shared.ask([](World& of) { return of.errors(); }); },
          "How good the last step was, StepErrors: energy, momentum, penetration, residual, open joints.");
}

}  // namespace

void add_questions(WorldClass& world) {
  add_states(world);
  world
      .def(
          "contacts", [](SharedWorld& shared) { return to_array(shared.use_ready().contacts()); },
          "Contacts of the last step, of sleepers those that they fell asleep with: an array of records with the "
          "fields a, b (ids of bodies), shape_a, shape_b (by\n"
          "their indices in the bodies' descriptions), point (3,) on the surface of a, m, normal (3,) from b to a, "
          "and\n"
          "impulse (3,) on a in the step, N s (with the setting `forces` 'substep' in its last sub-step,\n"
          "docs/reference/forces.md); world frame; triangle_a, triangle_b of shapes that are surfaces, else -1; and "
          "gap, m,\n"
          "negative where they overlap.")
      .def(
          "contact_force",
          [](SharedWorld& shared, BodyHandle body, std::optional<u32> shape) {
            return to_array(shared.use_ready().contact_force(body, shape));
          },
          py::arg("body"), py::arg("shape") = py::none(),
          "What contacts() push a body with in the step, N, shape (3,), world frame; or one of its shapes, by its\n"
          "index in the body's description. Of the last sub-step with the setting `forces` 'substep'.")
      .def(
          "least_norm_contacts",
          [](SharedWorld& shared) {
            const std::vector<BodyContact> contacts = shared.ask([](World& of) { return of.least_norm_contacts(); });
            return to_array(std::span<const BodyContact>(contacts));
          },
          "contacts(), with the impulses of least norm that do the same: where several points carry a body, mechanics\n"
          "does not say how they share the load. Of all that lie in the cones of friction and give each dynamic body "
          "the\n"
          "same force and moment as contacts(), those with the least sum of squares, to 1e-9 "
          "(docs/reference/forces.md).")
      .def(
          "sensors", [](SharedWorld& shared) { return list_of(shared.use_ready().sensors()); },
          "What the sensors of the scene read of the last step, a list of SensorReading in their order.")
      .def(
          "sensor", [](SharedWorld& shared, const std::string& name) { return shared.use_ready().sensor(name); },
          py::arg("name"), "One of sensors() by its name.")
      .def(
          "events", [](SharedWorld& shared) { return list_of(shared.use_ready().events()); },
          "Events of the last step, a list of Event; asked for by the scene's setting `events` or by a trigger.")
      .def(
          "cast_ray",
          [](SharedWorld& shared, const Vector3& origin, const Vector3& direction, double length, const Mask& mask) {
            return shared.ask([origin, direction, length, bits = shared.mask_of(mask)](World& of) {
              return of.cast_ray(origin, direction, length, bits);
            });
          },
          py::arg("origin"), py::arg("direction"), py::arg("length") = 1e6, py::arg("mask") = Mask(0xffffffffu),
          "What a ray meets first within `length`, m: a Hit, or None. The direction need not be unit. `mask` is of\n"
          "categories of shapes: a name, a list of names, or their bits (category_mask).")
      .def(
          "category_mask",
          [](SharedWorld& shared, const std::vector<std::string>& names) { return shared.mask_of(names); },
          py::arg("names"),
          "The bits of categories of shapes by their names. The lowest is that of 'default', and others follow in the\n"
          "order in which the scene names them first.")
      .def(
          "cast_rays",
          [](SharedWorld& shared, const Vectors& origins, const Vectors& directions, double length, const Mask& mask) {
            const auto hits = shared.ask([rays = rays_of(origins, directions, length, shared.mask_of(mask))](
                                             World& of) { return of.cast_rays(rays); });
            return to_array(std::span<const std::optional<BodyHit>>(hits));
          },
          py::arg("origins"), py::arg("directions"), py::arg("length") = 1e6, py::arg("mask") = Mask(0xffffffffu),
          "The same for many rays in one launch, arrays of shape (n, 3): an array of n records with the fields hit,\n"
          "body (its id), shape, distance, m (inf where nothing is hit), point (3,), normal (3,), and triangle of a "
          "shape\n"
          "that is a surface, else -1.")
      .def(
          "overlapping_sphere",
          [](SharedWorld& shared, const Vector3& center, double radius, const Mask& mask) {
            return list_of(shared.ask([center, radius, bits = shared.mask_of(mask)](World& of) {
              return of.overlapping_sphere(center, radius, bits);
            }));
          },
          py::arg("center"), py::arg("radius"), py::arg("mask") = Mask(0xffffffffu),
          "Bodies with a shape that overlaps a sphere, oldest first; m. Triggers are not met.")
      .def(
          "overlapping_box",
          [](SharedWorld& shared, const Vector3& position, const Vector3& half_extents, const Quaternion& orientation,
             const Mask& mask) {
            return list_of(shared.ask([position, orientation, half_extents, bits = shared.mask_of(mask)](World& of) {
              return of.overlapping_box({position, orientation}, half_extents, bits);
            }));
          },
          py::arg("position"), py::arg("half_extents"), py::arg("orientation") = Quaternion{0, 0, 0, 1},
          py::arg("mask") = Mask(0xffffffffu), "Bodies with a shape that overlaps a box, oldest first; m, x y z w.");
}

}  // namespace lockstep::python
