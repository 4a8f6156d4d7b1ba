// Masses and moments of MJCF bodies.
#pragma once

#include <optional>

#include "host/scene/mass_properties.hpp"
#include "host/scene/mjcf_element.hpp"

namespace lockstep {

/// A body has the compiler's least mass and principal moments at least; nothing where that is no mass.
std::optional<MassProperties> bounded(MassProperties solid, const MjcfCompiler& compiler);

/// Of an <inertial>, in the frame of its body; nothing where it has no mass.
std::optional<MassProperties> read_mjcf_inertial(const XmlNode& node, const MjcfCompiler& compiler);

}  // namespace lockstep
