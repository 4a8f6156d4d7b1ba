// All arithmetic between a scene file and the simulated state (contract rule 6): the same bits from every compiler at
// every optimisation level. Only + - * / and the square root are used, which IEEE 754 rounds correctly; no other
// function of the C library, no std:: distributions, no Eigen. In double; compile.cpp rounds once to the precision of
// the run.
#pragma once

#include <cstdint>

#include "include/lockstep/types.hpp"

namespace lockstep {

namespace exact {

constexpr double pi = 3.141592653589793;

/// Largest angle, in radians, that sine and cosine take.
constexpr double largest_angle = 1e4;

/// Within 1 ulp for |angle| <= largest_angle, in radians.
double sine(double angle);
double cosine(double angle);

/// The same in degrees, up to 1e6: exact at multiples of 90 degrees.
double sine_of_degrees(double angle);
double cosine_of_degrees(double angle);

double square_root(double x);

// Sums run left to right: x, y, z.
Vector3 add(const Vector3& a, const Vector3& b);
Vector3 subtract(const Vector3& a, const Vector3& b);
Vector3 scale(double s, const Vector3& a);
double dot(const Vector3& a, const Vector3& b);
Vector3 cross(const Vector3& a, const Vector3& b);
double length(const Vector3& a);
/// Divides by the length, which must not be zero; components are scaled first, so that no square overflows.
Vector3 unit(const Vector3& a);

double length(const Quaternion& q);
Quaternion unit(const Quaternion& q);
/// Hamilton product: first b, then a.
Quaternion multiply(const Quaternion& a, const Quaternion& b);
/// Body to world.
Vector3 rotate(const Quaternion& q, const Vector3& v);

/// The rotation about `axis`, which need not be unit, given sine and cosine of half the angle.
Quaternion rotation(const Vector3& axis, double sine_of_half, double cosine_of_half);
/// Rotations about the fixed axes x, then y, then z, in degrees (roll, pitch, yaw).
Quaternion rotation_from_euler_degrees(const Vector3& angles);
/// A rotation that takes the z axis to `direction`, which need not be unit: exact where the direction is along an axis,
/// the shortest rotation elsewhere.
Quaternion rotation_from_z_to(const Vector3& direction);

/// A rotation that takes the z axis to `z`, and the x axis to what of `x` is perpendicular to it; neither need be unit.
Quaternion rotation_to_frame(const Vector3& z, const Vector3& x);
/// Whether `a` and `b`, of any lengths but 0, are perpendicular, within 1e-6 rad.
bool perpendicular(const Vector3& a, const Vector3& b);

/// Of a solid sphere about its centre: 2/5 m r^2.
double sphere_inertia(double mass, double radius);
/// Of a solid sphere: 4/3 pi r^3 times the density.
double sphere_mass(double density, double radius);

/// A linear congruential generator (Knuth and Lewis: 1664525, 1013904223), one short sequence for each index. The upper
/// 24 bits become an exact decimal.
class LcgByIndex {
 public:
  explicit LcgByIndex(std::uint32_t index);
  /// In [0, 1).
  double next();
  /// In [-1, 1).
  double next_symmetric() { return 2 * next() - 1; }

 private:
  std::uint32_t state_;
};

}  // namespace exact
}  // namespace lockstep
