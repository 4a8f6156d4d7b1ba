// Mechanisms of rigid joints without friction: no joint comes apart, and the energy is constant.
#include <algorithm>
#include <cmath>

#include "host/cases/hard_case.hpp"
#include "host/scene/read.hpp"

namespace lockstep {

namespace {

/// What the weights of all bodies could do at most on the way to the origin, from which each mechanism hangs, J: what a
/// change of the energy is measured by, for the energy itself may be 0.
double range_of_energy(const Scene& scene) {
  double range = 0;
  for (const BodyDescription& body : scene.bodies)
    range += body.mass * exact::length(scene.gravity) * exact::length(body.position);
  return range;
}

/// The largest of a whole run.
struct Worst {
  double separation = 0, angle = 0;  // m, rad, of a joint
  double energy = 0;                 // in parts of its range
};

Worst watch(const std::string& name, double duration, Trial& trial) {
  const Scene scene = read_scene(name);
  const double range = range_of_energy(scene);
  Worst worst;
  double first = 0;
  trial.run(scene, duration, [&](Seen& now) {
    const Measures& measures = now.measures();
    if (now.time == 0) first = measures.energy();
    worst.separation = std::max(worst.separation, measures.joint_drift->separation);
    worst.angle = std::max(worst.angle, measures.joint_drift->angle);
    worst.energy = std::max(worst.energy, std::abs(measures.energy() - first) / range);
    return true;
  });
  return worst;
}

/// Ball joints: what matters first is that the chain holds.
std::vector<CaseError> chain(const std::string& name, Trial& trial) {
  const Worst worst = watch(name, 5, trial);
  return {{"largest separation of a joint", "m", 0, worst.separation},
          {"largest change of energy in its range", "", 0, worst.energy}};
}

/// Hinges, on a motion that never ends.
std::vector<CaseError> hinges(const std::string& name, Trial& trial) {
  const Worst worst = watch(name, 10, trial);
  return {{"largest change of energy in its range", "", 0, worst.energy},
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
