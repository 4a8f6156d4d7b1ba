// What a manifold must be, held against the oracle (tests/shapes/oracle.hpp).
#pragma once

#include <limits>
#include <sstream>
#include <string>

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

/// The same of four that have p among them.
inline double best_area_of_four_with(const Eigen::Vector2d& p, const Polygon& points) {
  double best = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = 0; j < points.size(); ++j) {
      const Eigen::Vector2d d = points[j] - points[i], e = p - points[i];
      const double height = d.x() * e.y() - d.y() * e.x();
      // p to the left of the diagonal, or an end of it
      double left = i == j ? 0 : std::max(0.0, height), right = 0;
      const Eigen::Vector2d from = i == j ? p : points[i], along = points[j] - from;
      for (const Eigen::Vector2d& q : points) {
        const double at_q = along.x() * (q - from).y() - along.y() * (q - from).x();
        if (i == j) left = std::max(left, at_q);
        right = std::max(right, -at_q);
      }
      best = std::max(best, 0.5 * (left + right));
    }
  return best;
}

inline double area(const Polygon& points) {
  double twice = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d &p = points[i], &q = points[(i + 1) % points.size()];
    twice += p.x() * q.y() - p.y() * q.x();
  }
  return 0.5 * std::abs(twice);
}

inline double diameter(const Polygon& points) {
  double most = 0;
  for (const auto& p : points)
    for (const auto& q : points) most = std::max(most, (p - q).norm());
  return most;
}

/// Between the two closest parallel lines that hold a convex polygon: one of them is along a side.
inline double width(const Polygon& points) {
  double least = 1e300;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d &p = points[i], side = points[(i + 1) % points.size()] - p;
    if (side.norm() < 1e-9) continue;
    double most = 0;
    for (const auto& q : points) most = std::max(most, std::abs(side.x() * (q - p).y() - side.y() * (q - p).x()));
    least = std::min(least, most / side.norm());
  }
  return least < 1e300 ? least : 0;
}

/// The region in which both shapes are cut by the plane n.x = height, in coordinates along u and v: the support of a
/// cut is the least, over lambda, of the support of the shape along d + lambda n, less lambda times the height.
/// Straight sides are those of edges and axes: their directions are among those tried.
inline Polygon contact_patch(const Body& a, const Body& b, const Vector3d& n, double height, const Vector3d& u,
                             const Vector3d& v) {
  const double far = 4 * a.extent() + (b.kind == SHAPE_PLANE ? 0 : 4 * b.extent());
  const Eigen::Vector2d middle(u.dot(a.center), v.dot(a.center));
  Polygon patch;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
    patch.push_back(middle + far * Eigen::Vector2d(x, y));
  for (const Body* shape : {&a, &b}) {
    if (shape->kind == SHAPE_PLANE) continue;
    Polygon outwards;
    for (int i = 0; i < 96; ++i) outwards.emplace_back(std::cos(two_pi * i / 96), std::sin(two_pi * i / 96));
    for (const Vector3d& pole : shape->poles()) {
      const Eigen::Vector2d across(-v.dot(pole), u.dot(pole));
      if (across.norm() > 1e-3) outwards.insert(outwards.end(), {across.normalized(), -across.normalized()});
    }
    for (const Eigen::Vector2d& out : outwards) {
      const Vector3d d = out.x() * u + out.y() * v;
      const auto value = [&](double lambda) {
        const Vector3d direction = d + lambda * n;
        return direction.dot(shape->support(direction)) - lambda * height;
      };
      double low = -1e4, high = 1e4;  // convex in lambda: golden sections
      constexpr double golden = 0.6180339887498949;
      double x = high - golden * (high - low), y = low + golden * (high - low), at_x = value(x), at_y = value(y);
      for (int k = 0; k < 56; ++k) {
        if (at_x < at_y) {
          high = y, y = x, at_y = at_x, x = high - golden * (high - low), at_x = value(x);
        } else {
          low = x, x = y, at_x = at_y, y = low + golden * (high - low), at_y = value(y);
        }
      }
      patch = clipped(patch, out, value(0.5 * (low + high)));
    }
  }
  return patch;
}

