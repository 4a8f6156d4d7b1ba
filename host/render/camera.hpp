// Where a picture is taken from, and where a point of the world is in it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

#include "kernels/types.h"

namespace lockstep {

/// A pinhole camera that holds z upwards. SI units, world frame.
struct Camera {
  Eigen::Vector3d position = {6, -10, 5}, target = {0, 0, 0};
  double fov_deg = 35;  // of the height of the picture

  /// Unit vectors: to the right of the picture, up in it, and into it.
  Eigen::Matrix3d axes() const;

  /// The tangent of half the angle of view.
  double half_height() const;

  /// World to clip coordinates of OpenGL.
  Eigen::Matrix4d view_projection(double aspect, double nearest, double farthest) const;

  /// Where a point is in a picture of so many pixels: x to the right, y down, from the top left corner; z is its
  /// distance along the line of sight (m, negative behind the camera).
  Eigen::Vector3d project(const Eigen::Vector3d& point, u32 width, u32 height) const;
};

/// What a picture is to show.
using Region = Eigen::AlignedBox3d;

/// The box around something that moves, or stands, in a scene.
struct Extent {
  Eigen::Vector3d center, half;
  bool movable;
};

/// The box around the bodies that move, without the few that flew off; those that do not move belong to it where they
/// are about as large, and near. Empty where there is nothing.
Region region_of(std::span<const Extent> extents);

/// Looks at all of a region from a little above, across its longer side.
Camera frame_region(const Region& region, double aspect);

}  // namespace lockstep
