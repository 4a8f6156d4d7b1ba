#include "host/scene/mass_properties.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "host/scene/hull.hpp"

namespace lockstep {

namespace {

// A symmetric 3 x 3 matrix by rows.
using Matrix = std::array<Vector3, 3>;

Matrix matrix(const std::array<double, 6>& m) { return {{{m[0], m[3], m[4]}, {m[3], m[1], m[5]}, {m[4], m[5], m[2]}}}; }
std::array<double, 6> entries(const Matrix& m) { return {m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2]}; }

// R D R^T, with the columns of R the axes of the rotation.
std::array<double, 6> rotated(const std::array<double, 6>& moments, const Quaternion& rotation) {
  if (rotation == Quaternion{0, 0, 0, 1}) return moments;
  const Matrix axes = {
      {exact::rotate(rotation, {1, 0, 0}), exact::rotate(rotation, {0, 1, 0}), exact::rotate(rotation, {0, 0, 1})}};
  const Matrix m = matrix(moments);
  Matrix result = {};
  for (unsigned i = 0; i < 3; ++i) {
    for (unsigned j = 0; j < 3; ++j) {
      double sum = 0;
      for (unsigned k = 0; k < 3; ++k) {
        for (unsigned l = 0; l < 3; ++l) sum += axes[k][i] * m[k][l] * axes[l][j];
      }
      result[i][j] = sum;
    }
  }
  return entries(result);
}

// What a mass at `d` adds to the moments about the origin (theorem of parallel axes).
std::array<double, 6> of_point(double mass, const Vector3& d) {
  const double square = exact::dot(d, d);
  return {mass * (square - d[0] * d[0]), mass * (square - d[1] * d[1]), mass * (square - d[2] * d[2]),
          -mass * d[0] * d[1],           -mass * d[0] * d[2],           -mass * d[1] * d[2]};
}

ConvexHull hull_of(const std::vector<Vector3>& points) {
  std::string refusal;
  return convex_hull(points, refusal);
}

// Of a polyhedron: the integrals of its volume about its own centre.
MassProperties of_volume(const VolumeMoments& m, double density) {
  MassProperties own;
  if (!(m.volume > 0)) return own;
  own.mass = m.volume * density;
  own.center = exact::scale(1 / m.volume, m.first);
  std::array<double, 6> second = {};
  const unsigned row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
  for (unsigned k = 0; k < 6; ++k)
    second[k] = density * (m.second[k] - m.volume * own.center[row[k]] * own.center[column[k]]);
  own.inertia = {
      second[1] + second[2], second[0] + second[2], second[0] + second[1], -second[3], -second[4], -second[5]};
  return own;
}

// In the frame of the shape.
MassProperties own_properties(const ShapeDescription& shape, double density) {
  const double r = shape.radius, l = shape.half_length;
  const double ball = exact::sphere_mass(density, r), tube = exact::pi * r * r * 2 * l * density;
  MassProperties own;
  switch (shape.kind) {
    case SHAPE_SPHERE: {
      own.mass = ball;
      const double moment = exact::sphere_inertia(own.mass, r);
      own.inertia = {moment, moment, moment, 0, 0, 0};
      break;
    }
    case SHAPE_CAPSULE: {
      own.mass = ball + tube;
      const double across = tube * (r * r / 4 + l * l / 3) + ball * (0.4 * r * r + l * l + 0.75 * r * l);
      own.inertia = {across, across, 0.5 * tube * r * r + 0.4 * ball * r * r, 0, 0, 0};
      break;
    }
    case SHAPE_CYLINDER: {
      own.mass = tube;
      const double across = tube * (r * r / 4 + l * l / 3);
      own.inertia = {across, across, 0.5 * tube * r * r, 0, 0, 0};
      break;
    }
    case SHAPE_BOX: {
      const Vector3& h = shape.half_extents;
      own.mass = 8 * h[0] * h[1] * h[2] * density;
      for (unsigned i = 0; i < 3; ++i) {
        const double a = h[(i + 1) % 3], b = h[(i + 2) % 3];
        own.inertia[i] = own.mass / 3 * (a * a + b * b);
      }
      break;
    }
    case SHAPE_HULL: own = of_volume(volume_moments(hull_of(shape.points)), density); break;
    case SHAPE_MESH: own = of_volume(volume_moments(*shape.mesh), density); break;
    default: break;  // a plane has no mass
  }
  return own;
}

}  // namespace

