// What a force from outside moves over rough ground.
#include <cmath>

#include "host/cases/hard_case.hpp"
#include "host/cases/stick_slip.hpp"
#include "host/scene/read.hpp"

namespace lockstep {

namespace {

constexpr double g = 9.81;

double square_distance(const Vector3& a, const Vector3& b) {
  const Vector3 between = exact::subtract(a, b);
  return exact::dot(between, between);
}

/// SimBenchmark's rolling test: 150 N draw a slab of 10 kg over the ground, mu = 0.4, and 25 balls of 1 kg, mu = 0.8,
/// roll on it. A ball gains 2/7 of what the slab does. Published is the mean over time of the slab's squared velocity
/// error and the balls' mean one: RaiSim 4.1e-7, Bullet 5.7e-9, MuJoCo 2.4e-3, ODE and DART 3.145, whose pyramids do
/// not let the slab move.
std::vector<CaseError> rolling(Trial& trial) {
  const Scene scene = read_scene("rolling25");
  const u32 slab = first_dynamic(scene), first = slab + 1, balls = 25;
  const double force = 150, slab_mass = 10, ball_mass = 1;
  const Vector3 along = {0.5, std::sqrt(0.75), 0};
  const double friction = 0.4 * (slab_mass + balls * ball_mass) * g;                           // N, under the slab
  const double pull = (force - friction) / slab_mass / (3.5 / ball_mass + balls / slab_mass);  // N, on a ball
  const double of_slab = (force - friction - balls * pull) / slab_mass, of_ball = pull / ball_mass;  // m/s^2
  const auto at = [&](double acceleration, double time) {
    return Vector3{acceleration * time * along[0], acceleration * time * along[1], 0};
  };
  double sum = 0;
  u32 seen = 0;
  trial.run(
      scene, 4,
      [&](Seen& sample) {
        if (sample.time == 0) return true;
        double of_balls = 0;
        for (u32 i = 0; i < balls; ++i) of_balls += square_distance(sample.body(first + i).v, at(of_ball, sample.time));
        sum += square_distance(sample.body(slab).v, at(of_slab, sample.time)) + of_balls / balls;
        ++seen;
        return true;
      },
      Push{slab, [&](double) {
             return Vector3{force * along[0], force * along[1], 0};
           }});
  return {{"mean squared velocity error", "m^2/s^2", 0, sum / seen}};
}

/// A block of 1 kg under 8 cos t N along x, of which friction takes up 7.848.
std::vector<CaseError> oscillating_push(Trial& trial) {
  const Scene scene = read_scene("pushed_block");
  const double push = 8, duration = 10, dt = trial.settings_for(scene).dt;
  const StickSlip exact(push, 0.8 * g, duration);
  const u32 block = first_dynamic(scene);
  double sum = 0, position = 0;
  u32 seen = 0;
  trial.run(
      scene, duration,
      [&](Seen& sample) {
        const BodyState state = sample.body(block);
        sum += std::abs(state.v[0] - exact.speed(sample.time));
        position = state.x[0];
        ++seen;
        return true;
      },
      // A step holds its force. That of its middle is the mean over the step up to dt^2; that of its start would make
      // every method one of first order.
      Push{block, [&](double time) {
             return Vector3{push * std::cos(time + dt / 2), 0, 0};
           }});
  return {compare("place after 10 s", "m", exact.position(duration), position),
          {"mean speed error", "m/s", 0, sum / seen}};
}

}  // namespace

std::vector<HardCase> pushed_cases() {
  return {
      {"rolling",
       "25 balls roll on a slab that is drawn askew over rough ground: their velocities and its own",
       {gauss_seidel(1e-3, {2, 5, 10, 20, 50}), cell_gauss_seidel(1e-3, {2, 5, 10, 20, 50}),
        jacobi(1e-3, {10, 30, 100}), gradient(1e-3, {30, 100, 300}), accelerated_gradient(1e-3, {30, 100, 300}),
        dense_gauss_seidel(1e-3, {2, 5, 10, 20, 50}), small_steps(1e-3, {1, 2, 5, 10}), by_oracle("auto", {4e-3, 1e-3}),
        by_oracle("pyramid_lemke", {0.01}), by_oracle("box_baraff", {0.01})},
       rolling},
      // one pair of shapes: jacobi is gauss_seidel here
      {"oscillating_push",
       "A block slips and sticks by turns under a force that goes to and fro: where and when",
       {gauss_seidel(1e-3, {2, 5, 10, 20, 50, 100}), small_steps(1e-3, {1, 2, 5, 10}),
        by_oracle("auto", {4e-3, 2e-3, 1e-3, 5e-4})},
       oscillating_push},
  };
}

}  // namespace lockstep
