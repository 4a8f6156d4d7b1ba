// The class World: how it is made, which bodies and joints it has, and time.
#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include "host/scene/joint_kinds.hpp"
#include "python/shared_world.hpp"

namespace lockstep::python {

namespace {

WorldOptions options_of(const py::object& device, const std::string& precision, u32 threads, const std::string& solver,
                        bool quiet) {
  return {py::str(device).cast<std::string>(), precision, threads, solver, quiet};
}

template <class Handle>
Handle found(const std::optional<Handle>& handle, const char* what, const std::string& name) {
  if (!handle) throw Error(Failure::input, "world", fmt::format("has no {} of the name '{}'", what, name));
  return *handle;
}

const char* name_of(BodyKind kind) {
  return kind == BODY_STATIC ? "static" : kind == BODY_KINEMATIC ? "kinematic" : "dynamic";
}

// What is asked of a body and of a joint alike.
template <class Handle>
void add_lifetime(WorldClass& world, const char* argument, const char* removes) {
  world
      .def(
          "remove", [](SharedWorld& shared, Handle handle) { shared.use().remove(handle); }, py::arg(argument), removes)
      .def(
          "contains", [](SharedWorld& shared, Handle handle) { return shared.use().contains(handle); },
          py::arg(argument), "Whether it is there still.")
      .def(
          "name", [](SharedWorld& shared, Handle handle) { return shared.use().description(handle).name; },
          py::arg(argument), "Its name in the scene, '' without one.");
}

void add_making(WorldClass& world) {
  world
      .def(
          py::init([](const py::object& scene, const py::object& device, const std::string& precision, u32 threads,
                      const std::string& solver, const std::string& source, u32 seed, bool quiet, bool strict,
                      bool approximate) {
            return std::unique_ptr<SharedWorld, DeletedWhereMade>(new SharedWorld(
                [text = json_text(scene, source), source, seed, strict, approximate] {
                  return parse_scene(text, source, seed, {strict, approximate});
                },
                options_of(device, precision, threads, solver, quiet)));
          }),
          py::arg("scene"), py::kw_only(), py::arg("device") = "auto", py::arg("precision") = "",
          py::arg("threads") = 0, py::arg("solver") = "", py::arg("source") = "scene.json", py::arg("seed") = 0,
          py::arg("quiet") = false, py::arg("strict") = false, py::arg("approximate") = false,
          "A world of a scene: a dict, or JSON text, as docs/reference/scene_format.md describes it.\n\n"
          "device: 'auto', 'gpu', 'cpu', 'reference', or the index of one of lockstep.devices().\n"
          "precision: 'float' or 'double'; '' is what the scene says.\n"
          "threads: of a CPU device; 0 is all.\n"
          "solver: one of lockstep.solvers() with the settings that it brings; '' is what the scene says.\n"
          "source: stands for the file in errors; meshes and robots are looked for from its folder. Text whose source\n"
          "ends in '.urdf' or '.xml' is a robot.\n"
          "seed: of what the scene draws at random, as --seed.\n"
          "quiet: no line on stderr, where that is a terminal, when building kernels takes more than a second.\n"
          "strict: refuse what of a robot's file would be left out; a warning tells of it otherwise.\n"
          "approximate: leave out or replace what of it changes the motion and is not simulated.")
      .def_static(
          "load",
          [](const std::filesystem::path& path_or_name, const py::object& device, const std::string& precision,
             u32 threads, const std::string& solver, u32 seed, bool quiet, bool strict, bool approximate,
             const std::map<std::string, std::string>& packages, const std::string& keyframe) {
            return std::unique_ptr<SharedWorld, DeletedWhereMade>(new SharedWorld(
                [path = path_or_name.string(), seed, strict, approximate, packages, keyframe] {
                  return read_scene(path, seed, {strict, approximate, packages, keyframe});
                },
                options_of(device, precision, threads, solver, quiet)));
          },
          py::arg("path_or_name"), py::kw_only(), py::arg("device") = "auto", py::arg("precision") = "",
          py::arg("threads") = 0, py::arg("solver") = "", py::arg("seed") = 0, py::arg("quiet") = false,
          py::arg("strict") = false, py::arg("approximate") = false,
          py::arg("packages") = std::map<std::string, std::string>(), py::arg("keyframe") = "",
          "A world of a scene file, a robot, or a built-in scene by its name. Of robot files: strict refuses what "
          "would\n"
          "be left out, of which a warning tells; approximate leaves out, and tells, what changes the motion and is "
          "not\n"
          "simulated; packages has the folders of package://NAME by name; keyframe names the <key> of an MJCF\n"
          "file, or has the number of one without a name, that joints start at and servos want.")
      .def_property_readonly(
          "device", [](SharedWorld& shared) { return shared.ask([](World& of) { return of.device(); }); },
          "What it computes on, a Device. Runs the canary when first asked, a small kernel, once in a process.");
}

void add_bodies(WorldClass& world) {
  add_lifetime<BodyHandle>(world, "body", "Removes a body and the joints that hold it.");
  world
      .def_property_readonly(
          "bodies", [](SharedWorld& shared) { return list_of(shared.use().bodies()); },
          "All bodies, oldest first: the rows of poses() and velocities(). A new list of Body.")
      .def(
          "body",
          [](SharedWorld& shared, const std::string& name) { return found(shared.use().find(name), "body", name); },
          py::arg("name"), "The body of this name in the scene.")
      .def(
          "add_body", [](SharedWorld& shared, const py::object& body) { return shared.add_body(body); },
          py::arg("body"),
          "Adds a body: a dict, or JSON text, as an entry of 'bodies' in a scene file. Takes effect with the next "
          "step\n"
          "or question, and costs time in proportion to the whole scene, once for all changes between two steps.")
      .def(
          "teleport",
          [](SharedWorld& shared, BodyHandle body, const Vector3& position, const Quaternion& orientation,
             const Vector3& velocity, const Vector3& angular_velocity) {
            shared.use().teleport(body, {position, orientation}, {velocity, angular_velocity});
          },
          py::arg("body"), py::arg("position"), py::arg("orientation") = Quaternion{0, 0, 0, 1},
          py::arg("velocity") = Vector3{0, 0, 0}, py::arg("angular_velocity") = Vector3{0, 0, 0},
          "Sets the pose of a body, as though it were removed and added again, but that it, its joints and its load\n"
          "stay. Position of the centre of mass, m; quaternion x y z w; m/s; rad/s.")
      .def(
          "place",
          [](const py::object& self, const py::args& args, const py::kwargs& named) {
            if (PyErr_WarnEx(PyExc_DeprecationWarning, "place() is called teleport()", 1) < 0)
              throw py::error_already_set();
            return self.attr("teleport")(*args, **named);
          },
          "The old name of teleport().")
      .def(
          "kind", [](SharedWorld& shared, BodyHandle body) { return name_of(shared.use().description(body).kind); },
          py::arg("body"), "'static', 'kinematic' or 'dynamic'.")
      .def(
          "mass", [](SharedWorld& shared, BodyHandle body) { return shared.use().description(body).mass; },
          py::arg("body"), "kg; 0 of one that is not dynamic.")
      .def(
          "inertia",
          [](SharedWorld& shared, BodyHandle body) { return to_array(shared.use().description(body).inertia); },
          py::arg("body"), "Principal moments about the centre of mass, shape (3,), kg m^2.");
}

void add_joints(WorldClass& world) {
  add_lifetime<JointHandle>(world, "joint", "Removes a joint.");
  world
      .def_property_readonly(
          "joints", [](SharedWorld& shared) { return list_of(shared.use().joints()); },
          "All joints, oldest first. A new list of Joint.")
      .def(
          "joint",
          [](SharedWorld& shared, const std::string& name) {
            return found(shared.use().find_joint(name), "joint", name);
          },
          py::arg("name"), "The joint of this name, else the only one that has the body of this name as its second.")
      .def(
          "add_joint",
          [](SharedWorld& shared, const py::object& joint, BodyHandle a, const std::optional<BodyHandle>& b) {
            const JointDescription description = parse_joint(json_text(joint, "joint"), "joint");
            return b ? shared.use().add(description, a, *b) : shared.use().add(description, a);
          },
          py::arg("joint"), py::arg("a"), py::arg("b") = py::none(),
          "Holds two bodies together as they stand now, or one to the world: a dict, or JSON text, as an entry of\n"
          "'joints' in a scene file but for 'bodies'. Anchors and axes are in the world frame of this moment.")
      .def(
          "kind",
          [](SharedWorld& shared, JointHandle joint) {
            return lockstep::name_of(shared.use().description(joint).kind);
          },
          py::arg("joint"), "'ball', 'hinge' and so on, as in a scene file.")
      .def(
          "joint_state", [](SharedWorld& shared, JointHandle joint) { return shared.use_ready().state(joint); },
          py::arg("joint"), "How it stands and what it does, a JointState.")
      .def(
          "set_motor",
          [](SharedWorld& shared, JointHandle joint, double speed, double force) {
            shared.use().set_motor(joint, speed, force);
          },
          py::arg("joint"), py::arg("speed"), py::arg("force"),
          "Drives its free angle, way or distance from now on: `speed` of the second body against the first, rad/s or\n"
          "m/s, by at most `force`, N m or N; 0: not at all.")
      .def(
          "set_rest", [](SharedWorld& shared, JointHandle joint, double rest) { shared.use().set_rest(joint, rest); },
          py::arg("joint"), py::arg("rest"),
          "Moves where the spring of a joint rests, m or rad from where its coordinate is 0: the target of a servo.");
}

void add_actuators(WorldClass& world) {
  using Actuator = std::variant<u32, std::string>;
  world
      .def_property_readonly(
          "actuators",
          [](SharedWorld& shared) {
            std::vector<std::string> names;
            for (const ActuatorDescription& actuator : shared.use().actuators()) names.push_back(actuator.name);
            return names;
          },
          "Names of the actuators of the scene's robots, ROBOT/ACTUATOR, in the order of their files.")
      .def_property_readonly(
          "controls",
          [](SharedWorld& shared) {
            std::vector<double> controls;
            for (const ActuatorDescription& actuator : shared.use().actuators()) controls.push_back(actuator.control);
            return py::array_t<double>(py::ssize_t(controls.size()), controls.data());
          },
          "What each actuator wants, in its units. Shape (actuators,), a copy; set_control() and set_controls() change "
          "it.")
      .def(
          "set_control",
          [](SharedWorld& shared, const Actuator& actuator, double control) {
            World& of = shared.use();
            const u32* number = std::get_if<u32>(&actuator);
            of.set_control(number != nullptr ? *number : of.actuator(std::get<std::string>(actuator)), control);
          },
          py::arg("actuator"), py::arg("control"),
          "What an actuator, by its number or name, wants from the next step on; its range bounds it. Wakes what its\n"
          "joint holds. Raises Error for one that is not simulated, saying why.")
      .def(
          "set_controls",
          [](SharedWorld& shared, const std::vector<double>& controls) {
            World& of = shared.use();
            if (controls.size() != of.actuators().size())
              throw Error(Failure::input, "controls",
                          "must be " + std::to_string(of.actuators().size()) + " numbers, are " +
                              std::to_string(controls.size()));
            for (u32 i = 0; i < controls.size(); ++i) of.set_control(i, controls[i]);
          },
          py::arg("controls"), "All of them, shape (actuators,).");
}

void add_time(WorldClass& world) {
  world
      .def("step", &SharedWorld::step, py::arg("count") = 1,
           "So many time steps of the scene's `dt`. Other threads of Python run meanwhile. Ctrl-C raises "
           "KeyboardInterrupt\n"
           "at once: a step that has begun is made, and what is asked of the world next waits for it.")
      .def_property_readonly(
          "steps_done", [](SharedWorld& shared) { return shared.use().steps_done(); }, "Steps since the beginning.")
      .def_property_readonly(
          "time", [](SharedWorld& shared) { return shared.use().time(); },
          "s: steps_done times the step, without what adding steps up would round.")
      .def_property_readonly(
          "time_step", [](SharedWorld& shared) { return shared.use().time_step(); }, "The scene's `dt`, s.")
      .def_property_readonly(
          "substeps", [](SharedWorld& shared) { return shared.use().substeps(); }, "Sub-steps of each step.")
      .def_property_readonly(
          "substep_length", [](SharedWorld& shared) { return shared.use().substep_length(); },
          "`time_step` over `substeps`, s.")
      .def(
          "warm_up",
          [](SharedWorld& shared, bool forces, bool questions, const py::list& bodies) {
            shared.warm_up(forces, questions, bodies);
          },
          py::kw_only(), py::arg("forces") = true, py::arg("questions") = true, py::arg("bodies") = py::list(),
          "Builds the kernels that the next step, and what is expected, are going to need, which takes seconds where\n"
          "they were never built before. Changes nothing of the world. forces: apply_force() and its like; questions:\n"
          "rays and volumes; bodies: a list of such as are going to be added, as add_body() takes them.")
      .def(
          "save", [](SharedWorld& shared) { return shared.use_ready().save(); },
          "The world as it is, a Snapshot: all that a checkpoint has, bodies and joints, what acts on them, what is to "
          "be\n"
          "done with the next step. In memory, on the device where it is.")
      .def(
          "restore", [](SharedWorld& shared, const Snapshot& snapshot) { shared.use().restore(snapshot); },
          py::arg("snapshot"),
          "Goes back, or forth, to a Snapshot of this world: bodies and joints that have come or gone are as they "
          "were,\n"
          "handles of then good again, and the same calls give the same bits. contacts(), events() and verdict are "
          "those\n"
          "of then; errors() are of no contacts until the next step. A recording goes on, and notes it. Also after a "
          "step\n"
          "has failed. A snapshot of another world is an Error.")
      .def_property_readonly(
          "unsolved", [](SharedWorld& shared) { return shared.use().unsolved(); },
          "What an oracle has left unsolved so far, an Unsolved; nothing of a solver that promises no residual.")
      .def_property_readonly(
          "verdict", [](SharedWorld& shared) { return shared.ask([](World& of) { return of.verdict(); }); },
          "How the run came out so far, a Verdict of all steps and of the state as it is.")
      .def(
          "suspicions", [](SharedWorld& shared) { return shared.ask([](World& of) { return of.suspicions(); }); },
          "What looks like a mistake in the world as it starts, a str each with its cure "
          "(docs/how_to/when_it_looks_wrong.md);\n"
          "the first step() warns of each. Nothing once it has been stepped.")
      .def(
          "record",
          [](SharedWorld& shared, const std::filesystem::path& path, bool forces) {
            shared.use().record(path.string(), forces ? RecordedData::motion_and_forces : RecordedData::motion);
          },
          py::arg("path"), py::arg("forces") = false,
          "Records every step from now on in a file of HDF5 that `lockstep verify` replays and `lockstep render` "
          "draws\n"
          "(docs/how_to/record_and_verify.md), with forces=True also the force of each contact and joint. When bodies "
          "come and go, "
          "and from the first force on, run.h5 goes on in run.2.h5.")
      .def(
          "end_recording", [](SharedWorld& shared) { shared.use().end_recording(); },
          "Closes the recording, as the end of the world does.");
}

}  // namespace

void add_world(py::module_& module) {
  watch_process(&SharedWorld::end_recordings, &SharedWorld::forget_worlds);
  WorldClass world(module, "World", with_collected_loads<SharedWorld>(),
                   "A world of rigid bodies. SI units, z up, quaternions x y z w, world frame.\n\n"
                   "Arrays that it gives are copies, for what they were copied from goes with the next step; poses()\n"
                   "and velocities() can fill one of yours. One thread at a time may use a world.");
  add_making(world);
  add_actuators(world);
  add_bodies(world);
  add_joints(world);
  add_time(world);
  add_questions(world);
  add_actions(world);
  add_changes(world);
}

}  // namespace lockstep::python
