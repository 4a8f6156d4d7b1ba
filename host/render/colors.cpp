#include "host/render/colors.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace lockstep {

namespace {

constexpr Color hex(u32 rgb) {
  return {static_cast<float>(rgb >> 16 & 0xff) / 255, static_cast<float>(rgb >> 8 & 0xff) / 255,
          static_cast<float>(rgb & 0xff) / 255};
}

constexpr Color bodies[] = {hex(0xd9703f), hex(0x3f7fa6), hex(0xe3b34d), hex(0x5a9e7c),
                            hex(0xc9584f), hex(0x7fb2cf), hex(0xede0c8), hex(0x4d5f7a)};

// Nine values of matplotlib's map "viridis" (S. van der Walt, N. Smith; CC0), even steps apart.
constexpr Color viridis[] = {hex(0x440154), hex(0x472d7b), hex(0x3b528b), hex(0x2c728e), hex(0x21918c),
                             hex(0x28ae80), hex(0x5ec962), hex(0xaddc30), hex(0xfde725)};

}  // namespace

std::span<const Color> body_colors() { return bodies; }

Color body_color(u32 id) {
  // each run of eight ids has all eight colours, in an order of its own, so that a lattice of bodies shows no stripes:
  // the finalizer of MurmurHash3 says where it begins, and in what steps it goes around
  constexpr u32 count = static_cast<u32>(std::size(bodies));
  u32 h = id / count + 0x9e3779b9u;
  h = (h ^ (h >> 16)) * 0x85ebca6bu;
  h = (h ^ (h >> 13)) * 0xc2b2ae35u;
  h ^= h >> 16;
  const u32 stride = 2 * (h >> 8) + 1;
  return bodies[(h + stride * id) % count];
}

Color scale_color(double share) {
  constexpr std::size_t steps = std::size(viridis) - 1;
  const double at = std::isnan(share) ? 0 : std::clamp(share, 0.0, 1.0) * steps;
  const std::size_t below = std::min(static_cast<std::size_t>(at), steps - 1);
  const float fraction = static_cast<float>(at - static_cast<double>(below));
  Color color;
  for (std::size_t i = 0; i < 3; ++i)
    color[i] = viridis[below][i] + fraction * (viridis[below + 1][i] - viridis[below][i]);
  return color;
}

}  // namespace lockstep
