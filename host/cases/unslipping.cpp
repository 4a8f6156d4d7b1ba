// Bodies that skate and roll: what holds their velocities, no pose stands for.
#include <algorithm>
#include <cmath>

#include "host/cases/hard_case.hpp"
#include "host/scene/read.hpp"

namespace lockstep {

namespace {

double distance(const Vector3& a, const Vector3& b) { return exact::length(exact::subtract(a, b)); }

/// A skater who turns evenly on a slope, its edge across the slope at first, and Chaplygin's sleigh on level ice, its
/// edge behind the centre of mass (tests/joints/non_holonomic_test.cpp has both solutions).
std::vector<CaseError> skates(Trial& trial) {
  const Scene scene = read_scene("skates");
  const JointDescription &axle = scene.joints[1], &dragged = scene.joints[3];
  const BodyDescription &skater = scene.bodies[axle.body_b], &sleigh = scene.bodies[dragged.body_b];
  const Vector3 down = axle.axis, along = exact::rotate(skater.orientation, {1, 0, 0});
  const double angular_speed = exact::length(skater.angular_velocity);
  const double scale = exact::dot(scene.gravity, down) / (angular_speed * angular_speed);
  const auto on_slope = [&](double t) {
    const double phi = angular_speed * t, versine = 1 - std::cos(phi);
    const double x = std::sin(phi) - phi / 2 - std::sin(2 * phi) / 4, y = versine * versine / 2;
    return exact::add(skater.position, exact::add(exact::scale(scale * x, along), exact::scale(scale * y, down)));
  };
  const double arm = distance(sleigh.position, dragged.anchor_a), first = sleigh.angular_velocity[2];
  const double kappa = 1 + sleigh.inertia[2] / (sleigh.mass * arm * arm);
  const double last = arm * first * std::sqrt(kappa), rate = last / (arm * kappa), duration = 10;
  double off_slope = 0, off_angular_velocity = 0;
  trial.run(scene, duration, [&](Seen& seen) {
    off_slope = std::max(off_slope, distance(seen.body(axle.body_b).x, on_slope(seen.time)));
    const double error = seen.body(dragged.body_b).w[2] - first / std::cosh(rate * seen.time);
    off_angular_velocity = std::max(off_angular_velocity, std::abs(error));
    return true;
  });
  return {{"place of the skater, at worst in 10 s", "m", distance(on_slope(duration), skater.position), off_slope},
          {"spin of the sleigh, at worst in 10 s", "rad/s", first, off_angular_velocity}};
}

/// Balls on a turntable: their velocities turn at 2/7 of its rate. Those that joints let roll, and one that friction
/// does.
std::vector<CaseError> turntable(Trial& trial) {
  const Scene scene = read_scene("turntable");
  const double rate = 2.0 / 7 * scene.bodies[0].angular_velocity[2], duration = 10;
  const auto exact_position = [&](const BodyDescription& ball, double t) {
    const double c = std::cos(rate * t), s = std::sin(rate * t);
    const Vector3& v = ball.velocity;
    return exact::add(ball.position, {(v[0] * s - v[1] * (1 - c)) / rate, (v[0] * (1 - c) + v[1] * s) / rate, 0});
  };
  double by_joints = 0, by_friction = 0, circle = 0;
  trial.run(scene, duration, [&](Seen& seen) {
    for (u32 i = 1; i < scene.bodies.size(); ++i) {
      const bool by_joint = i <= scene.joints.size();
      const double off = distance(seen.body(i).x, exact_position(scene.bodies[i], seen.time));
      (by_joint ? by_joints : by_friction) = std::max(by_joint ? by_joints : by_friction, off);
      circle = std::max(circle, 2 * exact::length(scene.bodies[i].velocity) / rate);
    }
    return true;
  });
  return {{"place of the balls that joints let roll, at worst in 10 s", "m", circle, by_joints},
          {"place of the ball that friction lets roll, at worst in 10 s", "m", circle, by_friction}};
}

}  // namespace

std::vector<HardCase> unslipping_cases() {
  const auto dts = {1e-2, 5e-3, 2.5e-3, 1.25e-3};
  const std::vector<Method> methods = {small_steps(0.01, {1, 4, 16, 64}), semi_implicit(dts), trapezoidal(dts)};
  return {
      {"skates", "A skater on a slope goes sideways, a sleigh turns into a straight line: where they should be",
       methods, skates},
      {"turntable", "Balls that roll on a turntable go round at two sevenths of its rate: where they should be",
       methods, turntable},
  };
}

}  // namespace lockstep
