// Recordings for tests: of a built-in scene, made in one go.
#pragma once

#include "host/record/record_step.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep {

/// The reference, or the test device with these options.
template <class real>
Simulation<real> simulation_of(const InitialState<real>& state, const DeviceOptions* options = nullptr) {
  std::unique_ptr<Backend<real>> backend;
  if (options)
    backend = std::make_unique<DeviceBackend<real>>(state, test_device(), *options);
  else
    backend = std::make_unique<ReferenceBackend<real>>(state);
  return Simulation<real>(std::move(backend), state.params, state.buffers.step_index.front());
}

/// Does a step and records it.
template <class real>
void record_step(RecordingWriter<real>& writer, Simulation<real>& simulation) {
  simulation.step();
  record_step(writer, simulation, 0.5);
}

template <class real>
void record_scene(const std::string& path, const std::string& scene, u32 steps,
                  const DeviceOptions* options = nullptr) {
  const InitialState<real> state = compile<real>(read_scene(scene));
  Simulation<real> simulation = simulation_of(state, options);
  RecordingWriter<real> writer(path, {scene, "a device\nin two lines", "{}", read_scene(scene).text}, state);
  for (u32 i = 0; i < steps; ++i) record_step(writer, simulation);
  writer.close("finished");
}

}  // namespace lockstep
