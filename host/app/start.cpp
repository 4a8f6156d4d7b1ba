#include "host/app/start.hpp"

#include <fmt/format.h>

#include "host/backends/reference_backend.hpp"
#include "host/error.hpp"
#include "host/record/whole_file.hpp"

namespace lockstep::app {

template <class real>
Start<real> make_start(std::span<const Scene> worlds, const SceneOptions& options) {
  Start<real> start;
  start.state = compile<real>(worlds);
  if (options.resume.empty()) return start;
  const Scene& scene = worlds[0];
  resume_from(read_whole_file(options.resume), options.resume, scene.name, start.state);
  start.steps_done = start.state.buffers.step_index.front();
  if (start.steps_done >= scene.settings.steps)
    throw Error(Failure::input, options.resume,
                fmt::format("is {} steps old already, and the run is to end after {}; ask for more --steps",
                            start.steps_done, scene.settings.steps));
  return start;
}

template <class real>
std::unique_ptr<Backend<real>> make_backend(const InitialState<real>& state, const SceneOptions& options) {
  const std::optional<DeviceInfo> device = device_of(options);
  if (device) return std::make_unique<DeviceBackend<real>>(state, *device, options.device_options);
  return std::make_unique<ReferenceBackend<real>>(state);
}

template Start<float> make_start<float>(std::span<const Scene>, const SceneOptions&);
template Start<double> make_start<double>(std::span<const Scene>, const SceneOptions&);
template std::unique_ptr<Backend<float>> make_backend(const InitialState<float>&, const SceneOptions&);
template std::unique_ptr<Backend<double>> make_backend(const InitialState<double>&, const SceneOptions&);

}  // namespace lockstep::app
