// Judges how two convex shapes meet, in double and independently of the twins: it knows nothing but support functions.
//
// The signed separation is the largest s(n) = min over a of n.x - max over b of n.x over all unit n: the distance of
// shapes that are apart, minus the depth of shapes that overlap. s has kinks where a face or an edge of a shape is met,
// so it is searched stratum by stratum: at the face normals and caps and where two great circles cross, along each
// great circle (the normals across an edge or an axis), and on the whole sphere.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "cpu_reference/shapes/manifold.hpp"

namespace lockstep::oracle {

using Eigen::Vector3d;

constexpr double two_pi = 6.283185307179586;

/// The faces and edges of the convex hull of a few points, by trying all planes through three of them.
struct Polyhedron {
  std::vector<Vector3d> points, normals, edges;
  std::vector<double> offsets;

  explicit Polyhedron(std::vector<Vector3d> corners = {}) : points(std::move(corners)) {
    double size = 0;
    for (const Vector3d& p : points) size = std::max(size, p.norm());
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t j = i + 1; j < points.size(); ++j)
        for (std::size_t k = j + 1; k < points.size(); ++k) {
          const Vector3d across = (points[j] - points[i]).cross(points[k] - points[i]);
          if (across.norm() > 1e-9 * size * size) {
            add_face(across.normalized(), points[i], size);
            add_face(-across.normalized(), points[i], size);
          }
        }
    for (std::size_t i = 0; i < normals.size(); ++i)
      for (std::size_t j = i + 1; j < normals.size(); ++j) {
        // an edge is where two faces share two points
        int shared = 0;
        for (const Vector3d& p : points)
          shared += normals[i].dot(p) > offsets[i] - 1e-6 * size && normals[j].dot(p) > offsets[j] - 1e-6 * size;
        if (shared >= 2) add_edge(normals[i].cross(normals[j]).normalized());
      }
  }

 private:
  void add_face(const Vector3d& n, const Vector3d& on, double size) {
    const double offset = n.dot(on);
    for (const Vector3d& p : points)
      if (n.dot(p) > offset + 1e-7 * size) return;
    for (const Vector3d& known : normals)
      if ((known - n).norm() < 1e-6) return;
    normals.push_back(n);
    offsets.push_back(offset);
  }
  void add_edge(const Vector3d& e) {
    for (const Vector3d& known : edges)
      if (known.cross(e).norm() < 1e-9) return;
    edges.push_back(e);
  }
};

/// A shape in the world.
struct Body {
  u32 kind;
  Vector3d center;
  Eigen::Matrix3d axes;  // columns: the axes of the shape
  Vector3d size;         // as Shape in kernels/types.h
  const Polyhedron* hull = nullptr;

  Vector3d support(const Vector3d& world) const {
    const Vector3d d = axes.transpose() * world;
    Vector3d p = Vector3d::Zero();
    const double across = std::hypot(d.x(), d.y());
    switch (kind) {
      case SHAPE_SPHERE: p = size.x() / d.norm() * d; break;
      case SHAPE_CAPSULE: p = size.x() / d.norm() * d + Vector3d(0, 0, d.z() > 0 ? size.y() : -size.y()); break;
      case SHAPE_CYLINDER:
        if (across > 0) p = size.x() / across * Vector3d(d.x(), d.y(), 0);
        p.z() = d.z() > 0 ? size.y() : -size.y();
        break;
      case SHAPE_BOX:
        for (int k = 0; k < 3; ++k) p[k] = d[k] > 0 ? size[k] : -size[k];
        break;
      case SHAPE_HULL: {
        double best = -1e300;
        for (const Vector3d& v : hull->points)
          if (d.dot(v) > best) best = d.dot(v), p = v;
        break;
      }
      default: break;  // a plane: its origin
    }
    return center + axes * p;
  }

  /// How far outside a point is (by planes, of polyhedra); negative inside.
  double outside(const Vector3d& world) const {
    const Vector3d p = axes.transpose() * (world - center);
    switch (kind) {
      case SHAPE_SPHERE: return p.norm() - size.x();
      case SHAPE_CAPSULE: return (p - Vector3d(0, 0, std::clamp(p.z(), -size.y(), size.y()))).norm() - size.x();
      case SHAPE_CYLINDER: return std::max(std::hypot(p.x(), p.y()) - size.x(), std::abs(p.z()) - size.y());
      case SHAPE_BOX: return (p.cwiseAbs() - size).maxCoeff();
      case SHAPE_PLANE: return p.z();
      default: {
        double most = -1e300;
        for (std::size_t i = 0; i < hull->normals.size(); ++i)
          most = std::max(most, hull->normals[i].dot(p) - hull->offsets[i]);
        return most;
      }
    }
  }

