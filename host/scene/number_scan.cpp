#include "host/scene/number_scan.hpp"

#include <assimp/fast_atof.h>

#include <string>

namespace lockstep {

namespace {

// What it throws for more digits than it takes.
struct TooLong {
  template <class... What>
  explicit TooLong(What&&...) {}
};

}  // namespace

std::optional<float> float_in(std::string_view word) {
  const auto number = number_in<double>(word);
  if (!number) return std::nullopt;
  try {
    float rounded = 0;
    Assimp::fast_atoreal_move<float, TooLong>(std::string(word).c_str(), rounded, false);
    return rounded;
  } catch (const TooLong&) {
    return static_cast<float>(*number);
  }
}

}  // namespace lockstep
