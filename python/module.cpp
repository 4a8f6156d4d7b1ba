// The module itself: its error, what there is to simulate, and on what.
#include "host/device/devices.hpp"
#include "host/scene/read.hpp"
#include "host/scene/setting_table.hpp"
#include "python/argument_errors.hpp"
#include "python/long_call.hpp"

namespace lockstep::python {

namespace {

const char* name_of(Failure failure) {
  switch (failure) {
    case Failure::comparison: return "comparison";
    case Failure::input: return "input";
    default: return "device";
  }
}

void add_error(py::module_& module) {
  static py::exception<Error> error(module, "Error");
  error.attr("__doc__") =
      "What went wrong, in one line that says where and what would cure it.\n\n"
      "`failure` is 'input' for what makes no sense, 'comparison' for a run that went bad, 'device' for one that a\n"
      "device or a disk did not take.";
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const Error& failed) {
      const py::object instance = py::reinterpret_borrow<py::object>(error)(failed.what());
      instance.attr("failure") = name_of(failed.failure());
      PyErr_SetObject(error.ptr(), instance.ptr());
    }
  });
}

// Arrays of NumPy 2 are laid out otherwise, which pybind11 knows from 2.12 on; before, numbers would be wrong in
// silence.
void expect_known_numpy() {
#if PYBIND11_VERSION_HEX < 0x020C0000
  const std::string version = py::module_::import("numpy").attr("__version__").cast<std::string>();
  if (std::stoi(version) < 2) return;
  throw py::import_error("lockstep was built with a pybind11 that does not know NumPy " + version +
                         "; use NumPy 1, or build it with pybind11 2.12 or later");
#endif
}

py::dict scenes() {
  py::dict found;
  for (const SceneListing& scene : built_in_scenes()) found[py::str(scene.name)] = scene.description;
  return found;
}

py::dict settings() {
  py::dict found;
  for (const SettingInfo& row : setting_infos()) {
    std::vector<std::string> names = names_of(row);
    found[py::str(row.name)] =
        py::dict(py::arg("meaning") = row.meaning, py::arg("unit") = row.unit, py::arg("bounds") = row.bounds.text(),
                 py::arg("names") = py::tuple(py::cast(names)));
  }
  return found;
}

py::dict solvers() {
  py::dict found;
  for (const SolverInfo& solver : solver_infos)
    found[py::str(solver.name)] =
        py::dict(py::arg("substeps") = solver.substeps, py::arg("iterations") = solver.iterations,
                 py::arg("tolerance") = solver.tolerance, py::arg("precision") = solver.precision,
                 py::arg("what") = solver.what, py::arg("use") = solver.use);
  return found;
}

std::vector<std::string> devices() {
  std::shared_ptr<LongCall> pending;
  return run_long(pending, [] {
    std::vector<std::string> names;
    for (const DeviceInfo& device : list_devices()) names.push_back(device.name);
    return names;
  });
}

}  // namespace

}  // namespace lockstep::python

// The package lockstep (python/lockstep/__init__.py) has all of it, and classes say that they are its own.
PYBIND11_MODULE(_lockstep, module) {
  using namespace lockstep::python;
  expect_known_numpy();
  module.doc() = "What of the package lockstep is compiled.";
  const py::object name = module.attr("__name__");
  module.attr("__name__") = "lockstep";
  module.attr("__version__") = LOCKSTEP_VERSION;
  add_error(module);
  module.def("scenes", &scenes, "The built-in scenes: a dict from names to what a viewer should see.");
  module.def("settings", &settings,
             "The keys of a scene's 'settings': a dict from names to their meaning, unit, bounds, and the names that "
             "they\n"
             "take.");
  module.def("solvers", &solvers,
             "The names that the setting 'solver' takes: a dict from names to what the solver brings unless a scene "
             "sets it\n"
             "(substeps, iterations, tolerance, precision), what it does, and what for.");
  module.def("devices", &devices,
             "Names of the OpenCL devices here, by their index; without any there is 'reference'.");
  add_records(module);
  add_world(module);
  tell_argument_errors_in_one_line(module);
  module.attr("__name__") = name;
}
