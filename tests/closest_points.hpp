// How far two convex bodies are apart, in double and from their supports alone, for tests that must share nothing with
// the bounds and the narrow phase. Bodies have one shape at their centre of mass.
#pragma once

#include <algorithm>
#include <cmath>

#include "host/scene/scene.hpp"

namespace lockstep::test {

/// The body after it has moved and turned at a constant rate for a time t.
inline BodyDescription moved(BodyDescription body, double t) {
  for (unsigned k = 0; k < 3; ++k) body.position[k] += t * body.velocity[k];
  const Vector3& w = body.angular_velocity;
  const double rate = exact::length(w);
  if (rate == 0 || t == 0) return body;
  const double s = std::sin(rate * t / 2) / rate, c = std::cos(rate * t / 2);
  const Quaternion a = {s * w[0], s * w[1], s * w[2], c}, b = body.orientation;
  body.orientation = {
      a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
      a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
  return body;
}

/// The point of the body that is farthest in a direction of the world.
inline Vector3 support(const BodyDescription& body, const Vector3& direction) {
  const ShapeDescription& shape = body.shapes[0];
  const Quaternion& q = body.orientation;
  const Vector3 d = exact::rotate({-q[0], -q[1], -q[2], q[3]}, direction);
  const double length = exact::length(d), across = std::sqrt(d[0] * d[0] + d[1] * d[1]), r = shape.radius;
  const double end = d[2] < 0 ? -shape.half_length : shape.half_length;
  Vector3 p = {0, 0, 0};
  if (shape.kind == SHAPE_BOX) {
    for (unsigned k = 0; k < 3; ++k) p[k] = d[k] < 0 ? -shape.half_extents[k] : shape.half_extents[k];
  } else if (shape.kind == SHAPE_CYLINDER) {
    p = {across > 0 ? r * d[0] / across : 0, across > 0 ? r * d[1] / across : 0, end};
  } else {
    for (unsigned k = 0; k < 3; ++k) p[k] = length > 0 ? r * d[k] / length : 0;
    if (shape.kind == SHAPE_CAPSULE) p[2] += end;
  }
  const Vector3 rotated = exact::rotate(q, p);
  return {body.position[0] + rotated[0], body.position[1] + rotated[1], body.position[2] + rotated[2]};
}

/// Not less than the distance, and about as much: Frank and Wolfe's iteration on the difference of the two sets.
inline double distance_between(const BodyDescription& a, const BodyDescription& b) {
  Vector3 x = exact::subtract(a.position, b.position);
  for (int n = 0; n < 200; ++n) {
    const Vector3 back = {-x[0], -x[1], -x[2]};
    const Vector3 step = exact::subtract(exact::subtract(support(a, back), support(b, x)), x);
    const double gain = -exact::dot(x, step), square = exact::dot(step, step);
    if (gain <= 1e-12 || square == 0) break;
    const double share = std::min(gain / square, 1.0);
    for (unsigned k = 0; k < 3; ++k) x[k] += share * step[k];
  }
  return exact::length(x);
}

}  // namespace lockstep::test
