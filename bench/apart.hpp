// Runs work in a process of its own, so that its memory is its own and what one engine leaves behind does not slow the
// next.
#pragma once

#include <functional>
#include <vector>

namespace lockstep::bench {

struct Apart {
  std::vector<std::vector<double>> values;  // what the work returned
  double peak_memory = 0;                   // bytes: the most that the process held at a time (resident set)
};

/// Throws Error (device) where the work failed; it has then told why on standard error. The caller must not have
/// started threads.
Apart run_apart(const std::function<std::vector<std::vector<double>>()>& work);

}  // namespace lockstep::bench
