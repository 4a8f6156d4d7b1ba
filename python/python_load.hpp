// Functions of Python as loads, where Python's collector of cycles sees them.
#pragma once

#include "python/long_call.hpp"

namespace lockstep::python {

/// Each copy refers to the function. It is called, copied and let go of by threads that need not have Python's lock.
class PythonLoad {
 public:
  explicit PythonLoad(py::function function) : function_(std::move(function)) {}
  PythonLoad(PythonLoad&&) noexcept = default;
  PythonLoad(const PythonLoad& other) {
    const py::gil_scoped_acquire lock;
    function_ = other.function_;
  }
  PythonLoad& operator=(const PythonLoad&) = delete;
  ~PythonLoad();

  /// Throws what the function raises, and Error (input) where it gives something else than six numbers.
  Wrench operator()(double time) const;
  PyObject* function() const { return function_.ptr(); }

 private:
  py::function function_;
};

inline const auto& loads_of(const Snapshot& snapshot) { return snapshot.loads(); }
inline void clear_loads(Snapshot& snapshot) { snapshot = {}; }

/// What a type whose objects have loads tells Python's collector: `loads_of(object)`, which may be in use by work that
/// goes on, and `clear_loads(object)`, which lets go of them.
template <class Owner>
py::custom_type_setup with_collected_loads() {
  struct Slots {
    // null of an object whose making has not ended
    static Owner* owner(PyObject* self) {
      auto* instance = reinterpret_cast<py::detail::instance*>(self);
      const auto value = instance->get_value_and_holder();
      return value.holder_constructed() ? value.template value_ptr<Owner>() : nullptr;
    }
    static int traverse(PyObject* self, visitproc tell, void* argument) {
      if (const int ends = tell(reinterpret_cast<PyObject*>(Py_TYPE(self)), argument); ends != 0) return ends;
      if (const Owner* of = owner(self)) {
        for (const auto& [id, load] : loads_of(*of)) {
          const auto* python = load.template target<PythonLoad>();
          if (python == nullptr) continue;
          if (const int ends = tell(python->function(), argument); ends != 0) return ends;
        }
      }
      return 0;
    }
    static int clear(PyObject* self) {
      if (Owner* of = owner(self)) clear_loads(*of);
      return 0;
    }
    static void deallocate(PyObject* self) {
      PyObject_GC_UnTrack(self);
      py::detail::pybind11_object_dealloc(self);
    }
  };
  return py::custom_type_setup([](PyHeapTypeObject* heap_type) {
    PyTypeObject& type = heap_type->ht_type;
    type.tp_flags |= Py_TPFLAGS_HAVE_GC;
    type.tp_traverse = Slots::traverse;
    type.tp_clear = Slots::clear;
    type.tp_dealloc = Slots::deallocate;
  });
}

}  // namespace lockstep::python
