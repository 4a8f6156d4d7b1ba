#include "host/scene/event_groups.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "host/scene/surface.hpp"

namespace lockstep {

EventGroups::EventGroups(std::span<const Scene> worlds) {
  const EventPairs pairs = worlds.empty() ? EventPairs::shapes : worlds[0].settings.event_pairs;
  const bool of_triangles = pairs == EventPairs::triangles;
  u32 first = 0;
  for (u32 world = 0; world < worlds.size(); ++world) {
    first_shapes_.push_back(first);
    for (u32 body = 0; body < worlds[world].bodies.size(); ++body) {
      const std::vector<ShapeDescription>& shapes = worlds[world].bodies[body].shapes;
      const u32 first_of_body = first;
      for (u32 shape = 0; shape < shapes.size(); ++shape) {
        const bool has_triangles = of_triangles && shapes[shape].kind == SHAPE_FACET;
        const u32 group = pairs == EventPairs::bodies ? first_of_body : first;
        members_.push_back({first, group, world, shapes[shape].trigger, {body, shape, has_triangles ? 0 : NONE}});
        const u32 count = static_cast<u32>(simulated_shapes(shapes[shape]));
        merges_ = merges_ || (!of_triangles && (count > 1 || group != first));
        first += count;
      }
    }
  }
}

EventGroups::Member EventGroups::member(u32 shape) const {
  Member found = *std::prev(std::ranges::upper_bound(members_, shape, {}, &Member::first));
  if (found.side.triangle == NONE) return found;
  found.side.triangle = shape - found.first;
  found.group = shape;
  return found;
}

// Planes come last in pairs, whatever their index: the order of the two sides says nothing.
EventGroups::Key EventGroups::key(u32 shape_a, u32 shape_b) const {
  const Member a = member(shape_a), b = member(shape_b);
  const u32 trigger = a.trigger ? a.group : b.trigger ? b.group : NONE;
  return {std::min(a.group, b.group), std::max(a.group, b.group), trigger};
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
  const auto index = [&](u32 world, u32 shape) { return first_shapes_[world] + shape; };
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

std::vector<PairEvent> EventGroups::ends(std::span<const Pair> touching, const std::vector<bool>& is_gone) const {
  std::set<Key> known;
  for (std::size_t i = 0; i < touching.size(); ++i)
    if (!is_gone[i]) known.insert(key(touching[i].shape_a, touching[i].shape_b));
  std::map<Key, PairEvent> ends;
  for (const Pair& pair : touching) {
    if (known.contains(key(pair.shape_a, pair.shape_b))) continue;
    Member a = member(pair.shape_a), b = member(pair.shape_b);
    if (b.trigger) std::swap(a, b);
    const EventKind kind = a.trigger ? EVENT_TRIGGER_LEAVE : EVENT_CONTACT_END;
    ends.insert({key(pair.shape_a, pair.shape_b), {kind, 0, a.world, a.side, b.side}});
  }
  std::vector<PairEvent> all;
  for (const auto& [key, event] : ends) all.push_back(event);
  return all;
}

}  // namespace lockstep
