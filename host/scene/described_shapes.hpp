// Shapes that are simulated, as the descriptions of their bodies have them: a surface is simulated as its triangles,
// and bodies may be as their particles.
#pragma once

#include <span>
#include <vector>

#include "host/scene/scene.hpp"

namespace lockstep {

/// `shape` is an index into BodyDescription::shapes.
struct DescribedShape {
  u32 body, shape;
  u32 triangle = NONE;  // of a surface
  bool operator==(const DescribedShape&) const = default;
};

class DescribedShapes {
 public:
  DescribedShapes() = default;
  /// Of worlds that are simulated together, in the order of compile().
  explicit DescribedShapes(std::span<const Scene> worlds);

  DescribedShape operator[](u32 simulated) const;

  /// Which description it is of: those of all worlds count from 0.
  u32 description_of(u32 simulated) const;
  /// The first shape that is simulated for a description, how many are, and the first one of a world.
  u32 first_of(u32 description) const { return rows_[description].first; }
  u32 count_of(u32 description) const { return rows_[description].count; }
  u32 first_of_world(u32 world) const { return first_of_worlds_[world]; }
  u32 world_of(u32 description) const { return rows_[description].world; }

 private:
  struct Row {
    u32 first, count, world, body, shape;
    bool is_surface;
  };
  std::vector<Row> rows_;
  std::vector<u32> first_of_worlds_;
};

}  // namespace lockstep
