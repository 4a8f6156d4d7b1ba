// Laws of impact: single blows with answers in closed form.
#include <algorithm>
#include <cmath>

#include "host/cases/hard_case.hpp"
#include "host/cases/planar_impact.hpp"
#include "host/scene/read.hpp"

namespace lockstep {

namespace {

// What the foot of a body, its first shape, meets the ground with.
PlanarImpact impact_of(const BodyDescription& body, const Material& material) {
  const ShapeDescription& foot = body.shapes[0];
  const double x = foot.offset[0], z = foot.offset[2] - foot.radius;
  return {body.velocity[2],
          body.velocity[0],
          1 / body.mass + x * x / body.inertia[1],
          1 / body.mass + z * z / body.inertia[1],
          -x * z / body.inertia[1],
          material.friction,
          material.restitution,
          material.tangential_restitution.value_or(0)};
}

/// Feet that hit the ground beside their centres, by each law: Routh's cases, and Kane and Levinson's paradox.
std::vector<CaseError> eccentric_impacts(Trial& trial) {
  const Scene scene = read_scene("eccentric_impacts");
  std::vector<double> errors(IMPACT_LAWS, 0), gains(IMPACT_LAWS, -1e9);
  double newton_gain = 0;
  trial.run(scene, 0.02, [&](Seen& seen) {
    std::ranges::fill(errors, 0);
    for (u32 k = 1; k < scene.bodies.size(); ++k) {
      const BodyDescription& body = scene.bodies[k];
      const Material& material = scene.materials[body.shapes[0].material];
      const PlanarImpact impact = impact_of(body, material);
      const PlanarImpulse p = planar_impact(*material.impact_law, impact);
      const double x = body.shapes[0].offset[0], z = body.shapes[0].offset[2] - body.shapes[0].radius;
      const BodyState s = seen.body(k);
      const double off_x = s.v[0] - (body.velocity[0] + p.tangent / body.mass);
      const double off_z = s.v[2] - (body.velocity[2] + p.normal / body.mass);
      const double off_w = s.w[1] - (z * p.tangent - x * p.normal) / body.inertia[1];
      double& error = errors[*material.impact_law];
      error = std::max({error, std::abs(off_x), std::abs(off_z), std::abs(off_w) * std::hypot(x, z)});
      const auto energy = [&](double v_x, double v_z, double w) {
        return (body.mass * (v_x * v_x + v_z * v_z) + body.inertia[1] * w * w) / 2;
      };
      const double gain = energy(s.v[0], s.v[2], s.w[1]) - energy(body.velocity[0], body.velocity[2], 0);
      if (seen.time > 0) gains[*material.impact_law] = std::max(gains[*material.impact_law], gain);
      if (*material.impact_law == IMPACT_NEWTON) newton_gain = std::max(newton_gain, energy_of(impact, p));
    }
    return true;
  });
  const double others = std::max({gains[IMPACT_POISSON], gains[IMPACT_STRONGE], gains[IMPACT_CHATTERJEE_RUINA], 0.0});
  return {compare("velocities by Stronge's law", "m/s", 0, errors[IMPACT_STRONGE]),
          compare("velocities by Poisson's law", "m/s", 0, errors[IMPACT_POISSON]),
          compare("velocities by Chatterjee and Ruina's law", "m/s", 0, errors[IMPACT_CHATTERJEE_RUINA]),
          compare("velocities by Newton's law", "m/s", 0, errors[IMPACT_NEWTON]),
          compare("most energy gained by Newton's law", "J", newton_gain, gains[IMPACT_NEWTON]),
          compare("most energy gained by another", "J", 0, others)};
}

/// A ball whose slip turns round at each bounce: 3/7 and all of its speed in turn (Garwin 1969).
std::vector<CaseError> superball(Trial& trial) {
  const Scene scene = read_scene("superball");
  const u32 ball = first_dynamic(scene);
  const BodyDescription& body = scene.bodies[ball];
  const double v = body.velocity[0], radius = body.shapes[0].radius;
  double last_z = 0, worst_speed = 0, worst_rim_speed = 0, first = 0, energy = 0;
  u32 bounces = 0;
  trial.run(scene, 10, [&](Seen& seen) {
    const BodyState s = seen.body(ball);
    if (last_z < 0 && s.v[2] > 0) ++bounces;
    last_z = s.v[2];
    const bool odd = bounces % 2 == 1;
    worst_speed = std::max(worst_speed, std::abs(s.v[0] - (odd ? 3.0 / 7 : 1) * v));
    worst_rim_speed = std::max(worst_rim_speed, radius * std::abs(s.w[1] - (odd ? 10.0 / 7 : 0) * v / radius));
    const double current = seen.measures().energy();
    if (seen.time == 0) first = current;
    energy = std::max(energy, std::abs(current - first));
    return true;
  });
  return {compare("speed along the ground", "m/s", 0, worst_speed), compare("spin", "m/s", 0, worst_rim_speed),
          compare("energy", "J", 0, energy), compare("bounces in 10 s", "", 11, bounces)};
}

}  // namespace

std::vector<HardCase> impact_cases() {
  return {
      {"eccentric_impacts",
       "Bodies hit the ground beside their centres: Routh's cases, and one that gains 0.095862 J by Newton's law alone",
       {trapezoidal({0.005, 0.0025}), soft({0.005, 0.0025}), jacobi(0.005, {10}), by_oracle("auto", {0.005})},
       eccentric_impacts},
      {"superball",
       "A superball goes at 3/7 and all of its speed in turn",
       {trapezoidal({0.01, 0.005, 0.0025}), soft({0.01, 0.005}), jacobi(0.005, {10}), by_oracle("auto", {0.005})},
       superball},
  };
}

}  // namespace lockstep
