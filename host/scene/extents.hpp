// A box along the axes of a frame.
#pragma once

#include <algorithm>

#include "host/scene/exact_math.hpp"

namespace lockstep {

/// Of nothing until something is united with it.
struct Extents {
  Vector3 low = {1e300, 1e300, 1e300}, high = {-1e300, -1e300, -1e300};

  void unite(const Extents& other) {
    for (unsigned k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], other.low[k]);
      high[k] = std::max(high[k], other.high[k]);
    }
  }
  bool meets(const Extents& other) const {
    for (unsigned k = 0; k < 3; ++k)
      if (other.low[k] > high[k] || low[k] > other.high[k]) return false;
    return true;
  }
};

}  // namespace lockstep
