// What is wrong with the arguments of a call, in one line.
#pragma once

#include "python/bindings.hpp"

namespace lockstep::python {

/// Functions and classes of the module raise a TypeError of one line that says what is wanted and what is given, where
/// pybind11 lists signatures over four and more.
void tell_argument_errors_in_one_line(py::module_& module);

}  // namespace lockstep::python
