// Grounds laid of blocks, and what slides and rolls over them.
#pragma once

#include <cmath>

#include "host/scene/solid_body.hpp"
#include "tests/worlds.hpp"

namespace lockstep::seam_scenes {

inline constexpr double g = 9.81;
inline const Quaternion lying = exact::rotation({0, 1, 0}, std::sqrt(0.5), std::sqrt(0.5));  // z becomes x

inline Scene scene_of(std::vector<BodyDescription> bodies, double friction, Solver solver = Solver::gauss_seidel) {
  Scene scene;
  scene.name = scene.source = "seams";
  scene.settings.dt = 1.0 / 60;
  if (solver != scene.settings.solver) replace_solver(scene.settings, solver);
  scene.materials = {{.name = "stuff", .friction = friction, .restitution = 0}};
  scene.bodies = std::move(bodies);
  return scene;
}

inline ShapeDescription box(const Vector3& half) { return {.kind = SHAPE_BOX, .half_extents = half}; }
inline ShapeDescription sphere(double radius) { return {.kind = SHAPE_SPHERE, .radius = radius}; }

inline BodyDescription solid(const ShapeDescription& shape, const Vector3& position,
                             const Vector3& velocity = {0, 0, 0}, const Quaternion& orientation = {0, 0, 0, 1}) {
  BodyDescription body;
  body.shapes.push_back(shape);
  body.position = position;
  body.velocity = velocity;
  body.orientation = orientation;
  make_solid(body, 1000);
  return body;
}

inline BodyDescription fixed(const ShapeDescription& shape, const Vector3& position) {
  BodyDescription body;
  body.kind = BODY_STATIC;
  body.position = position;
  body.shapes.push_back(shape);
  return body;
}

inline ShapeDescription hull_box(const Vector3& half) {
  ShapeDescription hull = {.kind = SHAPE_HULL};
  for (unsigned i = 0; i < 8; ++i)
    hull.points.push_back({i & 1 ? half[0] : -half[0], i & 2 ? half[1] : -half[1], i & 4 ? half[2] : -half[2]});
  return hull;
}

// Blocks from `from` to `to` with their tops at z = 0, of a kind.
struct Brick {
  Vector3 from, to;
};
template <class Make>
inline std::vector<BodyDescription> laid(const std::vector<Brick>& bricks, Make&& make) {
  std::vector<BodyDescription> bodies;
  for (const Brick& brick : bricks) {
    const Vector3 half = exact::scale(0.5, exact::subtract(brick.to, brick.from));
    bodies.push_back(fixed(make(half), exact::add(brick.from, half)));
  }
  return bodies;
}

// Squares of 0.4 m by 0.4 m.
inline std::vector<Brick> tiles(double side = 0.4, int along = 14, int across = 6) {
  std::vector<Brick> bricks;
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j < across; ++j) {
      const double x = side * (i - 4), y = side * (j - 0.5 * across);
      bricks.push_back({{x, y, -side}, {x + side, y + side, 0}});
    }
  }
  return bricks;
}

// Rows of their own lengths, widths and depths, as a mason would not lay them.
inline std::vector<Brick> bricks() {
  std::vector<Brick> bricks;
  double y = -1.3;
  for (int j = 0; j < 7; ++j) {
    const double width = 0.25 + 0.07 * (j % 4);
    double x = -2 + 0.11 * j;
    for (int i = 0; x < 4; ++i) {
      const double length = 0.3 + 0.13 * ((i + 2 * j) % 5), depth = 0.1 + 0.06 * ((2 * i + j) % 3);
      bricks.push_back({{x, y, -depth}, {x + length, y + width, 0}});
      x += length;
    }
    y += width;
  }
  return bricks;
}

// All shapes as those of one body.
inline BodyDescription compound(const std::vector<BodyDescription>& pieces, BodyKind kind = BODY_STATIC) {
  BodyDescription body;
  body.kind = kind;
  for (const BodyDescription& piece : pieces) {
    body.shapes.push_back(piece.shapes[0]);
    body.shapes.back().offset = piece.position;
  }
  return body;
}

inline std::vector<BodyDescription> rotated(std::vector<BodyDescription> bodies, const Quaternion& q) {
  for (BodyDescription& body : bodies) {
    body.position = exact::rotate(q, body.position);
    body.orientation = q;
  }
  return bodies;
}

inline const Quaternion askew = exact::rotation({0, 0, 1}, std::sqrt(0.1), std::sqrt(0.9));

}  // namespace lockstep::seam_scenes
