// What a manifold must be, held against the oracle (tests/shapes/oracle.hpp).
#pragma once

#include <gtest/gtest.h>

#include <array>

#include "tests/shapes/oracle.hpp"

namespace lockstep::oracle {

using Polygon = std::vector<Eigen::Vector2d>;

/// What a polygon has on the inner side of n.x <= offset.
inline Polygon clipped(const Polygon& polygon, const Eigen::Vector2d& n, double offset) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double at_p = n.dot(p) - offset, at_q = n.dot(q) - offset;
    if (at_p <= 0) kept.push_back(p);
    if ((at_p <= 0) != (at_q <= 0)) kept.push_back(p + at_p / (at_p - at_q) * (q - p));
  }
  return kept;
}

/// The largest area that four of these points enclose: over all diagonals, the farthest point on either side.
inline double best_area_of_four(const Polygon& points) {
  double best = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      const Eigen::Vector2d d = points[j] - points[i];
      double left = 0, right = 0;
      for (const Eigen::Vector2d& p : points) {
        const Eigen::Vector2d e = p - points[i];
        const double height = d.x() * e.y() - d.y() * e.x();
        left = std::max(left, height), right = std::max(right, -height);
      }
      best = std::max(best, 0.5 * (left + right));
    }
  return best;
}

inline double diameter(const Polygon& points) {
  double most = 0;
  for (const auto& p : points)
    for (const auto& q : points) most = std::max(most, (p - q).norm());
  return most;
}

/// The region in which both shapes are cut by the plane n.x = height, in coordinates along u and v: the support of a
/// cut is the least, over lambda, of the support of the shape along d + lambda n, less lambda times the height.
inline Polygon contact_patch(const Body& a, const Body& b, const Vector3d& n, double height, const Vector3d& u,
                             const Vector3d& v) {
  const double far = 4 * a.extent() + (b.kind == SHAPE_PLANE ? 0 : 4 * b.extent());
  const Eigen::Vector2d middle(u.dot(a.center), v.dot(a.center));
  Polygon patch;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
    patch.push_back(middle + far * Eigen::Vector2d(x, y));
  for (const Body* shape : {&a, &b}) {
    if (shape->kind == SHAPE_PLANE) continue;
    for (int i = 0; i < 256; ++i) {
      const double angle = turn * (i + 0.25) / 256;
      const Vector3d d = std::cos(angle) * u + std::sin(angle) * v;
      const auto value = [&](double lambda) {
        const Vector3d direction = d + lambda * n;
        return direction.dot(shape->support(direction)) - lambda * height;
      };
      double low = -1e4, high = 1e4;  // convex in lambda
      for (int k = 0; k < 70; ++k) {
        const double x = low + (high - low) / 3, y = high - (high - low) / 3;
        (value(x) < value(y) ? high : low) = value(x) < value(y) ? y : x;
      }
      patch = clipped(patch, {std::cos(angle), std::sin(angle)}, value(0.5 * (low + high)));
    }
  }
  return patch;
}

struct Tolerances {
  double depth = 1e-5, inside = 1e-4, normal = 1e-4;  // of the size of the larger shape
  bool patch = true;                   // compare the area with that of the contact patch: slow
  bool apart = true;                   // the gap of shapes that are apart is their distance, not just a bound of it
};

/// What a check found, for statistics.
struct Verdict {
  double separation = 0, depth_error = 0;
  double patch_area = 0, area_share = 1;  // of the best area that four points of a flat patch can have
};

