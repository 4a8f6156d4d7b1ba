#include "host/app/event_log.hpp"

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "host/error.hpp"

namespace lockstep::app {

namespace {

constexpr const char* kinds[EVENT_KINDS] = {"contact_begin", "contact_end", "trigger_enter", "trigger_leave", "impact"};

}  // namespace

EventLog::EventLog(const std::string& path, const Scene& scene) : path_(path), scene_(scene) {
  if (path.empty()) return;
  u32 shapes = 0;
  for (const BodyDescription& body : scene.bodies) {
    first_shapes_.push_back(shapes);
    shapes += static_cast<u32>(body.shapes.size());
  }
  errno = 0;
  file_.open(path);
  if (!file_) throw Error(Failure::input, path, std::string("the events cannot be written: ") + std::strerror(errno));
}

void EventLog::add(const PairEvent& event) {
  ++counts_[event.kind];
  if (!file_.is_open()) return;
  nlohmann::ordered_json json = {{"step", event.step}, {"event", kinds[event.kind]}};
  const auto put = [&](const char* side, const EventSide& of) {
    json[std::string("body_") + side] = of.body;
    json[std::string("shape_") + side] = first_shapes_[of.body] + of.shape;
    if (of.triangle != NONE) json[std::string("triangle_") + side] = of.triangle;
  };
  put("a", event.a);
  put("b", event.b);
  const std::string &name_a = scene_.bodies[event.a.body].name, &name_b = scene_.bodies[event.b.body].name;
  if (!name_a.empty()) json["name_a"] = name_a;
  if (!name_b.empty()) json["name_b"] = name_b;
  if (event.impact) {
    json["speed"] = event.impact->speed;
    json["impulse"] = event.impact->impulse;
    json["point"] = event.impact->point;
    json["normal"] = event.impact->normal;
  }
  errno = 0;
  if (!(file_ << json.dump() << '\n' << std::flush))
    throw Error(Failure::device, path_,
                std::string("the events cannot be written to their end: ") + std::strerror(errno));
}

}  // namespace lockstep::app