struct Tolerances {
  double depth = 1e-5, inside = 1e-4, normal = 1e-4;  // of the size of the larger shape
  double share = 0.9;                                 // of the best that any four points of the patch can enclose
  bool patch = true;                                  // look at the patch, too: slow
  bool gap_is_distance = true;  // the gap of shapes that are apart is their distance, not just a bound of it
};

/// What was found, lengths as shares of the larger shape's size.
struct Verdict {
  double separation = 0;                    // what the oracle says
  double depth_error = 0, normal_loss = 0;  // of the deepest point; of the separation along the normal
  double outside = -1e300;                  // of the point that is farthest out of its shape
  bool wide = false, lengthy = false;       // the patch
  double share = 1, whole_share = 1;        // of the best area of four points, of the whole area; of a length
  std::vector<std::string> complaints;
};

/// The patch that two shapes share, and whether it lasts: whether nearly all of it is still there at a hundredth of the
/// depth. The patches of round surfaces, of edges that cross and of tilted faces shrink as the shapes are moved apart:
/// how many points stand for those is for the shapes to choose.
struct LastingPatch {
  Polygon patch;
  bool wide = false, lengthy = false;
};

inline LastingPatch lasting_patch(const Body& a, const Body& b, const Vector3d& n, double depth, const Vector3d& u,
                                  const Vector3d& v) {
  const auto patch_at = [&](double left) {
    Body moved = a;
    moved.center += (depth - left) * n;
    const double height = 0.5 * (n.dot(moved.support(-n)) + n.dot(b.support(n)));
    return contact_patch(moved, b, n, height, u, v);
  };
  LastingPatch lasting = {patch_at(depth)};
  const double smaller = b.kind == SHAPE_PLANE ? a.extent() : std::min(a.extent(), b.extent());
  const double across = diameter(lasting.patch);
  if (across < 0.02 * smaller) return lasting;
  const Polygon shrunk = patch_at(0.01 * depth);
  lasting.wide = width(shrunk) > 0.05 * smaller && area(shrunk) > 0.9 * area(lasting.patch);
  lasting.lengthy = width(shrunk) < 0.02 * smaller && diameter(shrunk) > 0.9 * across;
  lasting.patch = shrunk;
  return lasting;
}

namespace detail {

inline void judge_patch(const Body& a, const Body& b, const Vector3d& n, const std::vector<Vector3d>& points,
                        const Vector3d* sure, Verdict& verdict) {
  const Vector3d u = n.unitOrthogonal(), v = n.cross(u);
  const LastingPatch lasting = lasting_patch(a, b, n, -verdict.separation, u, v);
  Polygon spanned;
  for (const Vector3d& p : points) spanned.emplace_back(u.dot(p), v.dot(p));
  verdict.wide = lasting.wide;
  verdict.lengthy = lasting.lengthy;
  if (lasting.wide) {
    const Polygon& patch = lasting.patch;
    verdict.share = best_area_of_four(spanned) /
                    (sure ? best_area_of_four_with({u.dot(*sure), v.dot(*sure)}, patch) : best_area_of_four(patch));
    verdict.whole_share = best_area_of_four(spanned) / area(lasting.patch);
  } else if (lasting.lengthy) {
    verdict.share = verdict.whole_share = diameter(spanned) / diameter(lasting.patch);
  }
}

}  // namespace detail

