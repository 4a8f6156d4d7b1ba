// Worlds of all shapes that can be asked about, and their exact distances in double.
#pragma once

#include <cmath>

#include "tests/event_worlds.hpp"

namespace lockstep::test {

/// Distance of a point from the surface, negative inside; in the frame of the shape.
inline double exact_distance(const ShapeDescription& s, const Vector3& p) {
  const auto outside = [](double a, double b) {
    return std::hypot(std::max(a, 0.0), std::max(b, 0.0)) + std::min(std::max(a, b), 0.0);
  };
  const double across = std::hypot(p[0], p[1]);
  switch (s.kind) {
    case SHAPE_SPHERE: return std::hypot(across, p[2]) - s.radius;
    case SHAPE_CAPSULE: return std::hypot(across, std::max(std::abs(p[2]) - s.half_length, 0.0)) - s.radius;
    case SHAPE_CYLINDER: return outside(across - s.radius, std::abs(p[2]) - s.half_length);
    case SHAPE_PLANE: return p[2];
    default: break;
  }
  const Vector3& h = s.half_extents;
  const double x = std::abs(p[0]) - h[0], y = std::abs(p[1]) - h[1], z = std::abs(p[2]) - h[2];
  return std::hypot(std::max(x, 0.0), outside(y, z) > 0 ? outside(y, z) : 0.0) +
         std::min(std::max(x, std::max(y, z)), 0.0);
}

/// Of a point of the world from the one shape of a body that is not moved.
inline double exact_distance(const BodyDescription& body, const Vector3& point) {
  const Quaternion& q = body.orientation;
  const ShapeDescription& shape = body.shapes[0];
  const Vector3 local =
      exact::subtract(exact::rotate({-q[0], -q[1], -q[2], q[3]}, exact::subtract(point, body.position)), shape.offset);
  const Quaternion& r = shape.rotation;
  return exact_distance(shape, exact::rotate({-r[0], -r[1], -r[2], r[3]}, local));
}

/// A body of each kind in turn, anywhere within `size`.
inline BodyDescription any_body(Random& random, u32 n, double size) {
  const Vector3 position = random.vector(size);
  const Quaternion rotation = random.rotation();
  switch (n % 4) {
    case 0: return sphere_body(position, random.between(0.1, 0.5));
    case 1: return round_body(SHAPE_CAPSULE, position, random.between(0.1, 0.3), random.between(0.1, 0.5), rotation);
    case 2: return box_body(position, {random.between(0.1, 0.5), random.between(0.1, 0.5), 0.2}, rotation);
    default: return round_body(SHAPE_CYLINDER, position, random.between(0.1, 0.4), random.between(0.1, 0.4), rotation);
  }
}

/// Room for so many rays and volumes, and all shapes to ask about.
template <class real>
InitialState<real> make_query_worlds(const std::vector<std::vector<BodyDescription>>& worlds, u32 rays, u32 volumes) {
  InitialState<real> state = make_event_worlds<real>(worlds, 1024);
  state.features = with(with(with(state.features, Feature::queries), Feature::boxes), Feature::manifolds);
  state.sizes.rays = rays;
  state.sizes.volumes = volumes;
  state.sizes.overlaps = 16 * volumes;
  state.params.overlap_capacity = state.sizes.overlaps;
  resize(state.buffers, state.sizes, state.features);
  return state;
}

}  // namespace lockstep::test
