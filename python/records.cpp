// Handles of bodies and joints, and what a world answers.
#include <fmt/format.h>

#include <limits>

#include "host/sensor.hpp"
#include "host/stop.hpp"
#include "python/bindings.hpp"
#include "python/shared_world.hpp"

namespace lockstep::python {

namespace {

// NumPy's view of BodyContact and BodyHit, handles as their numbers.
struct ContactRow {
  u32 a, b, shape_a, shape_b;
  double point[3], normal[3], impulse[3];
  std::int64_t triangle_a, triangle_b;
  double gap;
};
struct HitRow {
  bool hit;
  u32 body, shape;
  double distance, point[3], normal[3];
  std::int64_t triangle;
};

template <std::size_t n>
void store(const std::array<double, n>& from, double* to) {
  for (std::size_t i = 0; i < n; ++i) to[i] = from[i];
}

const char* name_of(EventKind kind) {
  switch (kind) {
    case EVENT_CONTACT_BEGIN: return "begin";
    case EVENT_CONTACT_END: return "end";
    case EVENT_TRIGGER_ENTER: return "enter";
    case EVENT_IMPACT: return "impact";
    default: return "leave";
  }
}

template <class Handle>
void add_handle(py::module_& module, const char* name, const char* doc) {
  py::class_<Handle>(module, name, doc)
      .def(py::init([](u32 id) { return Handle{id}; }), py::arg("id"))
      .def_readonly("id", &Handle::id, "Its number, which no other one of its world is given.")
      .def(
          "__eq__", [](const Handle& a, const Handle& b) { return a == b; }, py::is_operator())
      .def("__hash__", [](const Handle& handle) { return std::hash<u32>()(handle.id); })
      .def("__repr__", [name](const Handle& handle) { return fmt::format("lockstep.{}({})", name, handle.id); });
}

}  // namespace

void add_records(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(ContactRow, a, b, shape_a, shape_b, point, normal, impulse, triangle_a, triangle_b, gap);
  PYBIND11_NUMPY_DTYPE(HitRow, hit, body, shape, distance, point, normal, triangle);

  add_handle<BodyHandle>(module, "Body",
                         "A body of a World. Good until the body is removed, and never given to another one.");
  add_handle<JointHandle>(module, "Joint", "A joint of a World, as a Body is a body.");

  py::class_<BodyEvent>(module, "Event",
                        "Two bodies began or ceased to touch in the last step, or entered or left a trigger. What is "
                        "removed or teleported ceases to touch in the next step.")
      .def_property_readonly(
          "kind", [](const BodyEvent& event) { return name_of(event.kind); },
          "'begin', 'end', 'enter', 'leave' or 'impact'.")
      .def_readonly("a", &BodyEvent::a, "A Body; of 'enter' and 'leave' the one with the trigger.")
      .def_readonly("b", &BodyEvent::b, "The other Body.")
      .def_readonly("shape_a", &BodyEvent::shape_a,
                    "Of a, by its index in the body's description; of several the first.")
      .def_readonly("shape_b", &BodyEvent::shape_b, "The same of b.")
      .def_readonly("triangle_a", &BodyEvent::triangle_a,
                    "Of a surface, with the setting `event_pairs` \"triangles\"; else None.")
      .def_readonly("triangle_b", &BodyEvent::triangle_b, "The same of b.")
      .def_readonly("impact", &BodyEvent::impact,
                    "Of 'impact', for which the setting `impact_speed` asks, an Impact; else None.")
      .def("__repr__", [](const BodyEvent& event) {
        return fmt::format("<lockstep.Event {} of {} and {}>", name_of(event.kind), event.a.id, event.b.id);
      });

  py::class_<Impact>(module, "Impact",
                     "How two bodies came together, at the fastest of their points, and what their contacts gave.")
      .def_readonly("speed", &Impact::speed, "Along the normal, before anything stopped them, m/s.")
      .def_property_readonly(
          "point", [](const Impact& impact) { return to_array(impact.point); }, "Shape (3,), m.")
      .def_property_readonly(
          "normal", [](const Impact& impact) { return to_array(impact.normal); }, "From b to a, shape (3,), unit.")
      .def_property_readonly(
          "impulse", [](const Impact& impact) { return to_array(impact.impulse); },
          "On a, of all their points in the step, shape (3,), N s (docs/reference/forces.md).");

  py::class_<BodyHit>(module, "Hit", "The nearest surface on a ray.")
      .def_readonly("body", &BodyHit::body, "The Body that it is of.")
      .def_readonly("shape", &BodyHit::shape, "By its index in the body's description.")
      .def_readonly("triangle", &BodyHit::triangle, "Of a shape that is a surface; else None.")
      .def_readonly("distance", &BodyHit::distance, "From the origin, m.")
      .def_property_readonly(
          "point", [](const BodyHit& hit) { return to_array(hit.point); }, "Shape (3,), m.")
      .def_property_readonly(
          "normal", [](const BodyHit& hit) { return to_array(hit.normal); }, "Shape (3,), unit.");

  py::class_<JointState>(
      module, "JointState",
      "How a joint stands, and what it does. Forces are the mean of the last step, 0 before the "
      "first; with the setting `forces` 'substep' of its last sub-step (docs/reference/forces.md); world frame.")
      .def_readonly(
          "coordinate", &JointState::coordinate,
          "Angle of a hinge, planar, universal or screw joint, with its revolutions, rad; travel of a slider or "
          "cylindrical joint or length of a distance joint, m; of others 0.")
      .def_readonly("speed", &JointState::speed, "Its rate, rad/s or m/s.")
      .def_readonly("drive", &JointState::drive,
                    "What motor, friction, limits, spring and armature give along the coordinate, N m or N.")
      .def_property_readonly(
          "force", [](const JointState& state) { return to_array(state.force); },
          "Of the joint, but for `drive`, on its second body, at that one's anchor. Shape (3,), N.")
      .def_property_readonly(
          "torque", [](const JointState& state) { return to_array(state.torque); }, "Shape (3,), N m.")
      .def_readonly("separation", &JointState::separation, "How far it is open where it should not be, m.")
      .def_readonly("angle", &JointState::angle, "The same of turning, rad.");

  py::class_<SensorReading>(module, "SensorReading", "What a sensor reads of the last step (docs/reference/forces.md).")
      .def_readonly("name", &SensorReading::name, "Of the sensor in the scene.")
      .def_property_readonly(
          "kind", [](const SensorReading& reading) { return name_of(reading.kind); }, "'force', 'torque' or 'touch'.")
      .def_property_readonly(
          "values",
          [](const SensorReading& reading) {
            return py::array_t<double>(static_cast<py::ssize_t>(reading.values.size()), reading.values.data());
          },
          "Shape (3,): force, N, or torque, N m: of a joint on its second body, in the joint's frame as that body "
          "carries it,\nthe torque about that body's anchor; of contacts on the body, world frame, the torque about "
          "its centre of\nmass. Of touch shape (1,): the sum of the normal forces, N.")
      .def("__repr__", [](const SensorReading& reading) {
        return fmt::format("<lockstep.SensorReading {} of {}>", name_of(reading.kind), reading.name);
      });

  py::class_<StepErrors>(
      module, "StepErrors",
      "How good the last step was, measured in double and outside of it (docs/reference/error_measures.md).")
      .def_readonly("kinetic", &StepErrors::kinetic, "Kinetic energy of the dynamic bodies, J.")
      .def_readonly("potential", &StepErrors::potential, "-m g . x of them, and of joints' springs, J.")
      .def_property_readonly(
          "energy", [](const StepErrors& errors) { return errors.kinetic + errors.potential; }, "The sum, J.")
      .def_property_readonly(
          "momentum", [](const StepErrors& errors) { return to_array(errors.momentum); }, "Shape (3,), kg m/s.")
      .def_property_readonly(
          "angular_momentum", [](const StepErrors& errors) { return to_array(errors.angular_momentum); },
          "About the centre of mass of all, shape (3,), kg m^2/s.")
      .def_readonly("contacts", &StepErrors::contacts, "Contact points, of which some only could have touched.")
      .def_readonly("max_penetration", &StepErrors::max_penetration, "m.")
      .def_readonly("mean_penetration", &StepErrors::mean_penetration, "Over the contacts that overlap, m.")
      .def_readonly("residual", &StepErrors::residual, "Of the contact problem; None where there was none.")
      .def_readonly("defect_velocity", &StepErrors::defect_velocity, "The largest, m/s; None where there was none.")
      .def_readonly("joint_separation", &StepErrors::joint_separation,
                    "How far joints are open at most, m; None without joints.")
      .def_readonly("joint_angle", &StepErrors::joint_angle, "The same of turning, rad; None without joints.")
      .def("__repr__", [](const StepErrors& errors) {
        return fmt::format("<lockstep.StepErrors energy {:.6g} J, penetration {:.3g} m, residual {}>",
                           errors.kinetic + errors.potential, errors.max_penetration,
                           errors.residual ? fmt::format("{:.3g}", *errors.residual) : "none");
      });

  py::class_<Unsolved>(
      module, "Unsolved",
      "Sub-steps that an oracle, or a solver with a tolerance, did not solve; the first and the worst.")
      .def_readonly("count", &Unsolved::count, "So many sub-steps; false where there are none.")
      .def_property_readonly(
          "ended",
          [](const Unsolved& unsolved) {
            py::dict ended;
            for (u32 stop = 1; stop < stop_count; ++stop)
              ended[py::str(stop_name(static_cast<Stop>(stop)))] = unsolved.ended[stop];
            return ended;
          },
          "How many of them ended as 'limit', 'stalled', 'infeasible' and 'bad'.")
      .def_readonly("first_step", &Unsolved::first_step, "The step of the first of them, counted from 0.")
      .def_property_readonly(
          "first_stop", [](const Unsolved& unsolved) { return stop_name(unsolved.first_stop); }, "How it ended there.")
      .def_readonly("worst_step", &Unsolved::worst_step, "The step of the worst of them, counted from 0.")
      .def_readonly("worst_residual", &Unsolved::worst_residual,
                    "Its residual; of a solver that sweeps what the last sweep still changed, m/s.")
      .def_readonly("tolerance", &Unsolved::tolerance, "What was asked for.")
      .def_property_readonly(
          "worst_stop", [](const Unsolved& unsolved) { return stop_name(unsolved.worst_stop); }, "How it ended there.")
      .def("__bool__", [](const Unsolved& unsolved) { return unsolved.count > 0; })
      .def("__repr__", [](const Unsolved& unsolved) {
        return fmt::format("<lockstep.Unsolved {} sub-steps, {:.3g} at worst>", unsolved.count,
                           unsolved.worst_residual);
      });

  py::class_<Judgement>(module, "Judgement",
                        "One figure of a run beside its bound. Steps are told by how many had been done.")
      .def_readonly("worst", &Judgement::worst, "The largest.")
      .def_readonly("bound", &Judgement::bound, "The setting that bounds it.")
      .def_readonly("worst_step", &Judgement::worst_step, "When it was the largest.")
      .def_property_readonly(
          "first_step",
          [](const Judgement& j) { return j.first_step == NONE ? std::nullopt : std::optional(j.first_step); },
          "When it first was above the bound; None where it never was.");

  py::class_<Verdict> verdict(
      module, "Verdict",
      "How a run came out (docs/reference/error_measures.md); true where all figures kept their bounds.");
#define CRITERION(name, bound, unit, meaning) \
  verdict.def_property_readonly(              \
      #name, [](const Verdict& v) { return v[Criterion::name]; }, meaning);
#include "host/verdict.def"
  verdict
      .def_property_readonly(
          "not_judged_because",
          [](const Verdict& v) {
            const std::string source = in_words(v.energy_source);
            return source.empty() ? std::nullopt : std::optional(source);
          },
          "Why the gain of energy, and of particles the overlap, is not judged; None where all is.")
      .def("__bool__", &Verdict::good)
      .def("__str__", [](const Verdict& v) { return in_words(v); })
      .def("__repr__", [](const Verdict& v) { return fmt::format("<lockstep.Verdict {}>", in_words(v)); });

  py::class_<Snapshot, std::unique_ptr<Snapshot, DeletedWhereMade>>(
      module, "Snapshot", with_collected_loads<Snapshot>(),
      "A World as it was at some time, in memory, on the device where it is (World.save()). It may be "
      "kept as\nlong as one likes, and its world may go before it.")
      .def_property_readonly("steps_done", &Snapshot::steps_done, "Of the world, when it was made.")
      .def_property_readonly("time", &Snapshot::time, "The same, s.")
      .def("__repr__", [](const Snapshot& snapshot) {
        return fmt::format("<lockstep.Snapshot after {} steps>", snapshot.steps_done());
      });

  py::class_<WorldDevice>(module, "Device", "What a world computes on.")
      .def_readonly("name", &WorldDevice::name, "As `lockstep devices` has it, or 'reference'.")
      .def_readonly("bit_exact", &WorldDevice::bit_exact, "Its bits are those of every other device.")
      .def_readonly("canary", &WorldDevice::canary, "The same in words, with the first thing that differs.")
      .def("__repr__", [](const WorldDevice& device) {
        return fmt::format("<lockstep.Device {}, {}>", device.name, device.canary);
      });
}

namespace {

// What an array says where there is none.
std::int64_t number_of(const std::optional<u32>& triangle) { return triangle ? std::int64_t{*triangle} : -1; }

}  // namespace

py::array to_array(std::span<const BodyContact> contacts) {
  py::array_t<ContactRow> rows(static_cast<py::ssize_t>(contacts.size()));
  ContactRow* row = rows.mutable_data();
  for (const BodyContact& contact : contacts) {
    *row = {contact.a.id,
            contact.b.id,
            contact.shape_a,
            contact.shape_b,
            {},
            {},
            {},
            number_of(contact.triangle_a),
            number_of(contact.triangle_b),
            contact.gap};
    store(contact.point, row->point);
    store(contact.normal, row->normal);
    store(contact.impulse, row->impulse);
    ++row;
  }
  return rows;
}

py::array to_array(std::span<const std::optional<BodyHit>> hits) {
  py::array_t<HitRow> rows(static_cast<py::ssize_t>(hits.size()));
  HitRow* row = rows.mutable_data();
  for (const std::optional<BodyHit>& hit : hits) {
    *row = {hit.has_value(), NONE, NONE, std::numeric_limits<double>::infinity(), {}, {}, -1};
    if (hit) {
      row->body = hit->body.id;
      row->shape = hit->shape;
      row->triangle = number_of(hit->triangle);
      row->distance = hit->distance;
      store(hit->point, row->point);
      store(hit->normal, row->normal);
    }
    ++row;
  }
  return rows;
}

}  // namespace lockstep::python
