#include "bench/stand.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "host/backends/device_backend.hpp"
#include "host/backends/reference_backend.hpp"
#include "host/report/measures.hpp"
#include "host/scene/compile.hpp"
#include "host/simulation.hpp"

namespace lockstep::bench {

namespace {

using Clock = std::chrono::steady_clock;

template <class real>
std::unique_ptr<Backend<real>> backend_on(const std::string& device_name, const InitialState<real>& state) {
  const auto device = select_device(device_name);
  if (device) return std::make_unique<DeviceBackend<real>>(state, *device);
  return std::make_unique<ReferenceBackend<real>>(state);
}

template <class real>
double farthest(const std::vector<Vec4<real>>& from, const std::vector<Vec4<real>>& to) {
  double most = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vec4<real>&a = from[i], &b = to[i];
    most = std::max(most, std::hypot(double(b.x) - a.x, double(b.y) - a.y, double(b.z) - a.z));
  }
  return most;
}

}  // namespace

template <class real>
Stood stand(const Scene& scene, const std::string& device) {
  const InitialState<real> state = compile<real>(scene);
  Simulation<real> simulation(backend_on(device, state), state.params);
  Backend<real>& backend = simulation.backend();
  const std::vector<Buffer> wanted = measured_buffers(backend.features());
  const u32 steps = scene.settings.steps, second = std::max(1u, static_cast<u32>(1 / scene.settings.dt));
  std::vector<double> ms;
  Stood stood;
  u32 measured = 0;
  for (u32 i = 0; i < steps; ++i) {
    const auto begin = Clock::now();
    simulation.step();
    ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
    const bool last = i + second >= steps;
    if (!last && i % 10 != 0) continue;
    const Buffers<real>& now = backend.download(wanted);
    const Measures m = measure(now, backend.sizes(), backend.features(), simulation.counters());
    stood.moved = std::max(stood.moved, farthest(state.buffers.positions, now.positions));
    stood.deepest_of_all = std::max(stood.deepest_of_all, m.penetration.max);
    if (!last) continue;
    ++measured;
    stood.mean_depth += m.penetration.mean;
    stood.deepest = std::max(stood.deepest, m.penetration.max);
    stood.kinetic = std::max(stood.kinetic, m.worlds[0].kinetic / double(scene.bodies.size()));
  }
  stood.mean_depth /= measured;
  std::ranges::nth_element(ms, ms.begin() + static_cast<long>(ms.size() / 2));
  stood.ms = ms[ms.size() / 2];
  return stood;
}

template Stood stand<float>(const Scene&, const std::string&);
template Stood stand<double>(const Scene&, const std::string&);

}  // namespace lockstep::bench
