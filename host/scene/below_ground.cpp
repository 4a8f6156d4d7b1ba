#include "host/scene/below_ground.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "host/scene/surface.hpp"

namespace lockstep {

namespace {

constexpr std::size_t most_cells_a_side = 512;

// Seen from above: along two horizontal axes and up.
struct View {
  Vector3 across, along, up;

  explicit View(const Vector3& gravity) {
    up = exact::unit(exact::scale(-1, gravity));
    const Vector3 other = std::abs(up[0]) < 0.5 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
    across = exact::unit(exact::cross(other, up));
    along = exact::cross(up, across);
  }
  Vector3 of(const Vector3& point) const {
    return {exact::dot(point, across), exact::dot(point, along), exact::dot(point, up)};
  }
};

struct Triangle {
  std::array<Vector3, 3> corners;  // as View has them
  u32 ground;

  // Twice its area, seen from above; below 0 where it is seen from its back.
  double area() const {
    const Vector3 &a = corners[0], &b = corners[1], &c = corners[2];
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  }

  // How high it is over or under a point; nothing beside it, and where it is vertical.
  std::optional<double> height_at(const Vector3& p) const {
    const double whole = area();
    double height = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 &b = corners[(k + 1) % 3], &c = corners[(k + 2) % 3];
      const double share = ((b[0] - p[0]) * (c[1] - p[1]) - (b[1] - p[1]) * (c[0] - p[0])) / whole;
      if (!(share >= 0)) return std::nullopt;
      height += share * corners[k][2];
    }
    return height;
  }
};

// A dynamic body, and the ground over its middle.
struct Candidate {
  u32 body;
  Vector3 point;  // as View has it
  double depth = std::numeric_limits<double>::infinity();
  u32 ground = NONE;  // the nearest above, where it looks up
  bool is_carried = false;

  void look_at(const Triangle& triangle) {
    const std::optional<double> height = triangle.height_at(point);
    if (!height) return;
    is_carried = is_carried || (*height <= point[2] && triangle.area() > 0);
    if (*height <= point[2] || *height - point[2] >= depth) return;
    depth = *height - point[2];
    ground = triangle.area() > 0 ? triangle.ground : NONE;
  }
};

// Candidates by the squares of a grid that they are in.
class Grid {
 public:
  explicit Grid(const std::vector<Candidate>& candidates) {
    for (const Candidate& candidate : candidates) {
      for (unsigned k = 0; k < 2; ++k) {
        low_[k] = std::min(low_[k], candidate.point[k]);
        high_[k] = std::max(high_[k], candidate.point[k]);
      }
    }
    const auto wanted = static_cast<std::size_t>(std::sqrt(static_cast<double>(candidates.size())));
    side_ = std::clamp<std::size_t>(wanted, 1, most_cells_a_side);
    cells_.resize(side_ * side_);
    for (u32 i = 0; i < candidates.size(); ++i)
      cells_[cell_of(candidates[i].point, 1) * side_ + cell_of(candidates[i].point, 0)].push_back(i);
  }

  /// Calls `function` with those that may be over or under a triangle.
  template <class Function>
  void for_each_at(const Triangle& triangle, Function&& function) const {
    std::array<std::size_t, 2> first = {side_, side_}, last = {0, 0};
    for (unsigned k = 0; k < 2; ++k) {
      const double from = std::min({triangle.corners[0][k], triangle.corners[1][k], triangle.corners[2][k]});
      const double to = std::max({triangle.corners[0][k], triangle.corners[1][k], triangle.corners[2][k]});
      if (to < low_[k] || from > high_[k]) return;
      for (const Vector3& corner : triangle.corners) {
        first[k] = std::min(first[k], cell_of(corner, k));
        last[k] = std::max(last[k], cell_of(corner, k));
      }
    }
    for (std::size_t y = first[1]; y <= last[1]; ++y)
      for (std::size_t x = first[0]; x <= last[0]; ++x)
        for (const u32 i : cells_[y * side_ + x]) function(i);
  }

 private:
  std::size_t cell_of(const Vector3& point, unsigned k) const {
    const double share = (point[k] - low_[k]) / std::max(high_[k] - low_[k], std::numeric_limits<double>::min());
    return static_cast<std::size_t>(std::clamp(share, 0.0, 1.0) * 0.999999 * static_cast<double>(side_));
  }

  std::array<double, 2> low_ = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::array<double, 2> high_ = {-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  std::size_t side_ = 1;
  std::vector<std::vector<u32>> cells_;
};

// Calls `function` with all triangles of static bodies.
template <class Function>
void for_each_triangle(const Scene& scene, const View& view, Function&& function) {
  for (u32 i = 0; i < scene.bodies.size(); ++i) {
    const BodyDescription& body = scene.bodies[i];
    if (body.kind != BODY_STATIC) continue;
    for (const ShapeDescription& shape : body.shapes) {
      if (shape.kind != SHAPE_FACET) continue;
      for (u32 t = 0; t < shape.surface->facets.size(); ++t) {
        Triangle triangle = {{}, i};
        const Vector3 offset = offset_of_facet(shape, t);
        const std::array<Vector3, 3> corners = corners_of_facet(*shape.surface, t);
        for (std::size_t k = 0; k < 3; ++k) {
          const Vector3 of_body = exact::add(offset, exact::rotate(shape.rotation, corners[k]));
          triangle.corners[k] = view.of(exact::add(body.position, exact::rotate(body.orientation, of_body)));
        }
        function(triangle);
      }
    }
  }
}

bool has_static_plane(const Scene& scene) {
  return std::ranges::any_of(scene.bodies, [](const BodyDescription& body) {
    return body.kind != BODY_DYNAMIC &&
           std::ranges::any_of(body.shapes, [](const ShapeDescription& shape) { return shape.kind == SHAPE_PLANE; });
  });
}

}  // namespace

std::vector<BelowGround> bodies_below_ground(const Scene& scene) {
  if (exact::length(scene.gravity) == 0 || has_static_plane(scene)) return {};
  const View view(scene.gravity);
  std::vector<Candidate> candidates;
  for (u32 i = 0; i < scene.bodies.size(); ++i) {
    const BodyDescription& body = scene.bodies[i];
    if (body.kind == BODY_DYNAMIC && !body.shapes.empty()) candidates.push_back({i, view.of(body.position)});
  }
  if (candidates.empty()) return {};
  const Grid grid(candidates);
  for_each_triangle(scene, view, [&](const Triangle& triangle) {
    grid.for_each_at(triangle, [&](u32 i) { candidates[i].look_at(triangle); });
  });
  std::vector<BelowGround> found;
  for (const Candidate& candidate : candidates)
    if (candidate.ground != NONE && !candidate.is_carried)
      found.push_back({candidate.body, candidate.ground, candidate.depth});
  return found;
}

}  // namespace lockstep
