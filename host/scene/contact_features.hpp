// Which features the contacts of a scene have by its settings.
#pragma once

#include "host/features.hpp"
#include "host/scene/settings.hpp"

namespace lockstep {

/// Whether the normals of a pair are found together: not where a tolerance ends the sweeps.
bool couples_normals(const Settings& settings, Features features);

/// Whether overlap is taken back by poses: of hard contacts on whole bodies, in colours. Reduced coordinates keep poses
/// of their own, and a body on a pivot has but one place.
bool separates_contacts(const Settings& settings, Features features);

}  // namespace lockstep
