#include <cmath>

#include "python/bindings.hpp"

namespace lockstep::python {

namespace {

// The first number in it that JSON does not have, with its place; empty: none.
std::string not_finite(const py::handle& value, const std::string& path) {
  std::string found;
  if (py::isinstance<py::float_>(value)) {
    if (!std::isfinite(value.cast<double>()))
      return (path.empty() ? "/" : path) + ": must be finite, is " + py::repr(value).cast<std::string>();
  } else if (py::isinstance<py::dict>(value)) {
    for (const auto& [key, inner] : py::reinterpret_borrow<py::dict>(value))
      if (found.empty()) found = not_finite(inner, path + "/" + py::str(key).cast<std::string>());
  } else if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
    std::size_t i = 0;
    for (const py::handle inner : value) {
      if (found.empty()) found = not_finite(inner, path + "/" + std::to_string(i));
      ++i;
    }
  }
  return found;
}

}  // namespace

std::string json_text(const py::object& scene, const std::string& source) {
  if (py::isinstance<py::str>(scene)) return scene.cast<std::string>();
  // arrays and numbers of NumPy
  const py::cpp_function as_list([](const py::object& value) -> py::object {
    if (py::hasattr(value, "tolist")) return value.attr("tolist")();
    throw py::type_error("a scene is made of dicts, lists, numbers, texts and arrays, not of " +
                         py::repr(py::type::of(value)).cast<std::string>());
  });
  const py::module_ json = py::module_::import("json");
  const py::object dumped = json.attr("dumps")(scene, py::arg("default") = as_list);
  const auto text = dumped.cast<std::string>();
  for (const char* word : {"NaN", "Infinity"})
    if (text.find(word) != std::string::npos)
      if (const std::string refusal = not_finite(json.attr("loads")(dumped), ""); !refusal.empty())
        throw Error(Failure::input, source, refusal);
  return text;
}

}  // namespace lockstep::python
