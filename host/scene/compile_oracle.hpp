// Which scenes an oracle takes.
#pragma once

#include <span>

#include "host/scene/scene.hpp"

namespace lockstep {

/// Throws Error (input) for what the oracle of the settings cannot step, which is of the first scene; nothing without
/// one. `doubles`: whether numbers are in double.
void expect_oracle_takes(std::span<const Scene> worlds, bool doubles);

}  // namespace lockstep
