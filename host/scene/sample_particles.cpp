#include "host/scene/sample_particles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/scene/hull.hpp"
#include "host/scene/sample_mesh.hpp"

namespace lockstep {

namespace {

using Points = std::vector<Vector3>;

// How many steps of at most `spacing` a length has; rounding makes no step more.
double steps_of(double length, double spacing) { return std::ceil(length / spacing - 1e-9); }

// A circle about z, of at least three points where it is no point; every other one is turned by half a step.
void add_ring(double radius, double z, double spacing, bool staggered, Points& points) {
  if (!(radius > 1e-9 * spacing)) return points.push_back({0, 0, z});
  const double count = std::max(steps_of(2 * exact::pi * radius, spacing), 3.0);
  for (double k = 0; k < count; ++k) {
    const double degrees = 360 * (k + (staggered ? 0.5 : 0)) / count;
    points.push_back({radius * exact::cosine_of_degrees(degrees), radius * exact::sine_of_degrees(degrees), z});
  }
}

// A surface of revolution, from its lowest to its highest point: a cap of radius `round` (m, of a sphere; 0 for a flat
// disc), a tube, and the other cap. The tube is 2 `half` long.
void add_shell(double radius, double half, bool is_round, double spacing, Points& points) {
  bool staggered = false;
  const auto ring = [&](double at, double z) {
    add_ring(at, z, spacing, staggered, points);
    staggered = !staggered;
  };
  const double cap_steps = radius > 1e-9 * spacing ? steps_of((is_round ? 0.5 * exact::pi : 1) * radius, spacing) : 0;
  const double tube_steps = half > 1e-9 * spacing ? steps_of(2 * half, spacing) : 0;
  const auto cap_ring = [&](double step, double side) {  // step 0 is the pole
    const double degrees = 90 * step / cap_steps;
    if (is_round)
      ring(radius * exact::sine_of_degrees(degrees), side * (half + radius * exact::cosine_of_degrees(degrees)));
    else
      ring(radius * step / cap_steps, side * half);
  };
  for (double i = 0; i < cap_steps; ++i) cap_ring(i, -1);
  if (tube_steps == 0 && (is_round || cap_steps == 0)) ring(radius, 0);
  if (tube_steps == 0 && !is_round && cap_steps > 0) return ring(radius, 0);  // a disc has one side
  for (double i = 0; tube_steps > 0 && i <= tube_steps; ++i) ring(radius, half * (2 * i / tube_steps - 1));
  for (double i = cap_steps; i > 0; --i) cap_ring(i - 1, 1);
}

void add_box(const Vector3& half, double spacing, bool solid, Points& points) {
  Vector3 steps;
  for (unsigned k = 0; k < 3; ++k) steps[k] = half[k] > 1e-9 * spacing ? steps_of(2 * half[k], spacing) : 0;
  const auto at = [&](unsigned k, double i) { return steps[k] > 0 ? half[k] * (2 * i / steps[k] - 1) : 0; };
  const auto is_end = [&](unsigned k, double i) { return i == 0 || i == steps[k]; };
  for (double x = 0; x <= steps[0]; ++x) {
    for (double y = 0; y <= steps[1]; ++y) {
      // within a surface only the two ends
      const bool whole = solid || is_end(0, x) || is_end(1, y) || steps[2] == 0;
      for (double z = 0; z <= steps[2]; z += whole ? 1 : steps[2]) points.push_back({at(0, x), at(1, y), at(2, z)});
    }
  }
}

TriangleMesh mesh_of_hull(const Points& corners) {
  std::string refusal;
  const ConvexHull hull = convex_hull(corners, refusal);
  TriangleMesh mesh = {hull.vertices, {}};
  for (const std::vector<u32>& face : hull.faces)
    for (std::size_t i = 1; i + 1 < face.size(); ++i) mesh.triangles.push_back({face[0], face[i], face[i + 1]});
  return mesh;
}

// The smallest distance from the middle of a primitive to its surface.
double thickness(const ShapeDescription& shape) {
  if (shape.kind == SHAPE_BOX) return std::min({shape.half_extents[0], shape.half_extents[1], shape.half_extents[2]});
  if (shape.kind == SHAPE_CYLINDER) return std::min(shape.radius, shape.half_length);
  return shape.radius;
}

// Half the extents of a box about the shape.
Vector3 box_about(const ShapeDescription& shape) {
  switch (shape.kind) {
    case SHAPE_BOX: return shape.half_extents;
    case SHAPE_HULL: return half_extents_of(shape.points);
    case SHAPE_MESH: return half_extents_of(shape.mesh->vertices);
    case SHAPE_CYLINDER: return {shape.radius, shape.radius, shape.half_length};
    case SHAPE_CAPSULE: return {shape.radius, shape.radius, shape.radius + shape.half_length};
    default: return {shape.radius, shape.radius, shape.radius};
  }
}

// In the frame of the shape: layers of which each is two radii below the last.
Points sample_primitive(const ShapeDescription& shape, double r, bool solid) {
  Points points;
  const double slack = 1e-9 * r, thick = thickness(shape);
  for (double depth = r; depth <= thick + slack; depth += 2 * r) {
    const auto below = [&](double x) { return std::max(x - depth, 0.0); };
    switch (shape.kind) {
      case SHAPE_BOX: {
        const Vector3& half = shape.half_extents;
        add_box({below(half[0]), below(half[1]), below(half[2])}, 2 * r, solid, points);
        return points;
      }
      case SHAPE_CYLINDER: add_shell(below(shape.radius), below(shape.half_length), false, 2 * r, points); break;
      case SHAPE_CAPSULE: add_shell(below(shape.radius), shape.half_length, true, 2 * r, points); break;
      default: add_shell(below(shape.radius), 0, true, 2 * r, points); break;
    }
    if (!solid) break;
  }
  return points;
}

std::vector<double> key_of(const BodyDescription& body) {
  std::vector<double> key;
  const auto add = [&](const auto& numbers) { key.insert(key.end(), numbers.begin(), numbers.end()); };
  for (const ShapeDescription& shape : body.shapes) {
    key.push_back(shape.kind);
    add(shape.offset);
    add(shape.rotation);
    add(std::array{shape.radius, shape.half_length});
    add(shape.half_extents);
    key.push_back(static_cast<double>(shape.points.size()));
    for (const Vector3& point : shape.points) add(point);
    if (!shape.mesh) continue;
    key.push_back(static_cast<double>(shape.mesh->triangles.size()));
    for (const Vector3& vertex : shape.mesh->vertices) add(vertex);
    for (const auto& triangle : shape.mesh->triangles) add(triangle);
  }
  return key;
}

}  // namespace

double expected_particles(const ShapeDescription& shape, const ParticleSettings& settings) {
  const Vector3 n = exact::scale(1 / settings.radius, box_about(shape));
  return settings.sampling == Sampling::solid ? n[0] * n[1] * n[2] : 2 * (n[0] * n[1] + n[1] * n[2] + n[2] * n[0]);
}

std::vector<Vector3> sample_particles(const ShapeDescription& shape, const ParticleSettings& settings,
                                      std::string& refusal) {
  const bool solid = settings.sampling == Sampling::solid;
  if (shape.kind == SHAPE_FACET) {
    refusal = "is a facet of a surface, which knows no particles; make it a closed mesh";
    return {};
  }
  if (const double expected = expected_particles(shape, settings); expected > most_particles) {
    refusal = fmt::format("needs about {:.3g} particles of the radius {:.6g} m, more than {}; make them larger",
                          expected, settings.radius, most_particles);
    return {};
  }
  Points points;
  if (shape.kind == SHAPE_MESH) {
    points = sample_mesh(*shape.mesh, settings.radius, settings.sampling, refusal);
  } else if (shape.kind == SHAPE_HULL) {
    points = sample_mesh(mesh_of_hull(shape.points), settings.radius, settings.sampling, refusal);
  } else {
    points = sample_primitive(shape, settings.radius, solid);
    if (points.empty()) {
      refusal = fmt::format("is too thin for particles of the radius {:.6g} m; make them {:.6g} m at most",
                            settings.radius, thickness(shape));
    }
  }
  if (!refusal.empty()) return {};
  for (Vector3& p : points) p = exact::add(shape.offset, exact::rotate(shape.rotation, p));
  return points;
}

const std::vector<std::vector<Vector3>>& ParticleSampler::of(const BodyDescription& body, std::string& refusal) {
  const auto [entry, is_new] = known_.try_emplace(key_of(body));
  if (!is_new) return entry->second;
  for (std::size_t i = 0; i < body.shapes.size() && refusal.empty(); ++i) {
    std::string flaw;
    entry->second.emplace_back();
    if (body.shapes[i].kind != SHAPE_PLANE) entry->second.back() = sample_particles(body.shapes[i], settings_, flaw);
    if (!flaw.empty()) refusal = fmt::format("shape {} {}", i, flaw);
  }
  return entry->second;
}

ParticleFit fit_of(const BodyDescription& body, const std::vector<std::vector<Vector3>>& particles, double radius) {
  ParticleFit fit;
  Vector3 center = {0, 0, 0};
  for (const Points& points : particles) {
    fit.count += points.size();
    for (const Vector3& p : points) center = exact::add(center, p);
  }
  if (fit.count == 0 || !(body.mass > 0)) return fit;
  const double mass = body.mass / static_cast<double>(fit.count);
  center = exact::scale(1 / static_cast<double>(fit.count), center);
  fit.center_error = exact::length(center);
  std::array<double, 6> inertia = {};  // xx, yy, zz, xy, xz, yz
  for (const Points& points : particles) {
    for (const Vector3& p : points) {
      const Vector3 d = exact::subtract(p, center);
      const double square = exact::dot(d, d), own = exact::sphere_inertia(mass, radius);
      for (unsigned k = 0; k < 3; ++k) inertia[k] += own + mass * (square - d[k] * d[k]);
      inertia[3] -= mass * d[0] * d[1];
      inertia[4] -= mass * d[0] * d[2];
      inertia[5] -= mass * d[1] * d[2];
    }
  }
  double error = 0, whole = 0;
  for (unsigned k = 0; k < 6; ++k) {
    const double is = k < 3 ? body.inertia[k] : 0, weight = k < 3 ? 1 : 2;
    error += weight * (inertia[k] - is) * (inertia[k] - is);
    whole += weight * is * is;
  }
  fit.inertia_error = exact::square_root(error / whole);
  return fit;
}

}  // namespace lockstep
