// Which law of impact the materials of a scene have where they meet.
#pragma once

#include <vector>

#include "host/scene/scene.hpp"

namespace lockstep {

struct PairLaw {
  ImpactLaw law = IMPACT_NEWTON;
  double tangential_restitution = 0;
};

/// Of materials a and b at a * count + b; a scene without materials has one. A law that one of the two names is that of
/// both, tangential restitution the larger of those named; rules of the scene override both. Throws Error (input),
/// naming the place, where two materials that name different laws have no rule, and for a tangential restitution that
/// is not in -1 .. 1 or whose law has none.
std::vector<PairLaw> impact_laws_of(const Scene& scene);

}  // namespace lockstep
