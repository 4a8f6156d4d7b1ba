// Colours: of bodies, and of numbers on a scale.
#pragma once

#include <array>
#include <span>

#include "kernels/types.h"

namespace lockstep {

/// Red, green, blue as they are stored in pictures (sRGB), 0 .. 1.
using Color = std::array<float, 3>;

/// What immovable bodies have whatever the others show.
inline constexpr Color still_color = {0.60f, 0.62f, 0.64f};

/// One of a few colours that go together, by the id of a body: those of the ids 8 k to 8 k + 7 all differ.
Color body_color(u32 id);

/// All of these.
std::span<const Color> body_colors();

/// From dark blue over green to yellow, of even steps to the eye; 0 .. 1, clamped. NaN has no place on it.
Color scale_color(double share);

}  // namespace lockstep
