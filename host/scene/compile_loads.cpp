#include "host/scene/compile_loads.hpp"

#include <algorithm>

#include "host/error.hpp"
#include "host/scene/rounding.hpp"

namespace lockstep {

bool has_loads(std::span<const Scene> worlds) {
  const Settings& settings = worlds[0].settings;
  const auto is_supported = [](const BodyDescription& body) { return body.gravity_share != 1; };
  const bool has = settings.loads || std::ranges::any_of(worlds, [&](const Scene& scene) {
                     return std::ranges::any_of(scene.bodies, is_supported);
                   });
  if (has && settings.integrator == Integrator::runge_kutta)
    throw Error(Failure::input, worlds[0].source + ": /settings/integrator",
                "runge_kutta knows no forces from outside; use trapezoidal");
  return has;
}

template <class real>
void support_weights(std::span<const Scene> worlds, Buffers<real>& buffers) {
  std::size_t i = 0;
  for (const Scene& scene : worlds) {
    for (const BodyDescription& body : scene.bodies) {
      const double supported = (1 - body.gravity_share) * body.mass;
      if (supported != 0) {
        const Vec4<real> force = rounded<real>(exact::scale(-supported, scene.gravity), "gravity", {scene});
        Load<real>& load = buffers.loads[i];
        load.force[0] = force.x;
        load.force[1] = force.y;
        load.force[2] = force.z;
      }
      ++i;
    }
  }
}

template void support_weights(std::span<const Scene>, Buffers<float>&);
template void support_weights(std::span<const Scene>, Buffers<double>&);

}  // namespace lockstep
