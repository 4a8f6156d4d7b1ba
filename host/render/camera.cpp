#include "host/render/camera.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace lockstep {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;

namespace {

// Margin that a framed region leaves around itself, as a share of half the picture.
constexpr double margin = 0.1;

double quantile(std::vector<double> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Vector3d median(std::span<const Extent* const> extents) {
  Vector3d middle;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Extent* extent : extents) values.push_back(extent->center[axis]);
    middle[axis] = quantile(std::move(values), 0.5);
  }
  return middle;
}

void extend(Region& region, const Extent& extent) {
  region.extend(extent.center - extent.half);
  region.extend(extent.center + extent.half);
}

}  // namespace

Matrix3d Camera::axes() const {
  const Vector3d into = (target - position).normalized();
  // straight up or down there is no other up than y
  const Vector3d up_world = std::abs(into.z()) > 0.9999 ? Vector3d::UnitY() : Vector3d::UnitZ();
  const Vector3d right = into.cross(up_world).normalized();
  Matrix3d axes;
  axes << right, right.cross(into), into;
  return axes;
}

double Camera::half_height() const { return std::tan(fov_deg * (EIGEN_PI / 360)); }

Matrix4d Camera::view_projection(double aspect, double nearest, double farthest) const {
  const Matrix3d a = axes();
  Matrix4d view = Matrix4d::Identity();
  view.block<1, 3>(0, 0) = a.col(0).transpose();
  view.block<1, 3>(1, 0) = a.col(1).transpose();
  view.block<1, 3>(2, 0) = -a.col(2).transpose();
  view.block<3, 1>(0, 3) = -view.block<3, 3>(0, 0) * position;
  Matrix4d projection = Matrix4d::Zero();
  projection(0, 0) = 1 / (half_height() * aspect);
  projection(1, 1) = 1 / half_height();
  projection(2, 2) = (nearest + farthest) / (nearest - farthest);
  projection(2, 3) = 2 * nearest * farthest / (nearest - farthest);
  projection(3, 2) = -1;
  return projection * view;
}

Vector3d Camera::project(const Vector3d& point, u32 width, u32 height) const {
  const Vector3d seen = axes().transpose() * (point - position);
  const double pixels = 0.5 * height / (half_height() * seen.z());
  return {0.5 * width + pixels * seen.x(), 0.5 * height - pixels * seen.y(), seen.z()};
}

Region region_of(std::span<const Extent> extents) {
  std::vector<const Extent*> movable;
  for (const Extent& extent : extents) {
    if (extent.movable) movable.push_back(&extent);
  }
  Region region;
  if (!movable.empty()) {
    const Vector3d middle = median(movable);
    std::vector<double> distances;
    for (const Extent* extent : movable) distances.push_back((extent->center - middle).norm() + extent->half.norm());
    const double usual = 3 * quantile(distances, 0.9);
    for (std::size_t i = 0; i < movable.size(); ++i) {
      if (distances[i] <= usual) extend(region, *movable[i]);
    }
  }
  const double size = region.isEmpty() ? 0 : region.diagonal().norm();
  const Region moving = region;
  for (const Extent& extent : extents) {
    if (extent.movable) continue;
    const bool fits = moving.isEmpty() || (extent.half.norm() < size && moving.exteriorDistance(extent.center) < size);
    if (fits) extend(region, extent);
  }
  return region;
}

Camera frame_region(const Region& region, double aspect) {
  Camera camera;
  if (region.isEmpty()) return camera;
  const Vector3d half = 0.5 * region.diagonal().cwiseMax(Vector3d::Constant(1e-3));
  camera.target = region.center();
  // across the longer side, from where the sun is
  const Vector3d from = (half.x() >= half.y() ? Vector3d(0.5, -1, 0.4) : Vector3d(-1, -0.6, 0.4)).normalized();
  camera.position = camera.target + from;
  const Matrix3d axes = camera.axes();
  const double up = camera.half_height() * (1 - margin), across = up * aspect;
  double distance = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d offset((corner & 1) != 0 ? half.x() : -half.x(), (corner & 2) != 0 ? half.y() : -half.y(),
                          (corner & 4) != 0 ? half.z() : -half.z());
    const Vector3d seen = axes.transpose() * offset;
    distance = std::max({distance, std::abs(seen.x()) / across - seen.z(), std::abs(seen.y()) / up - seen.z()});
  }
  camera.position = camera.target + distance * from;
  return camera;
}

}  // namespace lockstep
