// Where shapes stand, and how two of them meet. kernels/shapes/manifold.h is the twin.
#pragma once

#include <utility>

#include "cpu_reference/math.hpp"

namespace lockstep::reference {

/// A body's frame in the world.
template <class real>
struct Pose {
  Vec3<real> position;
  Quat<real> orientation;
};

/// A shape in the world; `size` as Shape says, `hull` an index into the tables of hulls. `alone`: a facet is taken for
/// itself, not for a part of its surface, as bodies on their way to it ask for (facet.hpp). `displacement`
/// and `angular_displacement`: how far the centre moves within the step, m, and by what the shape rotates about it,
/// rad, but for what forces add, which is less than `margin`, m. `first_seam` and `seam_count`: which shapes cover
/// edges of it.
template <class real>
struct WorldShape {
  Vec3<real> center;
  Quat<real> rotation;
  Vec3<real> size;
  u32 hull;
  bool alone = false;
  Vec3<real> displacement = {0, 0, 0}, angular_displacement = {0, 0, 0};
  real margin = 0;
  u32 first_seam = 0, seam_count = 0;
};

/// The tables that convex hulls, and shapes that lie flush, are read from (kernels/types.h).
template <class real>
struct HullTables {
  const Hull* hulls;
  const Vec4<real>* vertices;
  const Vec4<real>* planes;
  const HullFace* faces;
  const HullEdge* edges;
  const u32* corners;
  const Seam<real>* seams = nullptr;
};

/// One pair of closest points: the surface of a round shape is its radius away from the anchor, along the normal.
template <class real>
struct ManifoldPoint {
  Vec3<real> anchor_a, anchor_b;
  u32 feature;  // stable name of the point within its pair of shapes
};

/// How two shapes meet: points of one normal, which points from b to a. The gap at a point is
/// n . (anchor_a - anchor_b) - radius_a - radius_b, negative where the shapes overlap.
template <class real>
struct Manifold {
  Vec3<real> normal;
  u32 frame;  // NormalFrame; a point on a face may have any point of the face's plane as that side's anchor
  real radius_a, radius_b;
  u32 count;  // of points, at most 4; 0 where the shapes are farther apart than was asked for
  ManifoldPoint<real> points[4];
};

template <class real>
real gap_at(const Manifold<real>& m, u32 k) {
  return dot3(m.normal, sub3(m.points[k].anchor_a, m.points[k].anchor_b)) - m.radius_a - m.radius_b;
}

/// The same seen from the other side.
template <class real>
Manifold<real> flipped(Manifold<real> m) {
  m.normal = scale3(real(-1), m.normal);
  m.frame = m.frame == NORMAL_OF_A ? u32(NORMAL_OF_B) : m.frame == NORMAL_OF_B ? u32(NORMAL_OF_A) : m.frame;
  std::swap(m.radius_a, m.radius_b);
  for (u32 k = 0; k < m.count; ++k) std::swap(m.points[k].anchor_a, m.points[k].anchor_b);
  return m;
}

template <class real>
Manifold<real> no_manifold() {
  return {};
}

/// A manifold of one point.
template <class real>
Manifold<real> manifold_at(Vec3<real> normal, u32 frame, Vec3<real> anchor_a, real radius_a, Vec3<real> anchor_b,
                           real radius_b, u32 feature) {
  Manifold<real> m = {};
  m.normal = normal;
  m.frame = frame;
  m.radius_a = radius_a;
  m.radius_b = radius_b;
  m.count = 1;
  m.points[0] = {anchor_a, anchor_b, feature};
  return m;
}

template <class real>
Pose<real> make_pose(Vec4<real> position, Vec4<real> orientation) {
  return {{position.x, position.y, position.z}, quat(orientation)};
}

/// The origin of the shape's frame in the world: of a shape at the centre of mass exactly the body's position.
template <class real>
Vec3<real> shape_center(const Pose<real>& pose, const Shape<real>& shape) {
  return add3(pose.position, rotate3(pose.orientation, vec3(shape.offset)));
}

template <class real>
Quat<real> shape_rotation(const Pose<real>& pose, const Shape<real>& shape) {
  return multiply4(pose.orientation,
                   Quat<real>{shape.rotation[0], shape.rotation[1], shape.rotation[2], shape.rotation[3]});
}

}  // namespace lockstep::reference
