// A world as Python has it: the library's, the names that its bodies use, and a guard against two threads.
#pragma once

#include <algorithm>
#include <chrono>
#include <utility>
#include <variant>

#include "host/scene/categories.hpp"
#include "host/scene/read.hpp"
#include "python/bindings.hpp"

namespace lockstep::python {

/// A warning for each line about a source: a DeprecationWarning for notes (Scene::notes), a UserWarning for suspicions.
inline void warn(const std::string& source, const std::vector<std::string>& lines,
                 PyObject* category = PyExc_DeprecationWarning) {
  for (const std::string& line : lines)
    if (PyErr_WarnEx(category, (source + ": " + line).c_str(), 1) != 0) throw py::error_already_set();
}

/// Of a question, as Python gives it.
using Mask = std::variant<u32, std::string, std::vector<std::string>>;

class SharedWorld {
 public:
  SharedWorld(const Scene& scene, const WorldOptions& options) : world_(scene, options), source_(scene.source) {
    words_.materials = scene.materials;
    words_.categories = scene.categories;
    words_.particles = scene.particles;
  }

  /// Throws Error (input) while it is stepped: by another thread, or from a load that is asked for by step().
  World& use() {
    if (stepping_) throw Error(Failure::input, "world", "is being stepped; ask and act between two steps");
    return world_;
  }

  /// Other Python threads run meanwhile. What a signal raises, as Ctrl-C does KeyboardInterrupt, is raised between two
  /// steps: the world is as after the last one that was made.
  void step(u32 count) {
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::milliseconds between_looks{50};
    World& world = use();
    if (count > 0 && !std::exchange(is_looked_at_, true)) warn(source_, world.suspicions(), PyExc_UserWarning);
    const Stepping stepping(stepping_);
    const py::gil_scoped_release released;
    u32 at_once = 1;
    for (u32 done = 0; done < count;) {
      const Clock::time_point start = Clock::now();
      const u32 next = std::min(at_once, count - done);
      world.step(next);
      done += next;
      if (2 * (Clock::now() - start) < between_looks) at_once = std::min(2 * at_once, 1u << 20);
      if (done == count) return;
      const py::gil_scoped_acquire lock;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }
  }

  BodyHandle add_body(const py::object& body) { return use().add(described(body, "body")); }

  /// One whose name is left out keeps it.
  void change_body(BodyHandle body, const py::object& change) {
    World& world = use();
    const std::string name = world.description(body).name;
    BodyDescription description = described(change, called("body", name));
    if (description.name.empty()) description.name = name;
    world.change(body, description);
  }
  void change_joint(JointHandle joint, const py::object& change) {
    World& world = use();
    const JointDescription& before = world.description(joint);
    const std::string where = called("joint", before.name);
    JointDescription description = parse_joint_change(json_text(change, where), where, before);
    if (description.name.empty()) description.name = before.name;
    world.change(joint, description);
  }

  /// Bits of categories, or their names.
  u32 mask_of(const Mask& mask) const {
    if (const u32* bits = std::get_if<u32>(&mask)) return *bits;
    if (const std::string* name = std::get_if<std::string>(&mask)) return category_mask(words_.categories, {*name});
    return category_mask(words_.categories, std::get<std::vector<std::string>>(mask));
  }

  void warm_up(bool forces, bool questions, const py::list& bodies) {
    Expected expected = {forces, questions, {}};
    for (const py::handle& body : bodies)
      expected.bodies.push_back(described(py::reinterpret_borrow<py::object>(body), "body"));
    World& world = use();
    const Stepping stepping(stepping_);
    const py::gil_scoped_release released;
    world.warm_up(expected);
  }

 private:
  static std::string called(const char* what, const std::string& name) {
    return name.empty() ? what : std::string(what) + " \"" + name + '"';
  }

  BodyDescription described(const py::object& description, const std::string& where) {
    BodyDescription body = parse_body(json_text(description, where), where, words_);
    warn("body", std::exchange(words_.notes, {}));
    return body;
  }

  // Set and unset by who has Python's lock.
  struct Stepping {
    explicit Stepping(bool& flag) : flag_(flag) { flag_ = true; }
    ~Stepping() { flag_ = false; }
    bool& flag_;
  };

  World world_;
  const std::string source_;
  bool is_looked_at_ = false;  // for what looks like a mistake: before the first step
  Scene words_;                // of materials and categories; has no bodies
  bool stepping_ = false;
};

using WorldClass = py::class_<SharedWorld>;

/// Each adds its part of the class.
void add_questions(WorldClass& world);
void add_actions(WorldClass& world);
void add_changes(WorldClass& world);

}  // namespace lockstep::python
