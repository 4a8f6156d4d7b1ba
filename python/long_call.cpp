#include "python/long_call.hpp"

#include <cxxabi.h>
#include <unistd.h>

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

namespace lockstep::python {

namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto between_looks = 20ms;

// Threads in work without Python's lock, and of them those that have it again for a load.
std::atomic<int> in_progress = 0, in_loads = 0;
std::atomic<bool> ending = false;

[[noreturn]] void wait_for_the_end() {
  for (;;) pause();
}

struct Counted {
  explicit Counted(std::atomic<int>& threads) : threads_(threads) { ++threads_; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;
  ~Counted() { --threads_; }
  std::atomic<int>& threads_;
};

void expect_not_ending() {
  if (!ending || is_main_thread()) return;
  PyErr_SetNone(PyExc_SystemExit);
  throw py::error_already_set();
}

// A load that sleeps or waits for something may never end.
void wait_for_work() {
  ending = true;
  const Clock::time_point begin = Clock::now();
  const auto waits = [&] {
    const int loads = in_loads;
    return in_progress > loads || (loads > 0 && Clock::now() - begin < 2s);
  };
  while (waits()) {
    const py::gil_scoped_release released;
    std::this_thread::sleep_for(1ms);
  }
}

}  // namespace

Unlocked::Unlocked() {
  expect_not_ending();
  ++in_progress;
  state_ = PyEval_SaveThread();
}

Unlocked::~Unlocked() {
  try {
    PyEval_RestoreThread(state_);
  } catch (abi::__forced_unwind&) {  // Python ends the threads that come too late, through frames that must not throw
    wait_for_the_end();
  }
  --in_progress;
}

void with_lock(const std::function<void()>& call) {
  const Counted counted(in_loads);
  try {
    const py::gil_scoped_acquire lock;
    try {
      call();
    } catch (abi::__forced_unwind&) {
      wait_for_the_end();
    }
  } catch (abi::__forced_unwind&) {
    wait_for_the_end();
  }
}

bool is_main_thread() {
  const py::object main = py::module_::import("threading").attr("main_thread")().attr("ident");
  return !main.is_none() && main.cast<unsigned long>() == PyThread_get_thread_ident();
}

struct LongCall::State {
  std::atomic<bool> given_up = false;
  std::thread::id thread;
  std::mutex mutex;
  std::condition_variable changed;
  bool ended = false;
  std::exception_ptr failure;

  void work(Work work) {
    try {
      work(given_up);
    } catch (...) {
      failure = std::current_exception();
    }
    work = nullptr;  // and what it has, before it is said to be done
    const std::lock_guard lock(mutex);
    ended = true;
    changed.notify_all();
  }

  bool has_ended_within(std::chrono::milliseconds time) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, time, [this] { return ended; });
  }
};

bool LongCall::goes_on() const { return !state_->has_ended_within(0ms); }

bool LongCall::is_mine() const { return state_->thread == std::this_thread::get_id(); }

void LongCall::run(std::shared_ptr<LongCall>& pending, Work work) {
  if (!is_main_thread()) {
    const Unlocked unlocked;
    work(ending);
    return;
  }
  auto call = std::make_shared<LongCall>();
  call->state_ = std::make_shared<State>();
  ++in_progress;
  std::thread thread([state = call->state_, work = std::move(work)]() mutable {
    state->work(std::move(work));
    state.reset();
    --in_progress;
  });
  call->state_->thread = thread.get_id();
  thread.detach();
  pending = std::move(call);
  finish(pending);
}

void LongCall::finish(std::shared_ptr<LongCall>& pending) {
  if (!pending) return;
  const std::shared_ptr<State> state = pending->state_;
  for (;;) {
    bool ended = false;
    {
      const Unlocked unlocked;
      ended = state->has_ended_within(between_looks);
    }
    if (ended) break;
    if (PyErr_CheckSignals() != 0) {
      state->given_up = true;
      throw py::error_already_set();
    }
  }
  pending.reset();
  if (state->failure) std::rethrow_exception(std::exchange(state->failure, nullptr));
}

void watch_process(std::function<void()> last, std::function<void()> forked) {
  py::module_::import("atexit").attr("register")(py::cpp_function([last = std::move(last)] {
    wait_for_work();
    last();
  }));
  py::module_::import("os").attr("register_at_fork")(py::arg("after_in_child") =
                                                         py::cpp_function([forked = std::move(forked)] {
                                                           in_progress = in_loads = 0;
                                                           forked();
                                                         }));
}

}  // namespace lockstep::python
