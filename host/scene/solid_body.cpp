#include "host/scene/solid_body.hpp"

#include <algorithm>

#include "host/scene/mass_properties.hpp"

namespace lockstep {

namespace {

// Triggers weigh nothing.
std::vector<ShapeDescription> solid_shapes(const BodyDescription& body) {
  std::vector<ShapeDescription> solid;
  std::copy_if(body.shapes.begin(), body.shapes.end(), std::back_inserter(solid),
               [](const ShapeDescription& shape) { return !shape.trigger; });
  return solid;
}

// The file's frame has any origin and axes; a body's are its centre of mass and its principal axes.
void move_to_principal_axes(const MassProperties& solid, BodyDescription& body) {
  const PrincipalAxes axes = principal_axes(solid.inertia);
  body.inertia = axes.moments;
  const Quaternion back = {-axes.rotation[0], -axes.rotation[1], -axes.rotation[2], axes.rotation[3]};
  const bool is_rotated = axes.rotation != Quaternion{0, 0, 0, 1};
  if (solid.center != Vector3{0, 0, 0}) {
    body.position = exact::add(body.position, exact::rotate(body.orientation, solid.center));
    for (ShapeDescription& shape : body.shapes) shape.offset = exact::subtract(shape.offset, solid.center);
  }
  if (!is_rotated) return;
  body.orientation = exact::unit(exact::multiply(body.orientation, axes.rotation));
  for (ShapeDescription& shape : body.shapes) {
    shape.offset = exact::rotate(back, shape.offset);
    shape.rotation = exact::unit(exact::multiply(back, shape.rotation));
  }
}

}  // namespace

bool has_solid_shapes(const BodyDescription& body) { return !solid_shapes(body).empty(); }

void make_solid(BodyDescription& body, double density) {
  const MassProperties solid = mass_properties(solid_shapes(body), density);
  body.mass = solid.mass;
  move_to_principal_axes(solid, body);
}

void make_solid_of_mass(BodyDescription& body, double mass) {
  MassProperties solid = mass_properties(solid_shapes(body), 1);
  for (double& moment : solid.inertia) moment *= mass / solid.mass;
  body.mass = mass;
  move_to_principal_axes(solid, body);
}

void make_solid_of(BodyDescription& body, double mass, const Vector3& center, const std::array<double, 6>& inertia) {
  body.mass = mass;
  move_to_principal_axes({mass, center, inertia}, body);
}

}  // namespace lockstep
