#include "host/world/angular_velocity.hpp"

namespace lockstep {

namespace {

// The angle in [0, pi/2] of a sine and a cosine that are not negative: phi + sin(angle - phi) converges cubically, and
// the difference needs no arcsine.
double angle_of(double sine, double cosine) {
  double angle = sine;
  for (int i = 0; i < 5; ++i) angle += sine * exact::cosine(angle) - cosine * exact::sine(angle);
  return angle;
}

}  // namespace

Vector3 angular_velocity_between(const Quaternion& from, const Quaternion& to, double duration) {
  const Quaternion back = {-from[0], -from[1], -from[2], from[3]};
  Quaternion rotation = exact::multiply(to, back);
  if (rotation[3] < 0)
    for (double& x : rotation) x = -x;
  const Vector3 axis = {rotation[0], rotation[1], rotation[2]};
  const double sine = exact::length(axis), scale = exact::length(rotation);
  if (sine == 0) return {0, 0, 0};
  return exact::scale(2 / duration * angle_of(sine / scale, rotation[3] / scale) / sine, axis);
}

}  // namespace lockstep
