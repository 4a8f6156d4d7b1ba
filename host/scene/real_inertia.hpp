// Inertia that files give and no body has: placeholders of 0, few digits, frames that were mixed up.
#pragma once

#include "host/scene/mass_properties.hpp"

namespace lockstep {

/// Whether its principal moments are > 0 and keep the triangle inequality to 1 in 1000, for files have few digits.
bool is_real(const MassProperties& solid);

/// The nearest (by the Frobenius norm) whose principal moments keep the triangle inequality, none of them below
/// 1 in 1000 of the largest, nor below 1e-4 m c^2: c is how far the centre of mass is from the origin, or 0.1 m where
/// it is there.
MassProperties nearest_real(MassProperties solid);

}  // namespace lockstep
