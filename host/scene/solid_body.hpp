// Bodies whose mass, centre and axes follow from their shapes.
#pragma once

#include "host/scene/scene.hpp"

namespace lockstep {

/// Whether it has any shape that has a mass: triggers have none.
bool has_solid_shapes(const BodyDescription& body);

/// Gives a dynamic body the mass and the moments of its shapes, kg/m^3, and moves its frame, whose origin and axes may
/// be any, to the centre of mass and the principal axes; the shapes stay where they are in the world. Shapes that
/// overlap count twice where they do. The body must have solid shapes, all of them bounded.
void make_solid(BodyDescription& body, double density);

/// The same with the density that makes it so heavy, kg.
void make_solid_of_mass(BodyDescription& body, double mass);

/// The same where mass, centre (m) and inertia matrix about it (xx, yy, zz, xy, xz, yz; kg m^2) are given, in the frame
/// of the shapes.
void make_solid_of(BodyDescription& body, double mass, const Vector3& center, const std::array<double, 6>& inertia);

}  // namespace lockstep
