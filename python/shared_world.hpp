// A world as Python has it: the library's, the names that its bodies use, and a guard against two threads.
#pragma once

#include <unistd.h>

#include <chrono>
#include <utility>
#include <variant>

#include "host/scene/categories.hpp"
#include "host/scene/read.hpp"
#include "python/python_load.hpp"

namespace lockstep::python {

/// A warning for each line about a source: a DeprecationWarning for notes (Scene::notes), a UserWarning for suspicions.
inline void warn(const std::string& source, const std::vector<std::string>& lines,
                 PyObject* category = PyExc_DeprecationWarning) {
  for (const std::string& line : lines)
    if (PyErr_WarnEx(category, (source + ": " + line).c_str(), 1) != 0) throw py::error_already_set();
}

/// Of a question, as Python gives it.
using Mask = std::variant<u32, std::string, std::vector<std::string>>;

/// What belongs to the process that made it: a child of fork() lets it be, for the threads of drivers and of recordings
/// are not there.
struct DeletedWhereMade {
  pid_t process = getpid();
  template <class T>
  void operator()(T* object) const {
    if (process == getpid()) delete object;
  }
};

class SharedWorld {
 public:
  /// Of a scene as `read` gives it; others run meanwhile.
  SharedWorld(std::function<Scene()> read, const WorldOptions& options);
  SharedWorld(const SharedWorld&) = delete;
  SharedWorld& operator=(const SharedWorld&) = delete;
  ~SharedWorld();

  /// Throws Error (input) while it is stepped: by another thread, or from a load that is asked for by step(); and in a
  /// child of the process that made it. Waits for a call that Ctrl-C took back, and throws what that threw.
  World& use();
  /// The same, made anew where bodies or joints have come, gone or changed, which may take long.
  World& use_ready();

  /// What `question` gives, which may take long. It has all that it needs, for it may go on after Ctrl-C.
  template <class Question>
  auto ask(Question question) {
    use();
    const Busy busy(is_busy_);
    return run_long(pending_, [world = world_, question = std::move(question)]() mutable { return question(*world); });
  }

  /// Other Python threads run meanwhile. What a signal raises, as Ctrl-C does KeyboardInterrupt, is raised at once: a
  /// step that has begun is made, and whatever is asked of the world next waits for it.
  void step(u32 count);

  /// Ends what it records; of a world that is stepped nothing.
  static void end_recordings();
  /// Of the process that a fork() was made in.
  static void forget_worlds();

  friend const auto& loads_of(const SharedWorld& shared) { return shared.world_->loads(); }
  // of one that a step goes on with it is done another time
  friend void clear_loads(SharedWorld& shared) {
    if (!shared.is_busy_ && !(shared.pending_ && shared.pending_->goes_on())) shared.world_->clear_loads();
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
    ask([expected](World& world) { world.warm_up(expected); });
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
  struct Busy {
    explicit Busy(bool& flag) : flag_(flag) { flag_ = true; }
    Busy(const Busy&) = delete;
    Busy& operator=(const Busy&) = delete;
    ~Busy() { flag_ = false; }
    bool& flag_;
  };

  using Clock = std::chrono::steady_clock;
  void note_steps(u32 count, Clock::duration took);
  void make_long_steps(u32 count);

  const pid_t process_ = getpid();
  std::shared_ptr<World> world_;       // which work that goes on has too
  std::shared_ptr<LongCall> pending_;  // what goes on
  std::string source_;
  bool is_looked_at_ = false;  // for what looks like a mistake: before the first step
  Scene words_;                // of materials and categories; has no bodies
  bool is_busy_ = false;
  u32 quick_steps_ = 0;  // since the last one that took long, as those do that build kernels
};

using WorldClass = py::class_<SharedWorld, std::unique_ptr<SharedWorld, DeletedWhereMade>>;

/// Each adds its part of the class.
void add_questions(WorldClass& world);
void add_actions(WorldClass& world);
void add_changes(WorldClass& world);

}  // namespace lockstep::python
