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

/// A shape in the world; `size` as Shape says, `hull` as that of ShapeInfo. `alone`: a facet is taken for
/// itself, not for a part of its surface, as bodies on their way to it ask for (facet.hpp). `displacement`
/// and `angular_displacement`: how far the centre moves within the step, m, and by what the shape rotates about it,
/// rad, but for what forces add, which is less than `margin`, m. `lag`: the share of the step that has passed, on the
/// mean of its sub-steps, when contacts are evaluated. `first_seam` and `seam_count`: which shapes cover edges of it.
template <class real>
struct WorldShape {
  Vec3<real> center;
  Quat<real> rotation;
  Vec3<real> size;
  u32 hull;
  bool alone = false;
  Vec3<real> displacement = {0, 0, 0}, angular_displacement = {0, 0, 0};
  real margin = 0, lag = 0;
  u32 first_seam = 0, seam_count = 0;
};

/// How far a point of shape a goes past one of shape b until contacts are evaluated, on the mean of the sub-steps. Of
/// what rolls these are points of the axis: the line on its side that touches goes with that.
template <class real>
Vec3<real> lagging_displacement(const WorldShape<real>& a, Vec3<real> at_a, const WorldShape<real>& b,
                                Vec3<real> at_b) {
  const Vec3<real> of_a = add3(a.displacement, cross3(a.angular_displacement, sub3(at_a, a.center)));
  const Vec3<real> of_b = add3(b.displacement, cross3(b.angular_displacement, sub3(at_b, b.center)));
  return scale3(a.lag, sub3(of_a, of_b));
}

/// How far the point where two lines cross, seen along n, moves along either while the first goes past the second:
/// a contact that stayed where it is at the start of the step would push what rolls over the other one from behind.
template <class real>
struct CrossingShift {
  real along_first, along_second;  // in parts of u and v
};
template <class real>
CrossingShift<real> crossing_shift(Vec3<real> u, Vec3<real> v, Vec3<real> n, Vec3<real> displacement) {
  const real across = dot3(cross3(u, v), n);
  return {-dot3(cross3(displacement, v), n) / across, -dot3(cross3(displacement, u), n) / across};
}

/// The tables that convex hulls, and shapes that lie flush, are read from (kernels/types.h).
template <class real>
struct HullTables {
  const Hull* hulls;
  const Vec4<real>* vertices;
  const Vec4<real>* planes;
  const HullFace* faces;
  const HullEdge* edges;
  const u32* corners;
  const Facet<real>* facets = nullptr;
  const FacetEdge<real>* facet_edges = nullptr;
  const Seam<real>* seams = nullptr;
};

template <class real>
Vec3<real> facet_vertex(const Facet<real>& facet, u32 i) {
  return vec3(facet.corners + 3 * i);
}

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

/// That of a meeting, where one of the two rolls.
template <class real>
u32 frame_on_round(u32 frame, real radius_a, real radius_b) {
  return frame == NORMAL_FIXED && radius_b > 0 && !(radius_a > 0) ? u32(NORMAL_FIXED_ON_B) : frame;
}

inline u32 flipped_frame(u32 frame) {
  switch (frame) {
    case NORMAL_OF_A: return NORMAL_OF_B;
    case NORMAL_OF_B: return NORMAL_OF_A;
    case NORMAL_FIXED: return NORMAL_FIXED_ON_B;
    case NORMAL_FIXED_ON_B: return NORMAL_FIXED;
    default: return frame;
  }
}

/// The same seen from the other side.
template <class real>
Manifold<real> flipped(Manifold<real> m) {
  m.normal = scale3(real(-1), m.normal);
  m.frame = flipped_frame(m.frame);
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
