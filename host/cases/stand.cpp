#include "host/cases/stand.hpp"

#include <algorithm>

namespace lockstep {

Stood stand(const Scene& scene, double duration, Trial& trial) {
  const double last_second = duration - 1 - trial.settings_for(scene).dt / 2;
  const auto bodies = static_cast<u32>(scene.bodies.size());
  std::vector<Vector3> starts;
  Stood stood;
  u32 step = 0, looks = 0;
  trial.run(scene, duration, [&](Seen& seen) {
    const bool last = seen.time > last_second;
    if (step++ % 10 != 0 && !last) return true;
    const Measures& measures = seen.measures();
    stood.deepest_of_all = std::max(stood.deepest_of_all, measures.penetration.max);
    for (u32 i = 0; i < bodies; ++i) {
      const Vector3 x = seen.body(i).x;
      if (seen.time == 0) starts.push_back(x);
      stood.moved = std::max(stood.moved, exact::length(exact::subtract(x, starts[i])));
    }
    if (!last) return true;
    ++looks;
    stood.mean_depth += measures.penetration.mean;
    stood.deepest = std::max(stood.deepest, measures.penetration.max);
    stood.kinetic = std::max(stood.kinetic, measures.worlds[0].kinetic / bodies);
    return true;
  });
  stood.mean_depth /= looks;
  stood.ms = trial.ms_per_step();
  return stood;
}

Stood stand(const Scene& scene, const std::string& precision, const std::optional<DeviceInfo>& device) {
  const Method as_it_is = {.name = scene.name, .ladder = {}};
  Trial trial(as_it_is, {}, precision, device);
  return stand(scene, scene.settings.steps * scene.settings.dt, trial);
}

}  // namespace lockstep
