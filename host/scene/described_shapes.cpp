#include "host/scene/described_shapes.hpp"

#include <algorithm>

#include "host/scene/compile_particles.hpp"
#include "host/scene/surface.hpp"

namespace lockstep {

DescribedShapes::DescribedShapes(std::span<const Scene> worlds) {
  u32 first = 0;
  for (u32 world = 0; world < worlds.size(); ++world) {
    const Scene& scene = worlds[world];
    first_of_worlds_.push_back(first);
    std::vector<u32> particles;
    const bool as_particles = scene.particles && !is_penalty(scene);
    if (as_particles) particles = particle_shape_counts(scene);
    const std::size_t before = rows_.size();
    for (u32 body = 0; body < scene.bodies.size(); ++body) {
      const std::vector<ShapeDescription>& shapes = scene.bodies[body].shapes;
      for (u32 shape = 0; shape < shapes.size(); ++shape) {
        const u32 count =
            as_particles ? particles[rows_.size() - before] : static_cast<u32>(simulated_shapes(shapes[shape]));
        rows_.push_back({first, count, world, body, shape, shapes[shape].kind == SHAPE_FACET});
        first += count;
      }
    }
  }
}

u32 DescribedShapes::description_of(u32 simulated) const {
  return static_cast<u32>(std::ranges::upper_bound(rows_, simulated, {}, &Row::first) - rows_.begin()) - 1;
}

DescribedShape DescribedShapes::operator[](u32 simulated) const {
  const Row& row = rows_[description_of(simulated)];
  return {row.body, row.shape, row.is_surface ? simulated - row.first : NONE};
}

}  // namespace lockstep
