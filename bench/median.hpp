#pragma once

#include <algorithm>
#include <vector>

namespace lockstep::bench {

/// The middle one, of an even number the upper of the two; there has to be one.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace lockstep::bench