/// Fails where the manifold is not what the oracle sees. Gaps above `limit` may be left out.
template <class real>
Verdict check_manifold(const Body& a, const Body& b, const reference::Manifold<real>& m, double limit,
                       const Tolerances& tolerances = {}) {
  Verdict verdict;
  const Separation truth = separation(a, b);
  verdict.separation = truth.distance;
  const double size = std::max(a.extent(), b.extent()), tolerance = tolerances.depth * size;
  if (m.count == 0) {
    // edges beside each other may have no point in common over any face
    EXPECT_GT(truth.distance, tolerances.apart ? limit - tolerance : tolerance) << "no manifold";
    return verdict;
  }
  EXPECT_LE(m.count, 4u);
  const auto vector = [](const reference::Vec3<real>& p) { return Vector3d(double(p.x), double(p.y), double(p.z)); };
  const Vector3d n = vector(m.normal);
  EXPECT_NEAR(n.norm(), 1, 1e-5);
  const bool bound = !tolerances.apart && truth.distance > 0;
  const double along = separation_along(a, b, n.normalized());
  EXPECT_GT(along, bound ? -tolerance : along - 1) << "apart, and not seen to be";
  // no direction separates the shapes better, but for what a slightly turned normal loses at the far end of a flat
  // contact; this is the sense of the normal, too
  EXPECT_NEAR(along, truth.distance, bound ? 1 : tolerances.normal * size) << "the normal is not the best one";

  double deepest = 1e300;
  std::vector<Vector3d> points;
  for (u32 k = 0; k < m.count; ++k) {
    const Vector3d pa = vector(m.points[k].anchor_a) - double(m.radius_a) * n;
    const Vector3d pb = vector(m.points[k].anchor_b) + double(m.radius_b) * n;
    const double gap = n.dot(pa - pb);
    deepest = std::min(deepest, gap);
    EXPECT_LT(a.outside(pa), tolerances.inside * size) << "point " << k << " of " << m.count << " is not in a";
    // the anchor on a plane may be any point of it
    if (b.kind != SHAPE_PLANE) {
      EXPECT_LT(b.outside(pb), tolerances.inside * size) << "point " << k << " of " << m.count << " is not in b";
    }
    points.push_back(b.kind == SHAPE_PLANE ? pa : Vector3d(0.5 * (pa + pb)));
    for (u32 j = 0; j < k; ++j) EXPECT_NE(m.points[j].feature, m.points[k].feature) << "features must differ";
  }
  if (bound) {
    EXPECT_GT(deepest, -tolerance);
    EXPECT_LT(deepest, truth.distance + tolerance);
    return verdict;
  }
  verdict.depth_error = std::abs(deepest - truth.distance);
  EXPECT_LE(verdict.depth_error, tolerance) << "deepest point " << deepest << ", oracle " << truth.distance;

  // a flat patch: shapes that overlap by little, and yet over a wide area
  if (!tolerances.patch || truth.distance > -1e-6 * size || truth.distance < -1e-3 * size) return verdict;
  const Vector3d axis = n.normalized(), u = axis.unitOrthogonal(), v = axis.cross(u);
  const double height = 0.5 * (axis.dot(a.support(-axis)) + axis.dot(b.support(axis)));
  const Polygon patch = contact_patch(a, b, axis, height, u, v);
  Polygon spanned;
  for (const Vector3d& p : points) spanned.emplace_back(u.dot(p), v.dot(p));
  verdict.patch_area = best_area_of_four(patch);
  const double smaller = b.kind == SHAPE_PLANE ? a.extent() : std::min(a.extent(), b.extent());
  if (verdict.patch_area > 0.02 * smaller * smaller && -truth.distance < 1e-4 * size) {
    verdict.area_share = best_area_of_four(spanned) / verdict.patch_area;
    EXPECT_GE(m.count, 3u) << "a wide patch";
    EXPECT_GE(verdict.area_share, 0.9) << "the points enclose too little of the patch";
  } else if (diameter(patch) > 0.3 * smaller && -truth.distance < 1e-4 * size) {
    EXPECT_GE(m.count, 2u) << "a long patch";
    EXPECT_GE(diameter(spanned), 0.8 * diameter(patch)) << "the points lie too near each other";
  }
  return verdict;
}

}  // namespace lockstep::oracle
