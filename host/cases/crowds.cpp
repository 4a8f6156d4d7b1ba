// Many smooth balls: what all of them together keep. The cases and the published figures are SimBenchmark's.
#include <algorithm>
#include <cmath>

#include "host/cases/hard_case.hpp"
#include "host/scene/read.hpp"

namespace lockstep {

namespace {

/// Kinetic and potential energy, J, the latter over the height 0. A ball is an isotropic body.
double energy_of_balls(const Scene& scene, Seen& sample) {
  double sum = 0;
  for (u32 i = first_dynamic(scene); i < scene.bodies.size(); ++i) {
    const BodyDescription& ball = scene.bodies[i];
    const BodyState state = sample.body(i);
    double moves = 0, rotates = 0;
    for (int k = 0; k < 3; ++k) {
      moves += state.v[k] * state.v[k];
      rotates += state.w[k] * state.w[k];
    }
    sum += (ball.mass * moves + ball.inertia[0] * rotates) / 2 - ball.mass * scene.gravity[2] * state.x[2];
  }
  return sum;
}

/// The mean over time of the squared change of the energy.
class EnergyError {
 public:
  explicit EnergyError(const Scene& scene) : scene_(scene) {}

  void look(Seen& sample) {
    const double energy = energy_of_balls(scene_, sample);
    if (sample.time == 0) first_ = energy;
    sum_ += (energy - first_) * (energy - first_);
    gain_ = std::max(gain_, energy - first_);
    ++seen_;
  }
  CaseError error() const { return {"mean squared energy error", "J^2", 0, sum_ / seen_}; }
  CaseError gain() const { return {"largest gain of energy", "J", 0, gain_}; }

 private:
  const Scene& scene_;
  double first_ = 0, sum_ = 0, gain_ = 0;  // J, J^2, J
  u32 seen_ = 0;
};

/// 49 balls of 10 kg, dropped from 5 m: 24034.5 J. Published at dt 1e-3: RaiSim 0.0186 J^2, ODE 185, Bullet 7.5e4. A
/// bounce that gives the speed back keeps the energy whenever it happens, so the time is looked at too: the exact
/// height is 5 - g s^2 / 2, s the time from the nearest top.
std::vector<CaseError> bouncing(Trial& trial) {
  const Scene scene = read_scene("elastic_balls");
  const u32 ball = first_dynamic(scene);
  const double top = scene.bodies[ball].position[2], g = -scene.gravity[2];
  const double period = 2 * std::sqrt(2 * (top - scene.bodies[ball].shapes[0].radius) / g);
  EnergyError energy(scene);
  double off = 0;
  u32 seen = 0;
  trial.run(scene, 20, [&](Seen& sample) {
    energy.look(sample);
    const double s = std::remainder(sample.time, period);
    off += std::abs(sample.body(ball).x[2] - (top - g * s * s / 2));
    ++seen;
    return true;
  });
  return {energy.error(), energy.gain(), {"mean error of a height", "m", 0, off / seen}};
}

/// Published at dt 1e-3: RaiSim 8.4 J^2, ODE 112, Bullet 4.1e4, of some 34.5 kJ (docs/lab/bench.md says where ours
/// goes).
std::vector<CaseError> elastic666(Trial& trial) {
  const Scene scene = read_scene("balls666_elastic");
  EnergyError energy(scene);
  trial.run(scene, 10, [&](Seen& sample) {
    energy.look(sample);
    return true;
  });
  return {energy.error(), energy.gain()};
}

/// Of balls of one radius with each other and with the ground at height 0, m^2, from their centres alone.
double squared_penetrations(std::vector<Vector3>& centres, double radius) {
  const auto squared = [](double depth) { return depth > 0 ? depth * depth : 0; };
  std::ranges::sort(centres);  // along x first, so that a ball meets those that follow it within its diameter
  double sum = 0;
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const Vector3& a = centres[i];
    sum += squared(radius - a[2]);
    for (std::size_t j = i + 1; j < centres.size() && centres[j][0] - a[0] < 2 * radius; ++j) {
      const Vector3& b = centres[j];
      const double x = b[0] - a[0], y = b[1] - a[1], z = b[2] - a[2];
      sum += squared(2 * radius - std::sqrt(x * x + y * y + z * z));
    }
  }
  return sum;
}

/// Published at dt 1e-3: RaiSim 1.35e-4 m^2, ODE 1.55e-4, MuJoCo 0.095, Bullet 0.38.
std::vector<CaseError> six66(Trial& trial) {
  const Scene scene = read_scene("balls666");
  const u32 first = first_dynamic(scene);
  std::vector<Vector3> centres(scene.bodies.size() - first);
  double sum = 0;
  u32 seen = 0;
  trial.run(scene, 10, [&](Seen& sample) {
    for (u32 i = 0; i < centres.size(); ++i) centres[i] = sample.body(first + i).x;
    sum += squared_penetrations(centres, scene.bodies[first].shapes[0].radius);
    ++seen;
    return true;
  });
  return {{"mean sum of squared penetrations", "m^2", 0, sum / seen}};
}

}  // namespace

std::vector<HardCase> crowd_cases() {
  return {
      // a ball has one contact at a time, which one solve satisfies: more sweeps, jacobi and oracles change nothing
      {"bouncing",
       "49 elastic balls bounce for 20 s: their energy is constant",
       {trapezoidal({8e-3, 4e-3, 2e-3, 1e-3}), semi_implicit({8e-3, 4e-3, 2e-3, 1e-3}),
        small_steps(1e-3, {2, 5, 10, 20})},
       bouncing},
      // no oracle: ten thousand systems of some hundred contacts take it minutes
      {"six66",
       "A lattice of 216 balls collapses: no two of them may overlap",
       {gauss_seidel(1e-3, {5, 10, 20, 50}), cell_gauss_seidel(1e-3, {5, 10, 20, 50}), jacobi(1e-3, {10, 30, 100}),
        accelerated_gradient(1e-3, {20, 50, 100}), dense_gauss_seidel(1e-3, {5, 10, 20, 50}),
        small_steps(1e-3, {2, 5, 10})},
       six66},
      // exact solutions of each step come out alike, so the ladder is one of time steps
      {"elastic666",
       "A lattice of 216 elastic balls falls and bursts: its energy is constant",
       {trapezoidal({4e-3, 2e-3, 1e-3, 5e-4}), small_steps(1e-3, {2, 5, 10})},
       elastic666},
  };
}

}  // namespace lockstep
