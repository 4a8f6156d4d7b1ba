#include "bench/overlap.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace lockstep::bench {

namespace {

using Eigen::Vector3d;

struct Plane {
  Vector3d normal, point;
};

struct Solid {
  Vector3d center;
  Eigen::Matrix3d axes;  // columns
  Vector3d half_extents;
  double radius;  // of a sphere, else 0

  double bounding_radius() const { return radius > 0 ? radius : half_extents.norm(); }
  /// Half the width along a unit vector.
  double half_width(const Vector3d& n) const {
    return radius > 0 ? radius : (axes.transpose() * n).cwiseAbs().dot(half_extents);
  }
  Vector3d closest_to(const Vector3d& x) const {
    const Vector3d local = axes.transpose() * (x - center);
    return center + axes * local.cwiseMax(-half_extents).cwiseMin(half_extents);
  }
};

Vector3d vector(const Vector3& v) { return {v[0], v[1], v[2]}; }

Eigen::Matrix3d rotation(const Quaternion& q) {
  return Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix();
}

/// The least overlap over all axes that can separate; negative where one does.
double depth_of(const Solid& a, const Solid& b) {
  const Vector3d offset = a.center - b.center;
  double depth = 1e300;
  const auto try_axis = [&](const Vector3d& axis) {
    const double length = axis.norm();
    if (length < 1e-6) return;
    const Vector3d n = axis / length;
    depth = std::min(depth, a.half_width(n) + b.half_width(n) - std::abs(n.dot(offset)));
  };
  if (a.radius > 0 && b.radius > 0) return a.radius + b.radius - offset.norm();
  if (a.radius > 0) try_axis(a.center - b.closest_to(a.center));
  if (b.radius > 0) try_axis(b.center - a.closest_to(b.center));
  for (int i = 0; i < 3; ++i) {
    if (a.radius == 0) try_axis(a.axes.col(i));
    if (b.radius == 0) try_axis(b.axes.col(i));
    for (int j = 0; j < 3 && a.radius == 0 && b.radius == 0; ++j) try_axis(a.axes.col(i).cross(b.axes.col(j)));
  }
  return depth;
}

}  // namespace

Overlap measure_overlap(const Scene& scene, const std::vector<BodyPose>& poses) {
  std::vector<Plane> planes;
  std::vector<Solid> solids;
  double largest = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const BodyDescription& body = scene.bodies[i];
    for (const ShapeDescription& shape : body.shapes) {
      if (shape.mask == 0) continue;
      if (shape.kind == SHAPE_PLANE) {  // on bodies without rotation here
        planes.push_back({rotation(shape.rotation).col(2), vector(body.position) + vector(shape.offset)});
      } else {
        const double radius = shape.kind == SHAPE_SPHERE ? shape.radius : 0;
        solids.push_back(
            {vector(poses[i].position), rotation(poses[i].orientation), vector(shape.half_extents), radius});
        largest = std::max(largest, solids.back().bounding_radius());
      }
    }
  }

  Overlap overlap;
  double sum = 0;
  const auto add = [&](double depth) {
    if (!(depth > 0)) return;
    ++overlap.pairs;
    overlap.deepest = std::max(overlap.deepest, depth);
    sum += depth;
  };
  const double cell = std::max(2 * largest, 1e-6);
  std::map<std::array<long, 3>, std::vector<const Solid*>> grid;
  for (const Solid& solid : solids) {
    for (const Plane& plane : planes)
      add(solid.half_width(plane.normal) - plane.normal.dot(solid.center - plane.point));
    const Vector3d& x = solid.center;
    const std::array<long, 3> home = {std::lround(x[0] / cell), std::lround(x[1] / cell), std::lround(x[2] / cell)};
    for (long n = 0; n < 27; ++n) {
      const auto found = grid.find({home[0] + n % 3 - 1, home[1] + n / 3 % 3 - 1, home[2] + n / 9 - 1});
      if (found == grid.end()) continue;
      for (const Solid* other : found->second) add(depth_of(solid, *other));
    }
    grid[home].push_back(&solid);
  }
  overlap.mean = overlap.pairs ? sum / overlap.pairs : 0;
  return overlap;
}

double farthest_moved(const Scene& scene, const std::vector<BodyPose>& poses) {
  double farthest = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].kind != BODY_DYNAMIC) continue;
    farthest = std::max(farthest, (vector(poses[i].position) - vector(scene.bodies[i].position)).norm());
  }
  return farthest;
}

double joint_separation(const Scene& scene, const std::vector<BodyPose>& poses) {
  const auto current_anchor = [&](u32 body, const Vector3& anchor) -> Vector3d {
    if (body == NONE) return vector(anchor);
    const BodyDescription& start = scene.bodies[body];
    const Vector3d arm = rotation(start.orientation).transpose() * (vector(anchor) - vector(start.position));
    return vector(poses[body].position) + rotation(poses[body].orientation) * arm;
  };
  double separation = 0;
  for (const JointDescription& joint : scene.joints) {
    if (joint.kind != JOINT_BALL) continue;
    const Vector3d parted = current_anchor(joint.body_a, joint.anchor_a) - current_anchor(joint.body_b, joint.anchor_b);
    separation = std::max(separation, parted.norm());
  }
  return separation;
}

}  // namespace lockstep::bench