  /// Half the diagonal, about: what tolerances are measured by.
  double extent() const {
    switch (kind) {
      case SHAPE_SPHERE: return size.x();
      case SHAPE_CAPSULE: return size.x() + size.y();
      case SHAPE_CYLINDER: return std::hypot(size.x(), size.y());
      case SHAPE_PLANE: return 0;
      default: return size.norm();
    }
  }

  /// Isolated normals: faces and caps.
  std::vector<Vector3d> normals() const {
    std::vector<Vector3d> all;
    if (kind == SHAPE_CYLINDER) all = {axes.col(2), -axes.col(2)};
    if (kind == SHAPE_BOX)
      for (int k = 0; k < 3; ++k) all.insert(all.end(), {axes.col(k), -axes.col(k)});
    if (kind == SHAPE_HULL)
      for (const Vector3d& n : hull->normals) all.push_back(axes * n);
    return all;
  }

  /// Poles of the great circles on which s has a kink: edges and axes.
  std::vector<Vector3d> poles() const {
    if (kind == SHAPE_CAPSULE || kind == SHAPE_CYLINDER) return {axes.col(2)};
    if (kind == SHAPE_BOX) return {axes.col(0), axes.col(1), axes.col(2)};
    std::vector<Vector3d> all;
    if (kind == SHAPE_HULL)
      for (const Vector3d& e : hull->edges) all.push_back(axes * e);
    return all;
  }
};

template <class real>
Body body(u32 kind, const reference::WorldShape<real>& world_shape, const Polyhedron* hull = nullptr) {
  const auto vector = [](const reference::Vec3<real>& v) { return Vector3d(double(v.x), double(v.y), double(v.z)); };
  const auto& q = world_shape.rotation;
  return {kind, vector(world_shape.center),
          Eigen::Quaterniond(double(q.w), double(q.x), double(q.y), double(q.z)).normalized().toRotationMatrix(),
          vector(world_shape.size), hull};
}

/// s(n), n of length 1.
inline double separation_along(const Body& a, const Body& b, const Vector3d& n) {
  return n.dot(a.support(-n) - b.support(n));
}

struct Separation {
  double distance = -1e300;  // negative: minus the depth
  Vector3d normal = Vector3d::UnitZ();
};

namespace detail {

inline void try_normal(const Body& a, const Body& b, const Vector3d& n, Separation& best) {
  const double s = separation_along(a, b, n);
  if (s > best.distance) best = {s, n};
}

/// A point of the unit circle for each of `count` equal angles.
template <int count>
const std::array<Eigen::Vector2d, count>& around() {
  static const auto points = [] {
    std::array<Eigen::Vector2d, count> all;
    for (int i = 0; i < count; ++i) all[i] = {std::cos(two_pi * i / count), std::sin(two_pi * i / count)};
    return all;
  }();
  return points;
}

/// Directions that are far from each other: a Fibonacci lattice.
inline const std::vector<Vector3d>& lattice() {
  static const std::vector<Vector3d> directions = [] {
    constexpr int count = 600;
    std::vector<Vector3d> all;
    for (int i = 0; i < count; ++i) {
      const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z), angle = 2.399963229728653 * i;
      all.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
    return all;
  }();
  return directions;
}

/// Every local maximum along the great circle across `pole`, by golden sections.
inline void try_circle(const Body& a, const Body& b, const Vector3d& pole, Separation& best) {
  const Vector3d u = pole.unitOrthogonal(), v = pole.cross(u);
  const auto at = [&](double angle) -> Vector3d { return std::cos(angle) * u + std::sin(angle) * v; };
  const auto value = [&](double angle) { return separation_along(a, b, at(angle)); };
  constexpr int count = 120;
  std::vector<double> sampled(count);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d& x = around<count>()[std::size_t(i)];
    sampled[i] = separation_along(a, b, x.x() * u + x.y() * v);
  }
  const double most = *std::ranges::max_element(sampled), least = *std::ranges::min_element(sampled);
  for (int i = 0; i < count; ++i) {
    const double here = sampled[i];
    if (here < sampled[(i + 1) % count] || here < sampled[(i + count - 1) % count]) continue;
    if (std::max(here, most) < best.distance - 0.1 * (most - least)) continue;  // cannot become the best one
    double low = two_pi * (i - 1) / count, high = two_pi * (i + 1) / count;
    constexpr double golden = 0.6180339887498949;
    double x = high - golden * (high - low), y = low + golden * (high - low), at_x = value(x), at_y = value(y);
    for (int k = 0; k < 50; ++k) {
      if (at_x > at_y) {
        high = y, y = x, at_y = at_x, x = high - golden * (high - low), at_x = value(x);
      } else {
        low = x, x = y, at_x = at_y, y = low + golden * (high - low), at_y = value(y);
      }
    }
    try_normal(a, b, at(0.5 * (low + high)), best);
  }
}

