#include "host/scene/exact_math.hpp"

#if defined(__FAST_MATH__)
#error "scenes promise bits: build without fast-math"
#endif

#include <cmath>

namespace lockstep::exact {

namespace {

// x = quadrant * pi/2 + high + low, with high + low in about [-pi/4, pi/4] and `low` what rounding took from `high`.
struct Reduced {
  int quadrant;
  double high, low;
};

int nearest_integer(double x) { return static_cast<int>(x < 0 ? x - 0.5 : x + 0.5); }

// a - b and what rounding took from it (Knuth's two-sum).
void subtract_exactly(double a, double b, double& difference, double& error) {
  difference = a - b;
  const double b_virtual = a - difference;
  const double a_virtual = difference + b_virtual;
  error = (a - a_virtual) - (b - b_virtual);
}

// Cody and Waite: pi/2 in pieces. The first two have 33 bits, so that their product with a quadrant below 2^13 is
// exact.
Reduced reduce(double x) {
  constexpr double two_over_pi = 0x1.45f306dc9c883p-1;
  constexpr double half_pi_1 = 0x1.921fb544p+0, half_pi_2 = 0x1.0b4611a6p-34, half_pi_3 = 0x1.3198a2e037073p-69;
  const int n = nearest_integer(x * two_over_pi);
  const double first = x - n * half_pi_1;  // exact: both are multiples of the same power of two
  double high, low, second, second_low;
  subtract_exactly(first, n * half_pi_2, second, second_low);
  subtract_exactly(second, n * half_pi_3, high, low);
  return {n, high, second_low + low};
}

// Taylor's series of sine and cosine at high + low, |high| <= pi/4: the first term left out is below 2^-60 of the
// result. The leading terms are added last, so that little more than one rounding is seen.
double sine_series(double high, double low) {
  const double s = high * high;
  const double tail =
      s * (-1.0 / 6 +
           s * (1.0 / 120 + s * (-1.0 / 5040 + s * (1.0 / 362880 + s * (-1.0 / 39916800 +
                                                                        s * (1.0 / 6227020800.0 +
                                                                             s * (-1.0 / 1307674368000.0 +
                                                                                  s * (1.0 / 355687428096000.0))))))));
  // sin(high + low) = sin(high) + low cos(high)
  return high + (high * tail + low * (1 - 0.5 * s));
}

double cosine_series(double high, double low) {
  const double s = high * high;
  const double tail =
      s * s *
      (1.0 / 24 +
       s * (-1.0 / 720 +
            s * (1.0 / 40320 + s * (-1.0 / 3628800 + s * (1.0 / 479001600.0 + s * (-1.0 / 87178291200.0 +
                                                                                   s * (1.0 / 20922789888000.0)))))));
  const double half = 0.5 * s;
  const double lead = 1 - half;
  // cos(high + low) = cos(high) - low sin(high)
  return lead + (((1 - lead) - half) + (tail - low * high));
}

double sine_in_quadrant(const Reduced& r) {
  const int quadrant = r.quadrant & 3;
  const double value = (quadrant & 1) != 0 ? cosine_series(r.high, r.low) : sine_series(r.high, r.low);
  return quadrant >= 2 ? -value : value;
}

double cosine_in_quadrant(const Reduced& r) { return sine_in_quadrant({(r.quadrant & 3) + 1, r.high, r.low}); }

// Multiples of 90 degrees are taken off exactly, before the conversion to radians.
Reduced reduce_degrees(double angle) {
  const int n = nearest_integer(angle / 90);
  return {n, (angle - 90.0 * n) * (pi / 180), 0};
}

}  // namespace

double sine(double angle) { return sine_in_quadrant(reduce(angle)); }
double cosine(double angle) { return cosine_in_quadrant(reduce(angle)); }
double sine_of_degrees(double angle) { return sine_in_quadrant(reduce_degrees(angle)); }
double cosine_of_degrees(double angle) { return cosine_in_quadrant(reduce_degrees(angle)); }

// IEEE 754 demands the correctly rounded root, and std::sqrt compiles to it on every machine we build for.
double square_root(double x) { return std::sqrt(x); }

Vector3 add(const Vector3& a, const Vector3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vector3 subtract(const Vector3& a, const Vector3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vector3 scale(double s, const Vector3& a) { return {s * a[0], s * a[1], s * a[2]}; }
double dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Vector3& a) { return square_root(dot(a, a)); }

Vector3 unit(const Vector3& a) {
  double largest = 0;
  for (const double x : a) {
    const double size = x < 0 ? -x : x;
    largest = size > largest ? size : largest;
  }
  const Vector3 b = {a[0] / largest, a[1] / largest, a[2] / largest};
  const double l = length(b);
  return {b[0] / l, b[1] / l, b[2] / l};
}

double length(const Quaternion& q) { return square_root(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]); }

Quaternion unit(const Quaternion& q) {
  const double l = length(q);
  return {q[0] / l, q[1] / l, q[2] / l, q[3] / l};
}

Quaternion multiply(const Quaternion& a, const Quaternion& b) {
  return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
          a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

Vector3 rotate(const Quaternion& q, const Vector3& v) {
  const Vector3 u = {q[0], q[1], q[2]};
  return add(v, scale(2, cross(u, add(cross(u, v), scale(q[3], v)))));
}

Quaternion rotation(const Vector3& axis, double sine_of_half, double cosine_of_half) {
  const Vector3 u = unit(axis);
  return unit({sine_of_half * u[0], sine_of_half * u[1], sine_of_half * u[2], cosine_of_half});
}

Quaternion rotation_from_euler_degrees(const Vector3& angles) {
  Quaternion q = {0, 0, 0, 1};
  for (unsigned axis = 0; axis < 3; ++axis) {
    Vector3 direction = {0, 0, 0};
    direction[axis] = 1;
    const double half = 0.5 * angles[axis];
    q = multiply(rotation(direction, sine_of_degrees(half), cosine_of_degrees(half)), q);
  }
  return unit(q);
}

Quaternion rotation_from_z_to(const Vector3& direction) {
  const Vector3 n = unit(direction);
  // along an axis a third of a turn permutes the axes, and its quaternion is made of halves: no rounding
  if (n[1] == 0 && n[2] == 0) return n[0] > 0 ? Quaternion{0.5, 0.5, 0.5, 0.5} : Quaternion{0.5, -0.5, -0.5, 0.5};
  if (n[0] == 0 && n[2] == 0) return n[1] > 0 ? Quaternion{-0.5, -0.5, -0.5, 0.5} : Quaternion{0.5, 0.5, -0.5, 0.5};
  if (n[0] == 0 && n[1] == 0) return n[2] > 0 ? Quaternion{0, 0, 0, 1} : Quaternion{1, 0, 0, 0};
  // the shortest rotation, (z x n, 1 + z . n); below the horizon a half turn about x comes first, so that 1 - z . n
  // keeps its digits
  if (n[2] >= 0) return unit({-n[1], n[0], 0, 1 + n[2]});
  return multiply(unit({n[1], -n[0], 0, 1 - n[2]}), {1, 0, 0, 0});
}

Quaternion rotation_to_frame(const Vector3& z, const Vector3& x) {
  const Quaternion q = rotation_from_z_to(z);
  const Vector3 n = rotate({-q[0], -q[1], -q[2], q[3]}, unit(x));
  const double r = square_root(n[0] * n[0] + n[1] * n[1]);
  // half of the angle of n about z: its tangent is n_y / (r + n_x), or (r - n_x) / n_y where n_x is below 0
  const double side = n[1] < 0 ? -1 : 1;
  const Quaternion about_z = n[0] < 0 ? unit({0, 0, side * (r - n[0]), side * n[1]}) : unit({0, 0, n[1], r + n[0]});
  return multiply(q, about_z);
}

bool perpendicular(const Vector3& a, const Vector3& b) {
  const double cosine = dot(unit(a), unit(b));
  return cosine <= 1e-6 && cosine >= -1e-6;
}

double sphere_inertia(double mass, double radius) { return 0.4 * mass * radius * radius; }
double sphere_mass(double density, double radius) { return 4.0 / 3 * pi * (radius * radius * radius) * density; }

LcgByIndex::LcgByIndex(std::uint32_t index) : state_(index * 2654435761u + 12345u) {
  next();
  next();
}

double LcgByIndex::next() {
  state_ = state_ * 1664525u + 1013904223u;
  return (state_ >> 8) * (1.0 / 16777216);
}

}  // namespace lockstep::exact
