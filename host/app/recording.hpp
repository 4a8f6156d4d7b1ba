// What `run` puts into a recording.
#pragma once

#include "host/app/options.hpp"
#include "host/record/recording_writer.hpp"
#include "host/report/measures.hpp"
#include "host/simulation.hpp"

namespace lockstep::app {

/// Nothing where `path` is empty.
template <class real>
std::unique_ptr<RecordingWriter<real>> make_recording(const std::string& path, const Scene& scene,
                                                      const std::string& device, const DeviceOptions& options,
                                                      const InitialState<real>& start);

/// The step that the simulation has just done.
template <class real>
void record_step(RecordingWriter<real>& recording, Simulation<real>& simulation, double milliseconds);

MeasureRow measure_row(u32 step, const Measures& measures);

}  // namespace lockstep::app
