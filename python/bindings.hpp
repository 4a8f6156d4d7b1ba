// What the files of the Python module share: each adds its part of it.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "include/lockstep/world.hpp"

namespace lockstep::python {

namespace py = pybind11;

/// A new array of shape (n,).
template <std::size_t n>
py::array_t<double> to_array(const std::array<double, n>& values) {
  return py::array_t<double>(static_cast<py::ssize_t>(n), values.data());
}

/// A new list of records or handles.
template <class Records>
py::list list_of(const Records& records) {
  py::list list;
  for (const auto& record : records) list.append(py::cast(record));
  return list;
}

/// JSON of a dict, whose arrays may be NumPy's; text stays as it is.
std::string json_text(const py::object& scene, const std::string& source);

/// Handles, and the records that questions are answered with.
void add_records(py::module_& module);
/// Rows of a structured array, in its dtype.
py::array to_array(std::span<const BodyContact> contacts);
py::array to_array(std::span<const std::optional<BodyHit>> hits);

void add_world(py::module_& module);

}  // namespace lockstep::python
