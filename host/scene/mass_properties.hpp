// Mass, centre of mass and principal moments of bodies made of homogeneous shapes. In double and exact in the sense of
// exact_math.hpp: the same bits from every compiler.
#pragma once

#include "host/scene/scene.hpp"

namespace lockstep {

/// A homogeneous solid.
struct MassProperties {
  double mass = 0;             // kg
  Vector3 center = {0, 0, 0};  // of mass, m
  // Moments about the centre of mass, kg m^2: the matrix xx, yy, zz, xy, xz, yz (products negative, as in the inertia
  // matrix).
  std::array<double, 6> inertia = {};
};

/// Of one bounded shape in the frame of its body, kg/m^3. Shapes that overlap count twice where they do.
MassProperties mass_properties(const ShapeDescription& shape, double density);

/// Of all the shapes together.
MassProperties mass_properties(const std::vector<ShapeDescription>& shapes, double density);

/// One so many times as heavy.
MassProperties scaled(MassProperties solid, double factor);

/// The same solid where its frame stands so in another one.
MassProperties transformed(const MassProperties& own, const Vector3& offset, const Quaternion& rotation);

/// Of solids that are one, all in the same frame.
MassProperties together(const std::vector<MassProperties>& components);

/// The rotation from principal axes to the given ones, and the principal moments: Jacobi's method (Golub and Van Loan,
/// Matrix Computations, 8.5). A diagonal matrix is its own answer, with the identity.
struct PrincipalAxes {
  Quaternion rotation;
  Vector3 moments;
};
PrincipalAxes principal_axes(const std::array<double, 6>& inertia);

}  // namespace lockstep
