// From scenes to buffers: everything that becomes simulated state is computed here, in exact arithmetic
// (contract rule 6).
#pragma once

#include <span>

#include "host/buffers.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// The oracle that solves the constraint system of each sub-step in the place of the stages, if one does.
struct OracleChoice {
  std::string name = {};  // of a Solver; empty: the stages solve
  u32 directions = 4;     // sides of its friction pyramids, if it has any

  explicit operator bool() const { return !name.empty(); }
  bool operator==(const OracleChoice&) const = default;
};

/// What a simulation starts from.
template <class real>
struct InitialState {
  Buffers<real> buffers;  // constant and persistent buffers filled, the others sized
  Sizes sizes;
  Features features = 0;
  StepParams<real> params = {};
  OracleChoice oracle = {};
};

/// Compiles one world, or a batch of them: the bodies of world w follow those of world w - 1. The settings (dt,
/// integrator, iterations ...) of a batch are those of the first scene. Throws Error (input) where settings and scene
/// do not go together.
template <class real>
InitialState<real> compile(std::span<const Scene> worlds);

template <class real>
InitialState<real> compile(const Scene& scene) {
  return compile<real>(std::span<const Scene>(&scene, 1));
}

/// What of bodies that are particles is shown: the shapes that they stand for, or the particles, or the particles
/// within translucent shapes.
enum class Shown { shapes, particles, both };

/// The constants of bodies and shapes alone, in the order of compile(): those too that are not simulated because no
/// shape of the scene can touch another. For pictures.
template <class real>
Buffers<real> compile_shapes(const Scene& scene, Shown shown = Shown::shapes);

/// First guesses for the lists of so many shapes; a step that needs more asks for it and is redone. A sphere in a dense
/// pile has about 6 contacts that it owns, and pairs are little more than contacts.
void set_first_capacities(Sizes& sizes, Features features);

}  // namespace lockstep
