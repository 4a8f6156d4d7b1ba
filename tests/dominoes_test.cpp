// A row of dominoes against the model of J. M. J. van Leeuwen, "The domino effect", American Journal of Physics 78
// (2010): each turns about its foot, leans on the next one for ever after hitting it, without friction between the two.
// All that have been hit then move as one degree of freedom, the angle of the foremost: energy is kept between impacts,
// and an impact, fully inelastic, keeps the momentum along it.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "host/backends/reference_backend.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"

namespace lockstep::dominoes_test {
namespace {

// Of the scene. Heights and widths in m; 1 kg.
constexpr double height = 1, thickness = 0.2, pitch = 0.5, g = 9.81;
constexpr u32 dominoes = 30;

/// The angle of a domino that leans on one at `angle`, from the place of its upper edge on the face of the next.
double angle_behind(double angle) { return angle + std::asin((pitch * std::cos(angle) - thickness) / height); }

double slope_behind(double angle) {
  const double sine = (pitch * std::cos(angle) - thickness) / height;
  return 1 - pitch * std::sin(angle) / (height * std::sqrt(1 - sine * sine));
}

struct Train {
  double inertia = 0;    // kg m^2, of all together, for the rate of the foremost
  double potential = 0;  // J
};

/// The foremost at `angle` with so many behind it.
Train train(double angle, u32 behind) {
  constexpr double of_one = (height * height + thickness * thickness) / 3;  // about the foot
  Train all;
  double rate = 1;  // of a domino over that of the foremost
  for (u32 i = 0;; ++i) {
    all.inertia += of_one * rate * rate;
    all.potential += g * (height * std::cos(angle) + thickness * std::sin(angle)) / 2;
    if (i == behind) return all;
    rate *= slope_behind(angle);
    angle = angle_behind(angle);
  }
}

/// The angle at which a domino hits the next one.
double impact() { return std::asin((pitch - thickness) / height); }

/// When each domino has turned by half of what takes it to the next one, s; the first begins at 0, with a rate in
/// rad/s.
std::vector<double> times_of_model(double first_rate) {
  constexpr u32 intervals = 1000;
  std::vector<double> times;
  double rate = first_rate, time = 0;
  for (u32 k = 0; k < dominoes; ++k) {
    const Train start = train(0, k);
    const double energy = start.potential + start.inertia * rate * rate / 2;
    const auto rate_at = [&](const Train& current) {
      return std::sqrt(2 * (energy - current.potential) / current.inertia);
    };
    for (u32 i = 0; i < intervals; ++i) {
      if (2 * i == intervals) times.push_back(time);
      time += impact() / intervals / rate_at(train(impact() * (i + 0.5) / intervals, k));
    }
    const Train end = train(impact(), k);
    const double f = slope_behind(0), own = train(0, 0).inertia;
    rate = rate_at(end) * f * end.inertia / (own + f * f * end.inertia);
  }
  return times;
}

struct Fall {
  std::vector<double> times;   // s, as above
  std::vector<double> angles;  // rad, at the end
};

template <class real>
Fall fall(double dt) {
  Scene scene = read_scene("dominoes");
  scene.settings.dt = dt;
  const InitialState<real> state = compile<real>(scene);
  Simulation<real> simulation(std::make_unique<ReferenceBackend<real>>(state), state.params);
  const double half_angle = impact() / 2;
  Fall result = {std::vector<double>(dominoes, 0), std::vector<double>(dominoes, 0)};
  constexpr Buffer wanted[] = {Buffer::orientations};
  for (u32 step = 1; step * dt <= 6; ++step) {
    simulation.step();
    const auto& q = simulation.backend().download(wanted).orientations;
    for (u32 i = 0; i < dominoes; ++i) {
      const double old = result.angles[i], current = 2 * std::atan2(double(q[i + 1].y), double(q[i + 1].w));
      if (old < half_angle && current >= half_angle && result.times[i] == 0)
        result.times[i] = (step - (current - half_angle) / (current - old)) * dt;
      result.angles[i] = current;
    }
  }
  return result;
}

/// From domino 12 to 26, where the wave has come close to its steady speed and does not see the end yet. m/s
double speed(const std::vector<double>& times) { return 14 * pitch / (times[26] - times[12]); }

TEST(Dominoes, AllFallInOrderAndLeanOnTheNext) {
  const Fall row = fall<float>(1.0 / 60);
  for (u32 i = 1; i < dominoes; ++i) EXPECT_GT(row.times[i], row.times[i - 1]) << i;
  // the end: each lies on the next, all at one angle, pitch cos(angle) = thickness; the last on the ground
  for (u32 i = 0; i < 20; ++i) EXPECT_NEAR(row.angles[i], std::acos(thickness / pitch), 0.005) << i;
  EXPECT_NEAR(row.angles[dominoes - 1], std::numbers::pi / 2, 1e-3);
}

TEST(Dominoes, TheWaveRunsAtTheSpeedOfTheModel) {
  const std::vector<double> model = times_of_model(1);
  EXPECT_NEAR(speed(fall<double>(1.0 / 60).times), speed(model), 0.01 * speed(model));
  EXPECT_NEAR(speed(fall<double>(1.0 / 240).times), speed(model), 0.003 * speed(model));
}

// The first ones, whose speed grows from 0.85 to 5 m/s.
TEST(Dominoes, TheWaveBeginsAsInTheModel) {
  const std::vector<double> model = times_of_model(1);
  const Fall row = fall<double>(1.0 / 240);
  for (u32 i = 0; i < 12; ++i) EXPECT_NEAR(row.times[i], model[i], 0.01 * model[i]) << i;
}

}  // namespace
}  // namespace lockstep::dominoes_test
