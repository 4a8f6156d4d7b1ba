// The file that --events names: one line of JSON an event, written as the run goes on (docs/reference/events.md).
#pragma once

#include <array>
#include <cstdint>
#include <fstream>
#include <string>

#include "host/scene/event_groups.hpp"

namespace lockstep::app {

class EventLog {
 public:
  /// Throws Error (input) where `path` cannot be written. An empty path: events are only counted.
  EventLog(const std::string& path, const Scene& scene);

  /// Throws Error (device) where the disk does not take it.
  void add(const PairEvent& event);

  /// By EventKind.
  const std::array<std::uint64_t, EVENT_KINDS>& counts() const { return counts_; }

 private:
  const std::string path_;
  const Scene& scene_;
  std::vector<u32> first_shapes_;  // of each body, of all shapes of the scene
  std::ofstream file_;
  std::array<std::uint64_t, EVENT_KINDS> counts_ = {};
};

}  // namespace lockstep::app