/// Climbs from n by steps that are halved down to `least`: sure, if slow, where s is smooth.
inline Separation climb(const Body& a, const Body& b, Vector3d n, double step, double least) {
  double here = separation_along(a, b, n);
  for (int k = 0; k < 400 && step > least; ++k) {
    const Vector3d u = n.unitOrthogonal(), v = n.cross(u);
    Vector3d better = n;
    for (std::size_t i = 0; i < 8; ++i) {
      const Vector3d m = (n + step * (around<8>()[i].x() * u + around<8>()[i].y() * v)).normalized();
      const double s = separation_along(a, b, m);
      if (s > here) here = s, better = m;
    }
    if (better == n) step *= 0.5;
    n = better;
  }
  return {here, n};
}

inline bool has_only_flats(const Body& body) { return body.kind == SHAPE_BOX || body.kind == SHAPE_HULL; }

}  // namespace detail

/// Of two convex shapes; b may be a plane.
inline Separation separation(const Body& a, const Body& b) {
  Separation best;
  if (b.kind == SHAPE_PLANE) {
    detail::try_normal(a, b, b.axes.col(2), best);
    return best;
  }
  for (const Vector3d& n : a.normals()) detail::try_normal(a, b, -n, best);
  for (const Vector3d& n : b.normals()) detail::try_normal(a, b, n, best);
  const std::vector<Vector3d> poles_a = a.poles(), poles_b = b.poles();
  for (const Vector3d& p : poles_a)
    for (const Vector3d& q : poles_b) {
      const Vector3d across = p.cross(q);
      if (across.norm() < 1e-9) continue;
      detail::try_normal(a, b, across.normalized(), best);
      detail::try_normal(a, b, -across.normalized(), best);
    }
  // the Minkowski difference of polyhedra that overlap has no other faces than these
  if (detail::has_only_flats(a) && detail::has_only_flats(b) && best.distance < 0) return best;
  const Vector3d between = a.center - b.center;
  if (between.norm() > 0) detail::try_normal(a, b, between.normalized(), best);
  for (const Vector3d& p : poles_a) detail::try_circle(a, b, p, best);
  for (const Vector3d& p : poles_b) detail::try_circle(a, b, p, best);

  // the whole sphere, from the best of many directions
  constexpr std::size_t starts = 6;
  const double steepest = between.norm() + a.extent() + b.extent();  // |ds/dn| is no larger
  std::vector<std::pair<double, Vector3d>> sampled;
  for (const Vector3d& n : detail::lattice()) sampled.emplace_back(separation_along(a, b, n), n);
  std::ranges::sort(sampled, [](const auto& x, const auto& y) { return x.first > y.first; });
  std::vector<Vector3d> started = {best.normal};
  const auto take = [&](const Separation& top) {
    if (top.distance > best.distance) best = top;
  };
  take(detail::climb(a, b, best.normal, 1e-2, 1e-7));
  for (std::size_t i = 0; i < sampled.size() && started.size() < starts; ++i) {
    const Vector3d& n = sampled[i].second;
    if (std::ranges::any_of(started, [&](const Vector3d& m) { return m.dot(n) > 0.95; })) continue;
    started.push_back(n);
    // near its top, a climb that is still far below the best one is given up
    const Separation near = detail::climb(a, b, n, 0.1, 5e-3);
    if (near.distance > best.distance - 0.03 * steepest) take(detail::climb(a, b, near.normal, 5e-3, 1e-7));
  }
  return best;
}

}  // namespace lockstep::oracle
