// Events of the shapes and bodies of scenes, made of those of the shapes that are simulated: a surface is simulated as
// its triangles, and what rolls over one begins and ceases to touch them all (docs/reference/events.md).
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <tuple>

#include "host/scene/described_shapes.hpp"
#include "include/lockstep/readings.hpp"

namespace lockstep {

/// A side of an event; `triangle` where events are of triangles.
using EventSide = DescribedShape;

/// Of a contact of simulated shapes.
struct ContactImpact {
  u32 shape_a, shape_b;
  Impact impact;
};

/// Two shapes, bodies or triangles of a world began or ceased to touch, or came together; `a` is the trigger, if there
/// is one.
struct PairEvent {
  EventKind kind;
  u32 step, world;
  EventSide a, b;
  std::optional<Impact> impact = {};  // of EVENT_IMPACT
};

class EventGroups {
 public:
  EventGroups() = default;
  /// Of worlds that are simulated together, with the setting `event_pairs` of the first.
  explicit EventGroups(std::span<const Scene> worlds);

  /// Whether several pairs of simulated shapes can be one pair of what events are of.
  bool merges() const { return merges_; }

  /// `events` of a step and the pairs of simulated shapes that touch after it, both as the step left them. A pair
  /// begins where none of its simulated pairs touched before and one does after, and ends the other way round; it has
  /// the shapes of the first that began, or of the last that ended. `touching` is not looked at unless merges().
  std::vector<PairEvent> merge(std::span<const Event> events, std::span<const Pair> touching) const;

  /// Impacts faster than the setting `impact_speed`, of all contacts of a step.
  std::vector<PairEvent> impacts(std::span<const ContactImpact> contacts, u32 step) const;

  /// Faster ones are told, m/s.
  double impact_speed() const { return impact_speed_; }

  /// The ends of the pairs that touch and none of whose simulated pairs goes on to be known. `is_gone` says of each of
  /// `touching` whether it does not.
  std::vector<PairEvent> ends(std::span<const Pair> touching, const std::vector<bool>& is_gone) const;

 private:
  // What events know of a description, or of a triangle of one.
  struct Group {
    u32 group;  // equal where events do not tell two apart
    bool trigger;
    bool has_triangles;
  };
  struct Member {
    Group of;
    u32 world;
    EventSide side;
  };
  using Key = std::tuple<u32, u32, u32>;  // both groups, and that of the trigger or NONE

  /// What a simulated shape belongs to.
  Member member(u32 shape) const;
  Key key(u32 shape_a, u32 shape_b) const;

  DescribedShapes shapes_;
  std::vector<Group> groups_;  // of each description
  double impact_speed_ = std::numeric_limits<double>::infinity();
  bool merges_ = false;
};

}  // namespace lockstep
