// Contacts that resist rolling, rotation about the normal and the start of a slide, by closed forms of balls and crates
// on slopes.
#include <algorithm>
#include <cmath>

#include "host/cases/hard_case.hpp"
#include "host/error.hpp"
#include "host/scene/friction_pairs.hpp"
#include "host/scene/read.hpp"

namespace lockstep {

namespace {

u32 body_called(const Scene& scene, const char* name) {
  for (u32 i = 0; i < scene.bodies.size(); ++i)
    if (scene.bodies[i].name == name) return i;
  throw Error(Failure::input, scene.source, std::string("has no body ") + name);
}

/// The friction of a body against the first material of the scene, which its grounds are of.
PairFriction friction_of(const Scene& scene, u32 body) {
  return friction_pairs_of(scene)[scene.bodies[body].shapes[0].material];
}

/// A ball that rolls down a slope has the acceleration 5/7 g (sin - b / r cos), and none where that is below 0; what
/// spins on the spot slows down by 5/2 g torsional / r^2; a crate that slides has g (sin - mu cos), and one at rest
/// none where static friction holds it.
std::vector<CaseError> rolling_resistance(Trial& trial) {
  const Scene scene = read_scene("rolling_resistance");
  const double g = exact::length(scene.gravity), duration = 1;
  const auto sine = [&](const char* ground) {
    return exact::rotate(scene.bodies[body_called(scene, ground)].orientation, {1, 0, 0})[2];
  };
  const double slope = -sine("slope"), ramp = -sine("ramp");
  const auto cosine = [](double s) { return std::sqrt(1 - s * s); };
  const auto travel_of = [&](double v, double a) { return v * duration + a * duration * duration / 2; };

  struct Down {
    u32 body;
    double expected;  // m
  };
  std::vector<Down> balls, crates;
  double longest = 0;
  for (const char* name : {"steel ball", "rubber ball", "foam ball"}) {
    const u32 body = body_called(scene, name);
    const double ratio = friction_of(scene, body).rolling_coefficient / scene.bodies[body].shapes[0].radius;
    balls.push_back({body, travel_of(0, 5.0 / 7 * g * std::max(0.0, slope - ratio * cosine(slope)))});
    longest = std::max(longest, balls.back().expected);
  }
  for (const char* name : {"crate at rest", "crate pushed"}) {
    const u32 body = body_called(scene, name);
    const double v = exact::length(scene.bodies[body].velocity);
    crates.push_back({body, v > 0 ? travel_of(v, g * (ramp - friction_of(scene, body).sliding * cosine(ramp))) : 0});
  }
  const u32 spinner = body_called(scene, "felt spinner");
  const PairFriction felt = friction_of(scene, spinner);
  const double radius = scene.bodies[spinner].shapes[0].radius, start_w = scene.bodies[spinner].angular_velocity[2];
  const double expected_w = start_w - 2.5 * g * felt.torsion_radius * felt.sliding / (radius * radius) * duration;

  double off_balls = 0, off_crates = 0, off_angular_velocity = 0;
  trial.run(scene, duration, [&](Seen& seen) {
    const auto off = [&](const std::vector<Down>& bodies) {
      double worst = 0;
      for (const Down& it : bodies) {
        const Vector3 moved = exact::subtract(seen.body(it.body).x, scene.bodies[it.body].position);
        worst = std::max(worst, std::abs(exact::length(moved) - it.expected));
      }
      return worst;
    };
    off_balls = off(balls);
    off_crates = off(crates);
    off_angular_velocity = std::abs(seen.body(spinner).w[2] - expected_w);
    return true;
  });
  return {{"way of the balls, at worst of three", "m", longest, off_balls},
          {"way of the crates, at worst of two", "m", crates[1].expected, off_crates},
          {"spin on the spot", "rad/s", expected_w, off_angular_velocity}};
}

}  // namespace

std::vector<HardCase> angular_friction_cases() {
  const auto dts = {1e-2, 5e-3, 2.5e-3, 1.25e-3};
  return {{"rolling_resistance",
           "Balls of rubber roll slower than steel, a soft one stays on its slope, and static friction holds a crate: "
           "where they should be after 1 s",
           {small_steps(0.01, {1, 4, 16, 64}), semi_implicit(dts), trapezoidal(dts), jacobi(5e-3, {10, 30, 100})},
           rolling_resistance}};
}

}  // namespace lockstep
