// One body without contact: what integrators of motion are to keep.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/cases/hard_case.hpp"
#include "host/scene/read.hpp"

namespace lockstep {

namespace {

using exact::length;
using exact::rotate;
using exact::subtract;

Method integrated(const std::string& name, Integrator integrator, Gyroscopic gyroscopic,
                  std::initializer_list<double> dts) {
  return {name,
          [=](Settings& settings) {
            settings.integrator = integrator;
            settings.gyroscopic = gyroscopic;
          },
          {},
          steps_of(dts)};
}

/// The parabola x0 + v0 t + g t^2 / 2 after one second, and the angular momentum.
std::vector<CaseError> free_flight(Trial& trial) {
  const Scene scene = read_scene("free_flight");
  const BodyDescription& body = scene.bodies[0];
  const auto momentum = [&](const BodyState& s) {
    const Vector3 w = s.w_body();
    return rotate(s.q, {body.inertia[0] * w[0], body.inertia[1] * w[1], body.inertia[2] * w[2]});
  };
  Vector3 exact, start, end;
  double error = 0;
  trial.run(scene, 1.0, [&](Seen& seen) {
    const BodyState s = seen.body(0);
    if (seen.time == 0) start = momentum(s);
    for (int k = 0; k < 3; ++k)
      exact[k] = body.position[k] + body.velocity[k] * seen.time + scene.gravity[k] * seen.time * seen.time / 2;
    error = length(subtract(s.x, exact));
    end = momentum(s);
    return true;
  });
  return {{"place after 1 s", "m", length(exact), error},
          {"angular momentum after 1 s", "kg m^2/s", length(start), length(subtract(end, start))}};
}

/// Time between every second sign change of the middle body rate: the period of the tumbling, which is the shorter the
/// farther the spin is from the middle axis at the start. `off`: the rate about the least axis, rad/s.
std::vector<CaseError> dzhanibekov(double off, double exact_period, Trial& trial) {
  Scene scene = read_scene("dzhanibekov");
  scene.bodies[0].angular_velocity[0] = off;
  const Vector3 inertia = scene.bodies[0].inertia;
  std::vector<double> changes;
  double old_rate = 0, old_time = 0, energy = 0, drift = 0;
  trial.run(scene, 30.0, [&](Seen& seen) {
    const Vector3 w = seen.body(0).w_body();
    if (seen.time > 0 && (w[1] < 0) != (old_rate < 0))
      changes.push_back(old_time + (seen.time - old_time) * old_rate / (old_rate - w[1]));
    old_rate = w[1];
    old_time = seen.time;
    const double e = (inertia[0] * w[0] * w[0] + inertia[1] * w[1] * w[1] + inertia[2] * w[2] * w[2]) / 2;
    if (seen.time == 0) energy = e;
    drift = std::max(drift, std::abs(e - energy));
    return true;
  });
  const double period = changes.size() > 2 ? changes[2] - changes[0] : 0;
  return {compare("period of the middle rate", "s", exact_period, period), {"energy", "J", energy, drift}};
}

/// Simo and Wong's fast top: the Hamiltonian is constant.
std::vector<CaseError> heavy_top(Trial& trial) {
  const Scene scene = read_scene("heavy_top");
  const BodyDescription& body = scene.bodies[0];
  const double m = body.mass, l = length(body.com_offset), constant = 1269.975005;
  double drift = 0;
  trial.run(scene, 10.0, [&](Seen& seen) {
    const BodyState s = seen.body(0);
    const Vector3 w = s.w_body();
    const double energy = ((body.inertia[0] + m * l * l) * w[0] * w[0] + (body.inertia[1] + m * l * l) * w[1] * w[1] +
                           body.inertia[2] * w[2] * w[2]) /
                              2 -
                          m * scene.gravity[2] * rotate(s.q, body.com_offset)[2];
    drift = std::max(drift, std::abs(energy - constant));
    return true;
  });
  return {{"largest drift of the Hamiltonian in 10 s", "J", constant, drift}};
}

/// A top in steady precession: rate of the azimuth of its axis, and how far the tilt strays.
std::vector<CaseError> steady_precession(double rate, Trial& trial) {
  const double tilt = std::numbers::pi / 6, axial_rate = 60, duration = 2.0;
  Scene scene = read_scene("steady_precession");
  // the angular velocity of the steady motion: precession about z, total rate `axial_rate` along the axis of the body
  const Vector3 axis = rotate(scene.bodies[0].orientation, {0, 0, 1});
  Vector3& w = scene.bodies[0].angular_velocity;
  w = {0, 0, rate};
  for (int k = 0; k < 3; ++k) w[k] += (axial_rate - rate * std::cos(tilt)) * axis[k];
  double azimuth_change = 0, last = 0, nutation = 0, time = 0;
  trial.run(scene, duration, [&](Seen& seen) {
    const Vector3 a = rotate(seen.body(0).q, {0, 0, 1});
    const double azimuth = std::atan2(a[1], a[0]);
    if (seen.time > 0) azimuth_change += std::remainder(azimuth - last, 2 * std::numbers::pi);
    last = azimuth;
    time = seen.time;
    nutation = std::max(nutation, std::abs(std::acos(a[2]) - tilt));
    return true;
  });
  return {compare("rate of precession", "rad/s", rate, azimuth_change / time), {"tilt", "rad", tilt, nutation}};
}

/// A pendulum released from the horizontal: where it is after 10 s.
std::vector<CaseError> pendulum(Trial& trial) {
  const Scene scene = read_scene("pendulum_a01");
  Vector3 start = {}, end = {};
  trial.run(scene, 10.0, [&](Seen& seen) {
    end = seen.body(0).x;
    if (seen.time == 0) start = end;
    return true;
  });
  // released along +-x from a pivot at the height of the start; the exact point is for a release along +x
  const double side = start[0] - rotate(scene.bodies[0].orientation, scene.bodies[0].com_offset)[0];
  const double sign = start[0] >= side ? 1 : -1, x = sign * (end[0] - side), z = end[2] - start[2];
  return {{"place after 10 s", "m", 1.0, std::hypot(x - 0.2750874626, z + 0.9614192051)}};
}

}  // namespace

std::vector<HardCase> motion_cases() {
  using std::bind_front;
  const auto explicit_euler = [](std::initializer_list<double> dts) {
    return integrated("explicit Euler", Integrator::explicit_euler, Gyroscopic::explicit_, dts);
  };
  const auto semi_implicit = [](std::initializer_list<double> dts) {
    return integrated("semi-implicit Euler", Integrator::semi_implicit_euler, Gyroscopic::implicit, dts);
  };
  const auto midpoint = [](std::initializer_list<double> dts) {
    return integrated("midpoint", Integrator::trapezoidal, Gyroscopic::midpoint, dts);
  };
  const auto runge_kutta = [](std::initializer_list<double> dts) {
    return integrated("Runge-Kutta 4", Integrator::runge_kutta, Gyroscopic::implicit, dts);
  };
  return {
      {"free_flight",
       "A spinning body is thrown: a parabola, and constant angular momentum",
       {explicit_euler({0.04, 0.02, 0.01, 0.005}), semi_implicit({0.04, 0.02, 0.01, 0.005}),
        midpoint({0.04, 0.02, 0.01, 0.005}), runge_kutta({0.04, 0.02, 0.01, 0.005})},
       free_flight},
      {"dzhanibekov",
       "A body tumbles about its middle axis: the period is 13.722675 s, energy is constant",
       {explicit_euler({0.002, 0.001, 0.0005}), semi_implicit({0.002, 0.001, 0.0005}), midpoint({0.02, 0.01, 0.005}),
        runge_kutta({0.04, 0.02, 0.01})},
       bind_front(dzhanibekov, 1e-3, 13.722675)},
      {"dzhanibekov_10th",
       "The same, a hundred times as far off the axis at the start: 7.340968 s",
       {midpoint({0.02, 0.01, 0.005, 0.0025}), runge_kutta({0.04, 0.02, 0.01, 0.005})},
       bind_front(dzhanibekov, 0.1, 7.340968)},
      {"heavy_top",
       "Simo and Wong's fast top: the Hamiltonian stays 1269.975005 J",
       {runge_kutta({0.018, 0.009, 0.0045, 0.00225})},
       heavy_top},
      {"slow_precession",
       "A top of 60 rad/s, tilted by 30 degrees, goes round at 0.848689 rad/s",
       {runge_kutta({0.008, 0.004, 0.002, 0.001})},
       bind_front(steady_precession, 0.848689)},
      {"fast_precession",
       "The same top in its other steady motion, at 22.245322 rad/s",
       {runge_kutta({0.008, 0.004, 0.002, 0.001})},
       bind_front(steady_precession, 22.245322)},
      {"pendulum_a01",
       "A pendulum let go level: where it is after ten seconds",
       {runge_kutta({0.04, 0.02, 0.01, 0.005})},
       pendulum},
  };
}

}  // namespace lockstep
