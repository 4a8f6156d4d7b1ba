#include "python/bindings.hpp"

namespace lockstep::python {

std::string json_text(const py::object& scene) {
  if (py::isinstance<py::str>(scene)) return scene.cast<std::string>();
  // arrays and numbers of NumPy
  const py::cpp_function as_list([](const py::object& value) -> py::object {
    if (py::hasattr(value, "tolist")) return value.attr("tolist")();
    throw py::type_error("a scene is made of dicts, lists, numbers, texts and arrays, not of " +
                         py::repr(py::type::of(value)).cast<std::string>());
  });
  return py::module_::import("json").attr("dumps")(scene, py::arg("default") = as_list).cast<std::string>();
}

}  // namespace lockstep::python
