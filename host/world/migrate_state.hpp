// The state of a scene carried over to one with other bodies.
#pragma once

#include <array>
#include <set>
#include <span>
#include <vector>

#include "host/scene/compile.hpp"

namespace lockstep {

/// What has become of a scene.
struct IndexMap {
  /// Which body, joint and coupling of the new scene each of the old one has become; NONE: it is gone.
  std::vector<u32> bodies, joints, couplings;
  /// Of the old scene: who stays and is described otherwise in the new one.
  std::set<u32> changed_bodies, changed_joints;
  /// Pairs of materials that meet otherwise; NONE is any.
  std::vector<std::array<u32, 2>> changed_materials;
};

/// Puts what lives on of a state into another: poses and velocities of the bodies that are in both, bit for bit, the
/// impulses of their contacts and joints, who touches, the step. `old` holds the constant buffers of the scene that was
/// and `persistent` its state. Who stays keeps its order. A body that has changed keeps of its shapes, in their order,
/// what is of the same kind; what a change concerns wakes.
template <class real>
void migrate_state(const InitialState<real>& old, const Buffers<real>& persistent, const IndexMap& index_map,
                   InitialState<real>& state);

/// Which pairs of shapes that touched cannot go on to: a shape of theirs is gone or another one, or bodies and filters
/// in the new scene leave nothing of it.
template <class real>
std::vector<bool> pairs_gone(const InitialState<real>& old, std::span<const Pair> touching, const IndexMap& index_map,
                             const InitialState<real>& current);

}  // namespace lockstep
