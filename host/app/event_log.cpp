#include "host/app/event_log.hpp"

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "host/error.hpp"

namespace lockstep::app {

namespace {

constexpr const char* kinds[EVENT_KINDS] = {"contact_begin", "contact_end", "trigger_enter", "trigger_leave"};

}  // namespace

EventLog::EventLog(const std::string& path, const Scene& scene) : scene_(scene) {
  if (path.empty()) return;
  errno = 0;
  file_.open(path);
  if (!file_) throw Error(Failure::input, path, std::string("the events cannot be written: ") + std::strerror(errno));
}

void EventLog::add(const Event& event) {
  ++counts_[event.kind];
  if (!file_.is_open()) return;
  nlohmann::ordered_json json = {{"step", event.step},       {"event", kinds[event.kind]}, {"body_a", event.body_a},
                                 {"shape_a", event.shape_a}, {"body_b", event.body_b},     {"shape_b", event.shape_b}};
  const std::string &name_a = scene_.bodies[event.body_a].name, &name_b = scene_.bodies[event.body_b].name;
  if (!name_a.empty()) json["name_a"] = name_a;
  if (!name_b.empty()) json["name_b"] = name_b;
  file_ << json.dump() << '\n' << std::flush;
}

}  // namespace lockstep::app
