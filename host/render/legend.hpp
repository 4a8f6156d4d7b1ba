// What is written on a picture: what its colours mean, and what it shows.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/render/picture.hpp"

namespace lockstep {

struct Legend {
  struct Entry {
    std::vector<Color> colors;
    std::string text;
  };
  struct Scale {
    double low = 0, high = 1;  // of scale_color's 0 and 1
    bool exceeded = false;     // there is more than `high`
    bool whole = false;        // whole numbers only
  };

  std::string title;           // with the unit
  std::optional<Scale> scale;  // first the scale, then the entries
  std::vector<Entry> entries;
};

/// A part of a picture: pixels [x0, x1) x [y0, y1).
struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// Draws a legend into the upper right corner. The rectangle of its scale, low values on the left; empty without one.
PixelRect draw_legend(Picture& picture, const Legend& legend);

/// Draws lines of text into the lower left corner.
void draw_caption(Picture& picture, const std::vector<std::string>& lines);

/// The least of 1, 2, 2.5, 5 times a power of ten that is not less than `value`; 1 for what is not positive.
double round_scale(double value);

}  // namespace lockstep
