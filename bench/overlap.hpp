// How deep the spheres of a scene overlap, from positions alone: the same measure for every engine.
#pragma once

#include <vector>

#include "host/scene/scene.hpp"

namespace lockstep::bench {

struct Overlap {
  u32 pairs = 0;                 // that overlap at all
  double deepest = 0, mean = 0;  // m; the mean over those pairs
};

/// `positions`: centres of mass of the scene's bodies, m. Spheres centred in their bodies against each other and
/// against planes of bodies that have not moved.
Overlap measure_overlap(const Scene& scene, const std::vector<Vector3>& positions);

}  // namespace lockstep::bench
