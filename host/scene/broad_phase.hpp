// Which search of the broad phase suits a scene. The choice changes speed only: all find the same pairs.
#pragma once

#include <cstddef>

#include "host/buffers.hpp"
#include "host/scene/settings.hpp"

namespace lockstep {

/// The one of the settings, or the one that suits a batch of worlds whose bodies and shapes are in the buffers, by
/// their number, sizes and first speeds.
template <class real>
Feature broad_phase_of(const Settings& settings, std::size_t worlds, const Buffers<real>& buffers);

}  // namespace lockstep
