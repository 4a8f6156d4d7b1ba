// Bodies that start below a surface of triangles, which has one side: nothing pushes them back, and they fall for ever.
#pragma once

#include <vector>

#include "host/scene/scene.hpp"

namespace lockstep {

struct BelowGround {
  u32 body, ground;  // indices into Scene::bodies
  double depth;      // m, of the centre of mass, against gravity
};

/// Dynamic bodies over whose centres of mass the nearest triangle of a static body, against gravity, is seen from its
/// back, and that have none to fall on. Nobody in a scene with a static plane, which may carry what is below.
std::vector<BelowGround> bodies_below_ground(const Scene& scene);

}  // namespace lockstep
