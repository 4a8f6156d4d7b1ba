// Which law of impact the materials of a scene have where they meet.
#pragma once

#include <vector>

#include "host/scene/scene.hpp"

namespace lockstep {

struct PairLaw {
  ImpactLaw law = IMPACT_NEWTON;
  double tangential_restitution = 0;
};

/// Of materials a and b at a * count + b; a scene without materials has one. Of two laws the later in the order of
/// ImpactLaw holds, which is Newton's where none is named, of tangential restitutions the larger; rules of the scene
/// override both. Throws Error (input), naming the location, for a tangential restitution that is not in -1 .. 1 or
/// whose law has none.
std::vector<PairLaw> impact_laws_of(const Scene& scene);

}  // namespace lockstep
