#include "host/scene/particle_law.hpp"

#include <algorithm>

namespace lockstep {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

// Directions to corners, edges and faces of a cube: along them particles are looked for that can touch at once.
std::vector<Vector3> directions() {
  std::vector<Vector3> all;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z)
        if (x != 0 || y != 0 || z != 0) all.push_back(exact::unit(Vector3{double(x), double(y), double(z)}));
  return all;
}

// Particles of a quarter of a radius, or less, below the outermost one along a direction.
double side_by_side(const std::vector<std::vector<Vector3>>& particles, const Vector3& direction, double radius) {
  double most = -infinite;
  for (const auto& points : particles)
    for (const Vector3& p : points) most = std::max(most, exact::dot(p, direction));
  double count = 0;
  for (const auto& points : particles)
    for (const Vector3& p : points) count += exact::dot(p, direction) >= most - 0.25 * radius ? 1 : 0;
  return count;
}

// How much more a body yields where its outermost particle is pushed than at its centre: m times the trace of the
// inverse inertia that a force there sees.
double relative_compliance(const BodyDescription& body, const std::vector<std::vector<Vector3>>& particles) {
  double most = 0;
  for (const auto& points : particles) {
    for (const Vector3& p : points) {
      const double square = exact::dot(p, p);
      double sum = 0;
      for (unsigned k = 0; k < 3; ++k) sum += (square - p[k] * p[k]) / body.inertia[k];
      most = std::max(most, body.mass * sum);
    }
  }
  return 1 + most;
}

}  // namespace

double most_side_by_side(const BodyDescription& body, const std::vector<std::vector<Vector3>>& particles,
                         double radius) {
  double most = 0;
  for (const Vector3& direction : directions()) {
    most = std::max(most, side_by_side(particles, direction, radius));
    for (const ShapeDescription& shape : body.shapes)
      if (shape.rotation != Quaternion{0, 0, 0, 1})
        most = std::max(most, side_by_side(particles, exact::rotate(shape.rotation, direction), radius));
  }
  return most;
}

double restitution_of(double ratio) {
  // fourth order of Runge and Kutta in time, for x' = v, v' = -2 ratio v - x from x = 0, v = 1
  constexpr double h = 1.0 / 128;
  double x = 0, v = 1;
  do {
    const auto force = [ratio](double at, double speed) { return -2 * ratio * speed - at; };
    const double v1 = v, a1 = force(x, v1);
    const double v2 = v + h / 2 * a1, a2 = force(x + h / 2 * v1, v2);
    const double v3 = v + h / 2 * a2, a3 = force(x + h / 2 * v2, v3);
    const double v4 = v + h * a3, a4 = force(x + h * v3, v4);
    x += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  } while (x + 2 * ratio * v > 0);
  return -v;
}

double damping_ratio(double restitution) {
  if (restitution >= 1) return 0;
  double low = 0, high = 8;  // restitution_of(8) is less than the least
  for (unsigned i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (restitution_of(middle) > restitution ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

template <class real>
ParticleLaw<real> particle_law(const ParticleSettings& s, const Origin& origin) {
  const double root = exact::square_root(s.stiffness);
  ParticleLaw<real> law = {};
  law.radius = rounded_positive<real>(s.radius, "particles: radius", origin);
  law.stiffness = rounded_positive<real>(s.stiffness, "particles: stiffness", origin);
  law.damping = static_cast<real>(2 * damping_ratio(s.restitution) * root);
  law.shear_damping = static_cast<real>(2 * shear_damping_ratio * root);
  law.friction = rounded<real>(s.friction, "particles: friction", origin);
  if (s.shear_stiffness > 0)
    law.shear_stiffness = rounded_positive<real>(s.shear_stiffness, "particles: shear_stiffness", origin);
  return law;
}

double longest_stable_step(const BodyDescription& body, const std::vector<std::vector<Vector3>>& particles,
                           const ParticleSettings& settings, double damping) {
  const bool is_empty = std::all_of(particles.begin(), particles.end(), [](const auto& p) { return p.empty(); });
  if (body.kind != BODY_DYNAMIC || is_empty) return infinite;
  // twice as many contacts as lie side by side, for each may rest on several; or one at the far end of the body
  const double flat = most_side_by_side(body, particles, settings.radius);
  const double contacts = std::max(2 * flat, relative_compliance(body, particles));
  const double ratio = std::max(damping, shear_damping_ratio);
  const double stiffest = std::max(settings.stiffness, settings.shear_stiffness);
  // in a chain neighbours move against each other: h^2 4 n k/m + 2 h 4 n c/m < 4
  const double spring = 4 * contacts * stiffest / body.mass;
  const double damper = 4 * contacts * 2 * ratio * exact::square_root(settings.stiffness / (body.mass * flat));
  return (exact::square_root(damper * damper + 4 * spring) - damper) / spring;
}

template ParticleLaw<float> particle_law<float>(const ParticleSettings&, const Origin&);
template ParticleLaw<double> particle_law<double>(const ParticleSettings&, const Origin&);

}  // namespace lockstep
