// Runs work in a process of its own, so that its memory is its own and what it leaves behind does not slow what comes
// after it: pocl 3.1 keeps up to 128 kernels loaded and never lets go of one that ran on its threads
// (docs/lab/bench.md).
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>

namespace lockstep {

/// Returns what `work` returned, numbers as they were, and in `peak_memory` the most bytes that its process held at a
/// time. Throws what it threw, an Error or (as of a device) anything else; Error (device) where its process was ended;
/// Stopped where this one was asked to end (host/stop_request.hpp).
/// The caller must not have started threads, nor asked OpenCL for anything: it starts some.
nlohmann::json run_in_subprocess(const std::function<nlohmann::json()>& work, double* peak_memory = nullptr);

}  // namespace lockstep
