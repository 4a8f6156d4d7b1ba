#include "host/scene/event_groups.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace lockstep {

EventGroups::EventGroups(std::span<const Scene> worlds) : shapes_(worlds) {
  const EventPairs pairs = worlds.empty() ? EventPairs::shapes : worlds[0].settings.event_pairs;
  const bool of_triangles = pairs == EventPairs::triangles;
  if (!worlds.empty() && worlds[0].settings.impact_speed) impact_speed_ = *worlds[0].settings.impact_speed;
  for (const Scene& scene : worlds) {
    for (const BodyDescription& body : scene.bodies) {
      const u32 first_of_body = static_cast<u32>(groups_.size());
      for (const ShapeDescription& shape : body.shapes) {
        const u32 description = static_cast<u32>(groups_.size());
        const u32 first = shapes_.first_of(pairs == EventPairs::bodies ? first_of_body : description);
        groups_.push_back({first, shape.trigger, of_triangles && shape.kind == SHAPE_FACET});
      }
    }
  }
  for (u32 description = 0; description < groups_.size(); ++description)
    merges_ = merges_ || groups_[description].group != shapes_.first_of(description) ||
              (shapes_.count_of(description) > 1 && !groups_[description].has_triangles);
}

EventGroups::Member EventGroups::member(u32 shape) const {
  const u32 description = shapes_.description_of(shape);
  Member member = {groups_[description], shapes_.world_of(description), shapes_[shape]};
  if (member.of.has_triangles)
    member.of.group = shape;
  else
    member.side.triangle = NONE;
  return member;
}

// Planes come last in pairs, whatever their index: the order of the two sides says nothing.
EventGroups::Key EventGroups::key(u32 shape_a, u32 shape_b) const {
  const Member a = member(shape_a), b = member(shape_b);
  const u32 trigger = a.of.trigger ? a.of.group : b.of.trigger ? b.of.group : NONE;
  return {std::min(a.of.group, b.of.group), std::max(a.of.group, b.of.group), trigger};
}

std::vector<PairEvent> EventGroups::merge(std::span<const Event> events, std::span<const Pair> touching) const {
  struct Change {
    u32 begins = 0, ends = 0, after = 0;
    std::size_t last = 0;  // index of the last end
    bool told = false;
  };
  const auto begins = [](const Event& event) {
    return event.kind == EVENT_CONTACT_BEGIN || event.kind == EVENT_TRIGGER_ENTER;
  };
  const auto index = [&](u32 world, u32 shape) { return shapes_.first_of_world(world) + shape; };
  const auto key_of = [&](const Event& event) {
    return key(index(event.world, event.shape_a), index(event.world, event.shape_b));
  };
  std::map<Key, Change> changes;
  for (std::size_t i = 0; merges_ && i < events.size(); ++i) {
    Change& change = changes[key_of(events[i])];
    ++(begins(events[i]) ? change.begins : change.ends);
    if (!begins(events[i])) change.last = i;
  }
  for (const Pair& pair : merges_ ? touching : std::span<const Pair>()) {
    const auto found = changes.find(key(pair.shape_a, pair.shape_b));
    if (found != changes.end()) ++found->second.after;
  }
  std::vector<PairEvent> merged;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const Event& event = events[i];
    if (merges_) {
      Change& change = changes.at(key_of(event));
      const bool before = change.after + change.ends > change.begins;
      const bool is_it =
          begins(event) ? !before && change.after > 0 && !change.told : before && change.after == 0 && change.last == i;
      if (!is_it) continue;
      change.told = true;
    }
    merged.push_back({static_cast<EventKind>(event.kind), event.step, event.world,
                      member(index(event.world, event.shape_a)).side, member(index(event.world, event.shape_b)).side});
  }
  return merged;
}

std::vector<PairEvent> EventGroups::impacts(std::span<const ContactImpact> contacts, u32 step) const {
  std::map<Key, PairEvent> impacts;
  for (const ContactImpact& contact : contacts) {
    const Member first = member(contact.shape_a), second = member(contact.shape_b);
    EventSide a = first.side, b = second.side;
    Impact impact = contact.impact;
    const auto [found, is_new] = impacts.try_emplace(key(contact.shape_a, contact.shape_b),
                                                     PairEvent{EVENT_IMPACT, step, first.world, a, b, Impact{}});
    PairEvent& event = found->second;
    if (event.a.body != a.body) {  // a plane comes last, whosever it is
      std::swap(a, b);
      impact.normal = exact::scale(-1, impact.normal);
      impact.impulse = exact::scale(-1, impact.impulse);
    }
    const Vector3 sum = exact::add(event.impact->impulse, impact.impulse);
    if (impact.speed > event.impact->speed) event = {EVENT_IMPACT, step, first.world, a, b, impact};
    event.impact->impulse = sum;
  }
  std::vector<PairEvent> all;
  for (const auto& [key, event] : impacts)
    if (event.impact->speed > impact_speed_) all.push_back(event);
  return all;
}

std::vector<PairEvent> EventGroups::ends(std::span<const Pair> touching, const std::vector<bool>& is_gone) const {
  std::set<Key> known;
  for (std::size_t i = 0; i < touching.size(); ++i)
    if (!is_gone[i]) known.insert(key(touching[i].shape_a, touching[i].shape_b));
  std::map<Key, PairEvent> ends;
  for (const Pair& pair : touching) {
    if (known.contains(key(pair.shape_a, pair.shape_b))) continue;
    Member a = member(pair.shape_a), b = member(pair.shape_b);
    if (b.of.trigger) std::swap(a, b);
    const EventKind kind = a.of.trigger ? EVENT_TRIGGER_LEAVE : EVENT_CONTACT_END;
    ends.insert({key(pair.shape_a, pair.shape_b), {kind, 0, a.world, a.side, b.side}});
  }
  std::vector<PairEvent> all;
  for (const auto& [key, event] : ends) all.push_back(event);
  return all;
}

}  // namespace lockstep
