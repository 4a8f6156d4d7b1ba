// Mechanisms of rigid joints without friction: what hangs keeps its shape; of what swings no joint comes apart, and the
// energy is constant.
#include <algorithm>
#include <cmath>

#include "host/cases/hard_case.hpp"
#include "host/cases/swing.hpp"
#include "host/scene/read.hpp"

namespace lockstep {

namespace {

/// Ball joints: what matters first is that the chain holds.
std::vector<CaseError> chain(const std::string& name, Trial& trial) {
  const Swung worst = swing(read_scene(name), 5, trial);
  return {{"largest separation of a joint", "m", 0, worst.separation},
          {"largest change of energy in its range", "", 0, std::max(worst.gained, worst.lost)}};
}

/// Hinges, on a motion that never ends.
std::vector<CaseError> hinges(const std::string& name, Trial& trial) {
  const Swung worst = swing(read_scene(name), 10, trial);
  return {{"largest change of energy in its range", "", 0, std::max(worst.gained, worst.lost)},
          {"largest separation of a joint", "m", 0, worst.separation},
          {"largest angle of a joint", "rad", 0, worst.angle}};
}

/// 20 links of 1 m and 1 kg hang from two points 15 m apart, built as they are to hang: the tangent of link i is
/// (i - 19/2) w / H, where w is the weight of a link and H the pull that makes the span 15 m.
std::vector<CaseError> hanging_chain(Trial& trial) {
  const Scene scene = read_scene("hanging_chain");
  const double pull = 5.547180148886426, depth = 5.8950210006234185, duration = 10, weight = 9.81;
  const u32 links = 20;
  double moved = 0, lowest = 0, pulled = 0;
  u32 looks = 0;
  trial.run(scene, duration, [&](Seen& seen) {
    lowest = 0;
    for (u32 i = 0; i < links; ++i) {
      const BodyState link = seen.body(i);
      moved = std::max(moved, exact::length(exact::subtract(link.x, scene.bodies[i].position)));
      lowest = std::min(lowest, link.x[2] - std::abs(exact::rotate(link.q, {0, 0, 0.5})[2]));
    }
    if (seen.time < duration - 1) return true;
    pulled += std::abs(seen.joint_force(0)[0]) / weight;
    ++looks;
    return true;
  });
  return {{"moved, the farthest", "m", 0, moved},
          compare("depth", "m", depth, -lowest),
          compare("pull along the span, in weights of a link", "", pull, pulled / looks)};
}

}  // namespace

std::vector<HardCase> linkage_cases() {
  using std::bind_front;
  const double frame = 1.0 / 60;
  return {
      {"hanging_chain",
       "A chain of 20 links hangs over a span of 15: it stays, 5.895021 deep, and pulls with 5.547180 links",
       {small_steps(frame, {1, 4, 16, 64, 256}), gauss_seidel(frame, {10, 100, 1000}),
        with_direct_joints(gauss_seidel(frame, {1, 10, 100}), 1), by_oracle("auto", {frame}),
        by_oracle("mixed_ldlt", {frame}), by_oracle("impulse_based", {frame}), reduced({frame})},
       hanging_chain},
      {"chain64",
       "A chain of 64 links swings down with 100 times the mass of a link at its end",
       {small_steps(frame, {16, 32, 64, 128, 256}), gauss_seidel(1e-3, {10, 30, 100}),
        with_direct_joints(semi_implicit({4e-3, 2e-3, 1e-3, 5e-4}), 1), by_oracle("mixed_ldlt", {4e-3, 2e-3, 1e-3}),
        by_oracle("impulse_based", {4e-3, 2e-3, 1e-3}), reduced({frame, 4e-3, 2e-3, 1e-3})},
       bind_front(chain, "chain64")},
      {"chain200",
       "A chain of 50 links swings down with 200 times the mass of a link at its end",
       {small_steps(frame, {8, 16, 32, 64, 128}), gauss_seidel(1e-3, {10, 30, 100}),
        with_direct_joints(semi_implicit({4e-3, 2e-3, 1e-3, 5e-4}), 1), by_oracle("mixed_ldlt", {4e-3, 2e-3, 1e-3}),
        by_oracle("impulse_based", {4e-3, 2e-3, 1e-3, 5e-4}), reduced({frame, 4e-3, 2e-3, 1e-3})},
       bind_front(chain, "chain200")},
      // the oracle stalls: joints that are more than needed contradict each other once they have drifted
      {"bricard",
       "A linkage of six hinges, four of them more than it needs, swings for ever",
       {small_steps(0.01, {8, 16, 32, 64}), trapezoidal({4e-3, 2e-3, 1e-3, 5e-4}),
        with_direct_joints(trapezoidal({4e-3, 2e-3, 1e-3, 5e-4}), 1), by_oracle("auto", {0.01}),
        by_oracle("impulse_based", {4e-3, 2e-3, 1e-3}), reduced({0.01, 4e-3, 2e-3, 1e-3})},
       bind_front(hinges, "bricard")},
      {"pendulum_chain",
       "Six rods hinged end to end swing in one plane, chaotic and of one energy",
       {small_steps(0.005, {8, 16, 32, 64}), trapezoidal({4e-3, 2e-3, 1e-3, 5e-4}),
        with_direct_joints(trapezoidal({4e-3, 2e-3, 1e-3, 5e-4}), 1), by_oracle("auto", {1e-3, 5e-4}),
        by_oracle("mixed_ldlt", {1e-3, 5e-4}), by_oracle("impulse_based", {4e-3, 2e-3, 1e-3, 5e-4}),
        reduced({5e-3, 2e-3, 1e-3, 5e-4})},
       bind_front(hinges, "pendulum_chain")},
  };
}

}  // namespace lockstep
