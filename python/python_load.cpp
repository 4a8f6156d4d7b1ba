#include "python/python_load.hpp"

namespace lockstep::python {

PythonLoad::~PythonLoad() {
  if (!function_) return;
  if (!Py_IsInitialized()) {
    function_.release();
    return;
  }
  const py::gil_scoped_acquire lock;
  function_ = {};
}

Wrench PythonLoad::operator()(double time) const {
  Wrench load;
  with_lock([&] {
    const py::object result = function_(time);
    try {
      const auto six = result.cast<std::array<double, 6>>();
      load = {{six[0], six[1], six[2]}, {six[3], six[4], six[5]}};
    } catch (const py::cast_error&) {
      throw Error(Failure::input, "load",
                  "must give six numbers, force (N) and torque (N m), gives " + py::repr(result).cast<std::string>());
    }
  });
  return load;
}

}  // namespace lockstep::python
