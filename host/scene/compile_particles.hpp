// Bodies as particles in the buffers.
#pragma once

#include <span>

#include "host/scene/compile.hpp"

namespace lockstep {

/// Whether bodies push each other by particles with springs and dampers.
inline bool is_penalty(const Scene& scene) {
  return scene.particles && scene.particles->model == ParticleModel::penalty;
}

/// Fills the particles' constant buffers and sizes of a batch whose bodies stand in `state` already. Throws Error
/// (input) where particles do not fit a shape, where a scene asks for what they cannot do, and where the time step is
/// too long for them.
template <class real>
void compile_particles(std::span<const Scene> worlds, InitialState<real>& state);

/// The scene with spheres, its particles, in the place of each bounded shape; `keep`: behind the shape itself, which is
/// a trigger then. Throws Error (input) where particles do not fit a shape.
Scene with_particles_as_shapes(const Scene& scene, bool keep);

/// Of each shape of each body, in order, how many stand in its place there, none of them kept.
std::vector<u32> particle_shape_counts(const Scene& scene);

}  // namespace lockstep
