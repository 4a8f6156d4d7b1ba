#include "host/cases/rest.hpp"

#include <algorithm>

namespace lockstep {

RestMeasures measure_rest(const Scene& scene, double duration, Trial& trial) {
  const double last_second = duration - 1 - trial.settings_for(scene).dt / 2;
  const auto bodies = static_cast<u32>(scene.bodies.size());
  std::vector<Vector3> starts;
  RestMeasures rest;
  u32 step = 0, looks = 0;
  trial.run(scene, duration, [&](Seen& seen) {
    const bool last = seen.time > last_second;
    if (step++ % 10 != 0 && !last) return true;
    const Measures& measures = seen.measures();
    rest.deepest_of_all = std::max(rest.deepest_of_all, measures.penetration.max);
    for (u32 i = 0; i < bodies; ++i) {
      const Vector3 x = seen.body(i).x;
      if (seen.time == 0) starts.push_back(x);
      rest.moved = std::max(rest.moved, exact::length(exact::subtract(x, starts[i])));
    }
    if (!last) return true;
    ++looks;
    rest.mean_depth += measures.penetration.mean;
    rest.deepest = std::max(rest.deepest, measures.penetration.max);
    rest.kinetic = std::max(rest.kinetic, measures.worlds[0].kinetic / bodies);
    return true;
  });
  rest.mean_depth /= looks;
  rest.ms = trial.ms_per_step();
  return rest;
}

RestMeasures measure_rest(const Scene& scene, const std::string& precision, const std::optional<DeviceInfo>& device) {
  const Method as_it_is = {.name = scene.name, .ladder = {}};
  Trial trial(as_it_is, {}, precision, device);
  return measure_rest(scene, scene.settings.steps * scene.settings.dt, trial);
}

}  // namespace lockstep
