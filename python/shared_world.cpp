#include "python/shared_world.hpp"

#include <algorithm>
#include <set>

#include "host/scene/read_robots.hpp"

namespace lockstep::python {

namespace {

using namespace std::chrono_literals;

constexpr auto between_signals = 50ms;

// All of the process; never destroyed, for worlds may go after it would be.
std::set<SharedWorld*>& worlds() {
  static auto& all = *new std::set<SharedWorld*>;
  return all;
}

}  // namespace

SharedWorld::SharedWorld(std::function<Scene()> read, const WorldOptions& options) {
  const auto scene = std::make_shared<const Scene>(run_long(pending_, std::move(read)));
  source_ = scene->source;
  // what of a robot's file is left out is no key that is called otherwise
  warn(source_, scene->notes, is_robot(source_) ? PyExc_UserWarning : PyExc_DeprecationWarning);
  world_ = run_long(pending_, [scene, options] { return std::make_shared<World>(*scene, options); });
  words_.materials = scene->materials;
  words_.categories = scene->categories;
  words_.particles = scene->particles;
  worlds().insert(this);
}

SharedWorld::~SharedWorld() { worlds().erase(this); }

World& SharedWorld::use() {
  if (process_ != getpid())
    throw Error(Failure::input, "world", "was made before fork() and belongs to the parent process; make one here");
  if (is_busy_ || (pending_ && pending_->is_mine()))
    throw Error(Failure::input, "world", "is being stepped; ask and act between two steps");
  if (pending_) {
    const Busy busy(is_busy_);
    LongCall::finish(pending_);
  }
  return *world_;
}

World& SharedWorld::use_ready() {
  World& world = use();
  if (!world.is_ready() && !world.bodies().empty()) ask([](World& of) { of.poses(); });
  return world;
}

void SharedWorld::note_steps(u32 count, Clock::duration took) {
  quick_steps_ = took > count * between_signals ? 0 : std::min(quick_steps_ + 1, 3u);
}

void SharedWorld::make_long_steps(u32 count) {
  const auto last = std::make_shared<Clock::duration>();
  LongCall::run(pending_, [world = world_, count, last](const std::atomic<bool>& given_up) {
    for (u32 done = 0; done < count && !given_up; ++done) {
      const Clock::time_point start = Clock::now();
      world->step(1);
      *last = Clock::now() - start;
    }
  });
  for (u32 i = 0; i < std::min(count, 3u); ++i) note_steps(1, *last);
}

void SharedWorld::step(u32 count) {
  World& world = use();
  if (count > 0 && !std::exchange(is_looked_at_, true))
    warn(source_, ask([](World& of) { return of.suspicions(); }), PyExc_UserWarning);
  const Busy busy(is_busy_);
  u32 at_once = 1;
  for (u32 done = 0; done < count;) {
    if (!world.is_ready()) quick_steps_ = 0;
    if (quick_steps_ < 3 && is_main_thread()) {
      const u32 next = std::min(3u, count - done);
      make_long_steps(next);
      done += next;
      continue;
    }
    const Clock::time_point start = Clock::now();
    const u32 next = std::min(at_once, count - done);
    {
      const Unlocked unlocked;
      world.step(next);
    }
    done += next;
    const Clock::duration took = Clock::now() - start;
    note_steps(next, took);
    if (2 * took < between_signals) at_once = std::min(2 * at_once, 1u << 20);
    if (done < count && PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
}

void SharedWorld::end_recordings() {
  for (SharedWorld* shared : worlds()) {
    try {
      if (!shared->is_busy_ && !(shared->pending_ && shared->pending_->goes_on())) shared->world_->end_recording();
    } catch (const std::exception& error) {
      PySys_FormatStderr("lockstep: %s\n", error.what());
    }
  }
}

void SharedWorld::forget_worlds() { worlds().clear(); }

}  // namespace lockstep::python
