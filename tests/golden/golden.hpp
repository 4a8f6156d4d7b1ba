// Golden hashes: what the state of a scene must be after a number of steps, whatever computed it.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "host/scene/read.hpp"
#include "host/simulation.hpp"

namespace lockstep {

struct GoldenCase {
  std::string scene, precision;
  u32 steps = 0;
  std::string state_hash, pose_hash;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(GoldenCase, scene, precision, steps, state_hash, pose_hash)

inline std::string hash_digits(u32 high, u32 low) {
  char digits[17];
  std::snprintf(digits, sizeof(digits), "%08x%08x", high, low);
  return digits;
}

/// Steps a scene of one world on the backend that `make` makes of its initial state, and fills in the hashes.
template <class real, class Make>
void run_case(GoldenCase& golden, Make&& make) {
  const InitialState<real> state = compile<real>(read_scene(golden.scene));
  Simulation<real> simulation(make(state), state.params);
  for (u32 step = 0; step < golden.steps; ++step) simulation.step();
  const WorldHash hash = simulation.world_hashes().front();
  golden.state_hash = hash_digits(hash.state_high, hash.state_low);
  golden.pose_hash = hash_digits(hash.pose_high, hash.pose_low);
}

}  // namespace lockstep
