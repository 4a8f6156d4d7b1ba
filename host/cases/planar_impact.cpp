#include "host/cases/planar_impact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lockstep {

namespace {

// The two lines of an impact: normal and tangential velocity over the normal impulse p.
struct Path {
  double first_rate, then_rate;        // of u_n
  double first_tangent, then_tangent;  // impulse along the tangent for each of p
  double stop;                         // p at which the first slide stops
};

Path path_of(const PlanarImpact& i) {
  const bool sticks = std::abs(i.w_nt) <= i.friction * i.w_tt;
  Path path = {};
  path.then_tangent = sticks ? -i.w_nt / i.w_tt : -std::copysign(i.friction, i.w_nt);
  path.first_tangent = i.u_t == 0 ? path.then_tangent : -std::copysign(i.friction, i.u_t);
  path.first_rate = i.w_nn + path.first_tangent * i.w_nt;
  path.then_rate = i.w_nn + path.then_tangent * i.w_nt;
  const double slip_rate = i.w_nt + path.first_tangent * i.w_tt;
  path.stop = i.u_t * slip_rate < 0 ? -i.u_t / slip_rate : std::numeric_limits<double>::infinity();
  return path;
}

double impulse_of_compression(const PlanarImpact& i, const Path& path) {
  const double alone = -i.u_n / path.first_rate;
  if (path.first_rate > 0 && alone <= path.stop) return alone;
  return path.stop - (i.u_n + path.first_rate * path.stop) / path.then_rate;
}

// The work of the normal impulse until p.
double work_until(const PlanarImpact& i, const Path& path, double p) {
  const double first = std::min(p, path.stop), then = p - first;
  return first * (i.u_n + path.first_rate * first / 2) +
         then * (i.u_n + path.first_rate * first + path.then_rate * then / 2);
}

double stronge_end(const PlanarImpact& i, const Path& path) {
  const double compressed = impulse_of_compression(i, path);
  const double wanted = -i.restitution * i.restitution * work_until(i, path, compressed);
  if (compressed >= path.stop) return compressed + std::sqrt(2 * wanted / path.then_rate);
  const double alone = compressed + std::sqrt(2 * wanted / path.first_rate);
  if (alone <= path.stop) return alone;
  const double speed = path.first_rate * (path.stop - compressed);  // u_n when the slide stops
  const double rest = wanted - speed * (path.stop - compressed) / 2;
  return path.stop + (std::sqrt(speed * speed + 2 * path.then_rate * rest) - speed) / path.then_rate;
}

PlanarImpulse followed(const PlanarImpact& i, bool by_work) {
  const Path path = path_of(i);
  const double end = by_work ? stronge_end(i, path) : (1 + i.restitution) * impulse_of_compression(i, path);
  const double first = std::min(end, path.stop);
  return {end, path.first_tangent * first + path.then_tangent * (end - first)};
}

PlanarImpulse newton(const PlanarImpact& i) {
  const double delta_u_n = -(1 + i.restitution) * i.u_n, determinant = i.w_nn * i.w_tt - i.w_nt * i.w_nt;
  const PlanarImpulse stuck = {(i.w_tt * delta_u_n + i.w_nt * i.u_t) / determinant,
                               (-i.w_nt * delta_u_n - i.w_nn * i.u_t) / determinant};
  if (std::abs(stuck.tangent) <= i.friction * stuck.normal) return stuck;
  for (const double side : {1.0, -1.0}) {  // of the slip at the end
    const double normal = delta_u_n / (i.w_nn - i.friction * side * i.w_nt), tangent = -i.friction * side * normal;
    if (normal > 0 && side * (i.u_t + i.w_nt * normal + i.w_tt * tangent) >= 0) return {normal, tangent};
  }
  return {};
}

PlanarImpulse chatterjee_ruina(const PlanarImpact& i) {
  const double determinant = i.w_nn * i.w_tt - i.w_nt * i.w_nt, smooth = -i.u_n / i.w_nn;
  const double stops_n = (-i.w_tt * i.u_n + i.w_nt * i.u_t) / determinant - smooth;
  const double stops_t = (i.w_nt * i.u_n - i.w_nn * i.u_t) / determinant;
  const double bounce = (1 + i.restitution) * smooth, whole = 1 + i.tangential_restitution;
  const bool in_cone = std::abs(whole * stops_t) <= i.friction * (bounce + whole * stops_n);
  const double share = in_cone ? whole : i.friction * bounce / (std::abs(stops_t) - i.friction * stops_n);
  return {bounce + share * stops_n, share * stops_t};
}

}  // namespace

PlanarImpulse planar_impact(ImpactLaw law, const PlanarImpact& impact) {
  switch (law) {
    case IMPACT_POISSON: return followed(impact, false);
    case IMPACT_STRONGE: return followed(impact, true);
    case IMPACT_CHATTERJEE_RUINA: return chatterjee_ruina(impact);
    default: return newton(impact);
  }
}

double energy_of(const PlanarImpact& i, const PlanarImpulse& p) {
  return p.normal * (i.u_n + (i.w_nn * p.normal + i.w_nt * p.tangent) / 2) +
         p.tangent * (i.u_t + (i.w_nt * p.normal + i.w_tt * p.tangent) / 2);
}

}  // namespace lockstep
