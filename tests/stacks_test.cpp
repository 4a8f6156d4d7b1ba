// Scenes that are built at rest stay as they were built: ten seconds of the reference at their own settings.
#include <gtest/gtest.h>

#include <cmath>

#include "host/backends/reference_backend.hpp"
#include "host/report/measures.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"

namespace lockstep::test {
namespace {

struct Stood {
  double moved = 0;                      // m, of the body that moved most
  double mean_depth = 0, max_depth = 0;  // m, at the end, and the largest of all steps that were looked at
  double kinetic = 0;                    // J a body, at the end
};

template <class real>
Stood stand(const std::string& name) {
  const Scene scene = read_scene(name);
  const InitialState<real> state = compile<real>(scene);
  Simulation<real> simulation(std::make_unique<ReferenceBackend<real>>(state), state.params);
  Backend<real>& backend = simulation.backend();
  const auto measure_now = [&] {
    const auto wanted = measured_buffers(backend.features());
    return measure(backend.download(wanted), backend.sizes(), backend.features(), simulation.counters());
  };
  Stood stood;
  for (u32 i = 0; i < u32(std::lround(10 / scene.settings.dt)); ++i) {
    simulation.step();
    if (i % 30 == 0) stood.max_depth = std::max(stood.max_depth, measure_now().penetration.max);
  }
  const Measures end = measure_now();
  stood.mean_depth = end.penetration.mean;
  stood.max_depth = std::max(stood.max_depth, end.penetration.max);
  stood.kinetic = end.worlds[0].kinetic / double(scene.bodies.size());
  constexpr Buffer wanted[] = {Buffer::positions};
  const auto& positions = backend.download(wanted).positions;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec4<real>&a = state.buffers.positions[i], &b = positions[i];
    stood.moved = std::max(stood.moved, std::hypot(double(b.x) - a.x, double(b.y) - a.y, double(b.z) - a.z));
  }
  return stood;
}

// No box moves a centimetre; overlap is under half a millimetre on the mean and two at most.
TEST(StacksStand, PyramidOf210) {
  const Stood stood = stand<float>("pyramid20");
  EXPECT_LT(stood.moved, 0.01);
  EXPECT_LT(stood.mean_depth, 0.5e-3);
  EXPECT_LT(stood.max_depth, 2e-3);
  EXPECT_LT(stood.kinetic, 1e-3);
}

TEST(StacksStand, WallOf405Bricks) {
  const Stood stood = stand<float>("wall");
  EXPECT_LT(stood.moved, 0.01);
  EXPECT_LT(stood.mean_depth, 0.5e-3);
  EXPECT_LT(stood.max_depth, 2e-3);
  EXPECT_LT(stood.kinetic, 1e-3);
}

// 512 kg on top of a stack that begins with 1 kg.
TEST(StacksStand, MassRatioOf512) {
  for (const Stood& stood : {stand<float>("mass_ratio"), stand<double>("mass_ratio")}) {
    EXPECT_LT(stood.moved, 0.01);
    EXPECT_LT(stood.max_depth, 4e-3);
  }
}

}  // namespace
}  // namespace lockstep::test
