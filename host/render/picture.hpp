// A picture in memory, and what is drawn on it by the processor.
#pragma once

#include <string_view>
#include <vector>

#include "host/render/colors.hpp"
#include "kernels/types.h"

namespace lockstep {

/// Rows from the top, three bytes (r g b) a pixel.
struct Picture {
  u32 width = 0, height = 0;
  std::vector<unsigned char> bytes;

  Picture() = default;
  Picture(u32 w, u32 h) : width(w), height(h), bytes(std::size_t{3} * w * h) {}

  unsigned char* at(u32 x, u32 y) { return &bytes[3 * (std::size_t{y} * width + x)]; }
  const unsigned char* at(u32 x, u32 y) const { return &bytes[3 * (std::size_t{y} * width + x)]; }

  /// Lays a colour over a pixel; nothing where there is none.
  void blend(int x, int y, const Color& color, double alpha);

  /// Pixels [x0, x1) x [y0, y1).
  void fill(int x0, int y0, int x1, int y1, const Color& color, double alpha = 1);
};

/// What every PNG file begins with.
inline constexpr std::string_view png_signature = "\x89PNG\r\n\x1a\n";

/// The bytes of a PNG file; the same picture gives the same ones.
std::vector<unsigned char> encode_png(const Picture& picture);

}  // namespace lockstep
