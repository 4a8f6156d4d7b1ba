#include "host/scene/real_inertia.hpp"

#include <algorithm>
#include <cmath>

namespace lockstep {

namespace {

// By how much a moment is below the sum of the others.
double below_sum(const Vector3& moments, unsigned i) {
  return moments[(i + 1) % 3] + moments[(i + 2) % 3] - moments[i];
}

// The nearest point of the cone below_sum >= 0: the set is the same under every rotation, so that the nearest tensor
// has the same principal axes. It lies within, on a face, on an edge (two equal moments beside 0) or at the tip.
Vector3 nearest_moments(const Vector3& given) {
  const double size = std::abs(given[0]) + std::abs(given[1]) + std::abs(given[2]);
  const auto is_within = [&](const Vector3& m) {
    return std::min({below_sum(m, 0), below_sum(m, 1), below_sum(m, 2)}) >= -1e-12 * size;
  };
  if (is_within(given)) return given;
  Vector3 best = {0, 0, 0};
  double least = exact::dot(given, given);
  const auto offer = [&](const Vector3& m) {
    const Vector3 off = exact::subtract(given, m);
    const double distance = exact::dot(off, off);
    if (!is_within(m) || !(distance < least)) return;
    best = m;
    least = distance;
  };
  for (unsigned i = 0; i < 3; ++i) {
    const double third = below_sum(given, i) / 3;
    Vector3 face = given;
    for (unsigned k = 0; k < 3; ++k) face[k] += k == i ? third : -third;
    offer(face);
    const double mean = 0.5 * (given[(i + 1) % 3] + given[(i + 2) % 3]);
    Vector3 edge = {mean, mean, mean};
    edge[i] = 0;
    offer(edge);
  }
  return best;
}

}  // namespace

bool is_real(const MassProperties& solid) {
  constexpr double few_digits = 1e-3;  // those of a plate miss the triangle inequality by as much
  const Vector3 moments = principal_axes(solid.inertia).moments;
  for (unsigned i = 0; i < 3; ++i)
    if (!(moments[i] > 0) || below_sum(moments, i) < -few_digits * (below_sum(moments, i) + moments[i])) return false;
  return true;
}

MassProperties nearest_real(MassProperties solid) {
  const PrincipalAxes own = principal_axes(solid.inertia);
  const Vector3 moments = nearest_moments(own.moments);
  const double square = exact::dot(solid.center, solid.center);
  const double least =
      std::max(1e-4 * solid.mass * (square > 0 ? square : 0.01), 1e-3 * std::max({moments[0], moments[1], moments[2]}));
  MassProperties about_axes;
  for (unsigned i = 0; i < 3; ++i) about_axes.inertia[i] = std::max(moments[i], least);
  solid.inertia = transformed(about_axes, {0, 0, 0}, own.rotation).inertia;
  return solid;
}

}  // namespace lockstep
