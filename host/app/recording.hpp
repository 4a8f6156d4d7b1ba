// What `run` puts into a recording.
#pragma once

#include "host/app/options.hpp"
#include "host/record/record_step.hpp"
#include "host/simulation.hpp"

namespace lockstep::app {

/// Nothing where `path` is empty.
template <class real>
std::unique_ptr<RecordingWriter<real>> make_recording(const std::string& path, const Scene& scene,
                                                      const std::string& device, const DeviceOptions& options,
                                                      const InitialState<real>& start, bool forces);

}  // namespace lockstep::app
