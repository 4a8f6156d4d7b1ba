// Scenes in which something falls asleep, and what runs them.
#pragma once

#include <string>

#include "host/backends/reference_backend.hpp"
#include "host/report/report.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::test {

inline std::string box(double x, double z, const std::string& more = "") {
  return R"({"mass": 1, "position": [)" + std::to_string(x) + ", 0, " + std::to_string(z) + "]" + more +
         R"(, "shapes": [{"type": "box", "size": [1, 1, 1]}]})";
}

inline std::string ball(double x, double z, const std::string& more = "") {
  return R"({"mass": 5, "position": [)" + std::to_string(x) + ", 0, " + std::to_string(z) + "]" + more +
         R"(, "shapes": [{"type": "sphere", "radius": 0.5}]})";
}

inline std::string column(double x, int boxes) {
  std::string bodies;
  for (int i = 0; i < boxes; ++i) bodies += (i > 0 ? ", " : "") + box(x, 0.5 + i);
  return bodies;
}

/// Two columns of two boxes, which every solver brings to rest; a ball hits one.
inline const std::string two_columns_and_a_ball =
    column(0, 2) + ", " + column(6, 2) + ", " + ball(-8, 0.5, R"(, "velocity": [6, 0, 0])");

/// On a plane, in steps of 1/64 s, which is a number of every precision; bodies sleep after half a second.
inline Scene scene_of(const std::string& bodies, const std::string& settings = R"("sleeping": {"after": 0.5})",
                      const std::string& more = "") {
  return parse_scene(R"({"settings": {"dt": 0.015625, )" + settings +
                         R"(}, "materials": [{"name": "wood", "friction": 0.5}], "bodies": [
                      {"type": "static", "shapes": [{"type": "plane"}]}, )" +
                         bodies + "]" + more + "}",
                     "x.json");
}

template <class real>
Simulation<real> on_reference(const InitialState<real>& state) {
  return Simulation<real>(std::make_unique<ReferenceBackend<real>>(state), state.params,
                          state.buffers.step_index.front());
}

template <class real>
Simulation<real> on_device(const InitialState<real>& state, const DeviceOptions& options = {}) {
  return Simulation<real>(std::make_unique<DeviceBackend<real>>(state, test_device(), options), state.params,
                          state.buffers.step_index.front());
}

template <class real>
const Buffers<real>& state_of(Simulation<real>& simulation) {
  Backend<real>& backend = simulation.backend();
  static const auto wanted = [](Features features) {
    std::vector<Buffer> buffers = {Buffer::positions, Buffer::orientations, Buffer::motions};
    if (has(features, Feature::sleeping)) buffers.push_back(Buffer::sleepers);
    return buffers;
  };
  return backend.download(wanted(backend.features()));
}

template <class real>
bool sleeps(Simulation<real>& simulation, u32 body) {
  return state_of(simulation).sleepers[body].island < ISLAND_WAKES;
}

template <class real>
std::uint64_t hash_of(Simulation<real>& simulation) {
  return combined_state_hash(simulation.world_hashes());
}

}  // namespace lockstep::test
