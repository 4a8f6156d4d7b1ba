#include "host/app/recording.hpp"

#include <nlohmann/json.hpp>

#include "host/scene/setting_table.hpp"

namespace lockstep::app {

namespace {

std::string options_text(const Settings& settings, const DeviceOptions& options) {
  nlohmann::ordered_json json = to_json(settings);
  json["lanes"] = options.lanes;
  json["work_group"] = options.work_group;
  json["threads"] = options.threads;
  return json.dump();
}

}  // namespace

template <class real>
std::unique_ptr<RecordingWriter<real>> make_recording(const std::string& path, const Scene& scene,
                                                      const std::string& device, const DeviceOptions& options,
                                                      const InitialState<real>& start, bool forces) {
  if (path.empty()) return nullptr;
  const RecordingLabel label = {scene.name, device,       options_text(scene.settings, options),
                                scene.text, scene.source, scene.settings.dt};
  return std::make_unique<RecordingWriter<real>>(path, label, start, Recorded{.forces = forces});
}

#define INSTANTIATE(real)                                         \
  template std::unique_ptr<RecordingWriter<real>> make_recording( \
      const std::string&, const Scene&, const std::string&, const DeviceOptions&, const InitialState<real>&, bool);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep::app