/// Judges a manifold by the true separation. Gaps above `limit` may be left out.
template <class real>
Verdict judge(const Separation& truth, const Body& a, const Body& b, const reference::Manifold<real>& m, double limit,
              const Tolerances& tolerances = {}) {
  Verdict verdict;
  const auto complain = [&](bool wrong, auto&&... what) {
    if (!wrong) return;
    std::ostringstream text;
    (text << ... << what);
    verdict.complaints.push_back(text.str());
  };
  verdict.separation = truth.distance;
  const double size = std::max(a.extent(), b.extent()), tolerance = tolerances.depth * size;
  if (m.count == 0) {
    // edges beside each other may have no point in common over any face
    complain(!(truth.distance > (tolerances.gap_is_distance ? limit - tolerance : tolerance)), "no manifold at ",
             truth.distance);
    return verdict;
  }
  complain(m.count > 4, m.count, " points");
  const auto vector = [](const reference::Vec3<real>& p) { return Vector3d(double(p.x), double(p.y), double(p.z)); };
  const Vector3d n = vector(m.normal);
  complain(!(std::abs(n.norm() - 1) < 1e-5), "the normal is ", n.norm(), " long");
  const bool bound = !tolerances.gap_is_distance && truth.distance > 0;
  const double along = separation_along(a, b, n.normalized());
  // no direction separates the shapes better, but for what a slightly turned normal loses at the far end of a flat
  // contact; this is the sense of the normal, too
  verdict.normal_loss = bound ? 0 : (truth.distance - along) / size;
  complain(bound && !(along > -tolerances.normal * size), "apart by ", truth.distance, ", and not seen to be: ", along);
  // what is left of digits in the direction between the cores of round shapes that nearly touch
  const double between = std::abs(n.dot(vector(m.points[0].anchor_a) - vector(m.points[0].anchor_b)));
  const bool round = m.radius_a > 0 || m.radius_b > 0;
  const double rounding = round ? 4 * std::numeric_limits<real>::epsilon() * size / between : 0;
  complain(!(std::abs(verdict.normal_loss) < tolerances.normal + rounding), "the normal loses ", verdict.normal_loss,
           ", cores ", between, " apart");

  double deepest = 1e300;
  std::vector<Vector3d> points;
  std::vector<double> gaps;
  for (u32 k = 0; k < m.count; ++k) {
    const Vector3d pa = vector(m.points[k].anchor_a) - double(m.radius_a) * n;
    const Vector3d pb = vector(m.points[k].anchor_b) + double(m.radius_b) * n;
    gaps.push_back(n.dot(pa - pb));
    deepest = std::min(deepest, gaps.back());
    // the anchor on a plane may be any point of it
    const bool plane = b.kind == SHAPE_PLANE;
    const double outside = (plane ? a.outside(pa) : std::max(a.outside(pa), b.outside(pb))) / size;
    complain(!(outside < tolerances.inside), "point ", k, " of ", m.count, " is out of its shape by ", outside);
    verdict.outside = std::max(verdict.outside, outside);
    points.push_back(plane ? pa : Vector3d(0.5 * (pa + pb)));
    for (u32 j = 0; j < k; ++j)
      complain(m.points[j].feature == m.points[k].feature, "points ", j, " and ", k, " have one feature");
  }
  if (bound) {  // what is closest need not lie over the face
    complain(!(deepest > -tolerance), "apart by ", truth.distance, ", and as deep as ", deepest);
    return verdict;
  }
  // of points that enclose most one is nearly as deep as the deepest that there is (depth_slack in patch.hpp)
  const double smaller = b.kind == SHAPE_PLANE ? a.extent() : std::min(a.extent(), b.extent());
  const auto is_patched = [](u32 kind) { return kind == SHAPE_CYLINDER || kind == SHAPE_HULL; };
  const bool patched = m.count > 1 && (is_patched(a.kind) || is_patched(b.kind));
  const double slack = patched ? 2e-4 * smaller + std::min(0.5 * std::abs(truth.distance), 6e-3 * smaller) : 0;
  verdict.depth_error = std::abs(deepest - truth.distance) / size;
  complain(!(verdict.depth_error * size <= tolerances.depth * size + slack), "deepest point ", deepest, ", oracle ",
           truth.distance);
  if (!tolerances.patch || truth.distance > -1e-6 * size || truth.distance < -1e-3 * size) return verdict;
  // four points that have the deepest one among them, if that is deeper than the others
  std::vector<double> sorted = gaps;
  std::ranges::sort(sorted);
  const bool deeper = m.count == 4 && sorted[0] < sorted[1] - 3e-7 * size;
  const Vector3d* sure = deeper ? &points[std::size_t(std::ranges::min_element(gaps) - gaps.begin())] : nullptr;
  detail::judge_patch(a, b, n.normalized(), points, sure, verdict);
  complain(!(verdict.share >= tolerances.share), m.count, " points hold ", verdict.share, " of a ",
           verdict.wide ? "wide" : "lengthy", " patch");
  return verdict;
}

template <class real>
Verdict judge(const Body& a, const Body& b, const reference::Manifold<real>& m, double limit,
              const Tolerances& tolerances = {}) {
  return judge(separation(a, b), a, b, m, limit, tolerances);
}

}  // namespace lockstep::oracle
