#include "host/scene/touching.hpp"

#include <map>
#include <tuple>

namespace lockstep {

namespace {

struct Members {
  const BodyDescription* body;  // the first body with such a shape
  bool several = false;         // another body has one too
};

// A trigger feels the solid shapes of dynamic bodies.
bool feels(const ShapeClass& a, const ShapeClass& b) { return !a.trigger || (b.dynamic && !b.trigger); }

}  // namespace

bool can_touch(const ShapeClass& a, const ShapeClass& b) {
  if (!feels(a, b) || !feels(b, a)) return false;
  return (a.category & b.mask) != 0 && (b.category & a.mask) != 0 && (a.dynamic || b.dynamic) && !(a.plane && b.plane);
}

bool shapes_can_touch(const Scene& scene) {
  std::map<ShapeClass, Members> classes;
  for (const BodyDescription& body : scene.bodies) {
    for (const ShapeDescription& shape : body.shapes) {
      const ShapeClass shape_class = {shape.category, shape.mask, shape.kind == SHAPE_PLANE, body.kind == BODY_DYNAMIC,
                                      shape.trigger};
      Members& members = classes.try_emplace(shape_class, Members{&body}).first->second;
      if (members.body != &body) members.several = true;
    }
  }
  for (const auto& [a, in_a] : classes) {
    for (const auto& [b, in_b] : classes) {
      const bool two_bodies = in_a.several || in_b.several || in_a.body != in_b.body;
      if (two_bodies && can_touch(a, b)) return true;
    }
  }
  return false;
}

}  // namespace lockstep