MassProperties scaled(MassProperties solid, double factor) {
  solid.mass *= factor;
  for (double& moment : solid.inertia) moment *= factor;
  return solid;
}

MassProperties transformed(const MassProperties& own, const Vector3& offset, const Quaternion& rotation) {
  return {own.mass, exact::add(offset, exact::rotate(rotation, own.center)), rotated(own.inertia, rotation)};
}

MassProperties together(const std::vector<MassProperties>& components) {
  if (components.size() == 1) return components[0];
  MassProperties whole;
  for (const MassProperties& component : components) {
    whole.mass += component.mass;
    whole.center = exact::add(whole.center, exact::scale(component.mass, component.center));
  }
  if (whole.mass > 0) whole.center = exact::scale(1 / whole.mass, whole.center);
  for (const MassProperties& component : components) {
    const std::array<double, 6> more = of_point(component.mass, exact::subtract(component.center, whole.center));
    for (unsigned i = 0; i < 6; ++i) whole.inertia[i] += component.inertia[i] + more[i];
  }
  return whole;
}

MassProperties mass_properties(const ShapeDescription& shape, double density) {
  return transformed(own_properties(shape, density), shape.offset, shape.rotation);
}

MassProperties mass_properties(const std::vector<ShapeDescription>& shapes, double density) {
  std::vector<MassProperties> components;
  for (const ShapeDescription& shape : shapes) components.push_back(mass_properties(shape, density));
  return together(components);
}

PrincipalAxes principal_axes(const std::array<double, 6>& inertia) {
  Matrix m = matrix(inertia);
  Quaternion rotation = {0, 0, 0, 1};
  for (int sweep = 0; sweep < 30; ++sweep) {
    const double off = std::abs(m[0][1]) + std::abs(m[0][2]) + std::abs(m[1][2]);
    if (off <= 1e-15 * (std::abs(m[0][0]) + std::abs(m[1][1]) + std::abs(m[2][2]))) break;
    for (const auto& [p, q] : {std::pair{0u, 1u}, {0u, 2u}, {1u, 2u}}) {
      if (m[p][q] == 0) continue;
      // the tangent of the smaller angle that makes m[p][q] zero
      const double tau = (m[q][q] - m[p][p]) / (2 * m[p][q]);
      const double t = (tau >= 0 ? 1.0 : -1.0) / (std::abs(tau) + exact::square_root(1 + tau * tau));
      const double c = 1 / exact::square_root(1 + t * t), s = t * c;
      for (unsigned k = 0; k < 3; ++k) {
        const double a = m[k][p], b = m[k][q];
        m[k][p] = c * a - s * b;
        m[k][q] = s * a + c * b;
      }
      for (unsigned k = 0; k < 3; ++k) {
        const double a = m[p][k], b = m[q][k];
        m[p][k] = c * a - s * b;
        m[q][k] = s * a + c * b;
      }
      // the new axes are the old ones turned about the third: e_p' = c e_p - s e_q
      const double cosine_of_half = exact::square_root(0.5 * (1 + c)), sine_of_half = 0.5 * s / cosine_of_half;
      Quaternion jacobi_rotation = {0, 0, 0, cosine_of_half};
      const unsigned axis = 3 - p - q;
      jacobi_rotation[axis] = axis == 1 ? sine_of_half : -sine_of_half;
      rotation = exact::unit(exact::multiply(rotation, jacobi_rotation));
    }
  }
  return {rotation, {m[0][0], m[1][1], m[2][2]}};
}

}  // namespace lockstep
