// Whether contacts are possible at all in a scene.
#pragma once

#include "host/scene/scene.hpp"

namespace lockstep {

/// What decides whether shapes can touch, but for where they are. Scenes have few such classes, however many shapes.
struct ShapeClass {
  u32 category, mask;
  bool plane, dynamic, trigger;

  auto operator<=>(const ShapeClass&) const = default;
};

/// Whether shapes of different bodies could touch: one of the bodies is dynamic, the filters agree, at least one of
/// them is no plane, and a trigger feels the solid shapes of dynamic bodies alone.
bool can_touch(const ShapeClass& a, const ShapeClass& b);

/// Whether any two shapes of different bodies could.
bool shapes_can_touch(const Scene& scene);

}  // namespace lockstep
