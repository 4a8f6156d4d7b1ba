// Mechanisms of rigid joints without friction: no joint comes apart, and the energy is constant.
#include <algorithm>

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

}  // namespace

std::vector<HardCase> linkage_cases() {
  using std::bind_front;
  // Hard joints are closed by velocities that stay. In a chain that hangs, short steps bear it; in what swings for ever
  // they add up, and gauss_seidel bursts within seconds at any setting that was tried, so that it is left out there.
  const double frame = 1.0 / 60;
  return {
      {"chain64",
       "A chain of 64 links swings down with 100 times the mass of a link at its end",
       {small_steps(frame, {16, 32, 64, 128, 256}), gauss_seidel(1e-3, {10, 30, 100})},
       bind_front(chain, "chain64")},
      {"chain200",
       "A chain of 50 links swings down with 200 times the mass of a link at its end",
       {small_steps(frame, {8, 16, 32, 64, 128}), gauss_seidel(1e-3, {10, 30, 100})},
       bind_front(chain, "chain200")},
      // the oracle refuses it: joints that are more than needed contradict each other but for rounding
      {"bricard",
       "A linkage of six hinges, four of them more than it needs, swings for ever",
       {small_steps(0.01, {8, 16, 32, 64}), oracle("auto", {0.01})},
       bind_front(hinges, "bricard")},
      {"pendulum_chain",
       "Six rods hinged end to end swing in one plane, chaotic and of one energy",
       {small_steps(0.005, {8, 16, 32, 64}), oracle("auto", {1e-3, 5e-4})},
       bind_front(hinges, "pendulum_chain")},
  };
}

}  // namespace lockstep
