// Pairs of shapes to be judged: random poses near, touching and deep, faces that lie on each other, poses full of ties.
#pragma once

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "host/scene/hull_tables.hpp"
#include "tests/shapes/oracle.hpp"
#include "tests/worlds.hpp"

namespace lockstep::test {

inline constexpr const char* kind_names[] = {"sphere", "capsule", "box", "cylinder", "hull", "plane"};

inline Eigen::Quaterniond random_rotation(Random& random) {
  Eigen::Vector4d q;
  do {
    for (int k = 0; k < 4; ++k) q[k] = random.between(-1, 1);
  } while (q.norm() < 0.1 || q.norm() > 1);
  return Eigen::Quaterniond(q.normalized());
}

inline double between_logs(Random& random, double low, double high) {
  return std::exp(random.between(std::log(low), std::log(high)));
}

/// A box, a tetrahedron, a prism of six sides, a wedge with a sharp edge, a needle, and rocks, with the oracle's view.
template <class real>
struct Hulls {
  Buffers<real> buffers;
  std::vector<oracle::Polyhedron> polyhedra;
  std::vector<Eigen::Vector3d> sizes;

  Hulls() {
    HullIndex index;
    for (const std::vector<Vector3>& points : point_sets()) {
      std::string refusal;
      index.find_or_add(points, buffers, refusal);
      EXPECT_EQ(refusal, "");
      const Hull& hull = buffers.hulls.back();
      std::vector<Eigen::Vector3d> rounded;
      Eigen::Vector3d half = Eigen::Vector3d::Zero();
      for (u32 i = 0; i < hull.vertex_count; ++i) {
        const Vec4<real>& v = buffers.hull_vertices[hull.first_vertex + i];
        rounded.emplace_back(double(v.x), double(v.y), double(v.z));
        half = half.cwiseMax(rounded.back().cwiseAbs());
      }
      polyhedra.emplace_back(rounded);
      sizes.push_back(half);
    }
  }

  static std::vector<std::vector<Vector3>> point_sets() {
    std::vector<std::vector<Vector3>> sets(9);
    for (int k = 0; k < 8; ++k) sets[0].push_back({k & 1 ? 0.5 : -0.5, k & 2 ? 0.25 : -0.25, k & 4 ? 0.5 : -0.5});
    sets[1] = {{0.5, 0.5, 0.5}, {-0.5, -0.5, 0.5}, {-0.5, 0.5, -0.5}, {0.5, -0.5, -0.5}};
    for (int k = 0; k < 6; ++k) {
      const double angle = k * exact::pi / 3, c = 0.5 * exact::cosine(angle), s = 0.5 * exact::sine(angle);
      sets[2].push_back({c, s, 0.4});
      sets[2].push_back({c, s, -0.4});
    }
    sets[3] = {{-0.6, 0.03, 0}, {-0.6, -0.03, 0}, {-0.5, 0, 0.6}, {0.6, 0.03, 0}, {0.6, -0.03, 0}, {0.5, 0, 0.6}};
    sets[4] = {{0, 0, 0.9}, {0.1, 0, -0.3}, {-0.1, 0.1, -0.3}, {-0.1, -0.1, -0.3}, {0, 0, -0.4}};
    Random random(5);
    for (std::size_t i = 5; i < sets.size(); ++i)
      for (int k = 0; k < 12 + 4 * int(i - 5); ++k) sets[i].push_back(random.vector(0.6));
    return sets;
  }

  reference::HullTables<real> tables() const {
    return {buffers.hulls.data(),      buffers.hull_vertices.data(), buffers.hull_planes.data(),
            buffers.hull_faces.data(), buffers.hull_edges.data(),    buffers.hull_corners.data()};
  }
};

template <class real>
const Hulls<real>& hulls() {
  static const Hulls<real> all;
  return all;
}

/// The kinds of a pair, in the order in which pairs are stored.
struct PairOfKinds {
  u32 a, b;
  auto operator<=>(const PairOfKinds&) const = default;
};

inline std::vector<PairOfKinds> all_pairs_of_kinds() {
  return {
#define SHAPE_PAIR(a, b, manifold) {SHAPE_##a, SHAPE_##b},
#define PATCH_PAIR(a, b) {SHAPE_##a, SHAPE_##b},
#include "kernels/shape_pairs.def"
#undef SHAPE_PAIR
#undef PATCH_PAIR
  };
}

template <class real>
struct Case {
  PairOfKinds kinds;
  reference::WorldShape<real> a, b;
};

template <class real>
oracle::Body body(u32 kind, const reference::WorldShape<real>& shape) {
  return oracle::body(kind, shape, kind == SHAPE_HULL ? &hulls<real>().polyhedra[shape.hull] : nullptr);
}

template <class real>
std::string describe(const Case<real>& c) {
  std::ostringstream text;
  text.precision(sizeof(real) == 8 ? 17 : 9);
  for (const auto& [kind, s] : {std::pair{c.kinds.a, c.a}, {c.kinds.b, c.b}}) {
    text << kind_names[kind];
    for (const real x : {s.center.x, s.center.y, s.center.z, s.rotation.x, s.rotation.y, s.rotation.z, s.rotation.w,
                         s.size.x, s.size.y, s.size.z})
      text << ' ' << x;
    text << " hull " << s.hull << "; ";
  }
  return text.str();
}

template <class real>
reference::Vec3<real> rounded(const Eigen::Vector3d& v) {
  return {real(v.x()), real(v.y()), real(v.z())};
}

template <class real>
reference::Quat<real> rounded(const Eigen::Quaterniond& q) {
  return {real(q.x()), real(q.y()), real(q.z()), real(q.w())};
}

template <class real>
reference::WorldShape<real> random_shape(u32 kind, const Eigen::Quaterniond& rotation, Random& random) {
  const auto length = [&] { return real(between_logs(random, 0.1, 1)); };
  reference::WorldShape<real> shape = {{0, 0, 0}, rounded<real>(rotation), {0, 0, 0}, 0};
  if (kind == SHAPE_SPHERE) shape.size.x = length();
  if (kind == SHAPE_CAPSULE || kind == SHAPE_CYLINDER) shape.size = {length(), length(), 0};
  if (kind == SHAPE_BOX) shape.size = {length(), length(), length()};
  if (kind == SHAPE_HULL) {
    shape.hull = random.bits() % u32(hulls<real>().sizes.size());
    shape.size = rounded<real>(hulls<real>().sizes[shape.hull]);
  }
  return shape;
}

/// Moves b along -direction until the shapes are `gap` apart along it, and then aside.
template <class real>
void separate(Case<real>& c, const Eigen::Vector3d& direction, const Eigen::Vector3d& aside, double gap) {
  const double away = oracle::separation_along(body(c.kinds.a, c.a), body(c.kinds.b, c.b), direction) - gap;
  c.b.center = rounded<real>(away * direction + aside);
}

/// From deep in each other to apart, along a direction that is the normal only by luck.
template <class real>
Case<real> meeting_anyhow(PairOfKinds kinds, Random& random) {
  const Eigen::Quaterniond rotation_a = random_rotation(random), rotation_b = random_rotation(random);
  Case<real> c = {kinds, random_shape<real>(kinds.a, rotation_a, random),
                  random_shape<real>(kinds.b, rotation_b, random)};
  const Eigen::Quaterniond rotated = kinds.b == SHAPE_PLANE ? rotation_b : random_rotation(random);
  const Eigen::Vector3d direction = rotated * Eigen::Vector3d::UnitZ();
  separate(c, direction, {0, 0, 0}, random.between(-0.6, 0.15) * random.between(0, 1));
  return c;
}

/// A face, cap, edge or side of a on one of b, turned about the normal, the tilt small or none, the depth small.
template <class real>
Case<real> lying(PairOfKinds kinds, Random& random) {
  using Eigen::AngleAxisd, Eigen::Quaterniond, Eigen::Vector3d;
  Case<real> c = {kinds, random_shape<real>(kinds.a, Quaterniond::Identity(), random),
                  random_shape<real>(kinds.b, Quaterniond::Identity(), random)};
  const auto flat_normal = [&](u32 kind, const reference::WorldShape<real>& shape) -> Vector3d {
    std::vector<Vector3d> normals = body(kind, shape).normals();
    if (kind == SHAPE_PLANE) return Vector3d::UnitZ();
    if (kind == SHAPE_CYLINDER || kind == SHAPE_CAPSULE)
      for (int k = 0; k < 3; ++k) normals.emplace_back(std::cos(0.7 * k), std::sin(0.7 * k), 0);
    if (normals.empty()) return Vector3d::UnitX();
    return normals[random.bits() % normals.size()];
  };
  const Vector3d n = random_rotation(random) * Vector3d::UnitZ();
  const double tilts[] = {0, 0, 1e-7, 1e-5, 1e-3, 0.02};
  const AngleAxisd tilt(tilts[random.bits() % 6], random_rotation(random) * Vector3d::UnitX());
  const AngleAxisd rotation_a(random.between(0, oracle::two_pi), n);
  const AngleAxisd rotation_b(random.bits() % 2 ? random.between(0, oracle::two_pi) : 0, n);
  c.a.rotation = rounded<real>(tilt * rotation_a * Quaterniond::FromTwoVectors(flat_normal(kinds.a, c.a), -n));
  c.b.rotation = rounded<real>(rotation_b * Quaterniond::FromTwoVectors(flat_normal(kinds.b, c.b), n));
  const Vector3d u = n.unitOrthogonal(), v = n.cross(u);
  const bool in_line = random.bits() % 4 == 0;
  const Vector3d aside =
      in_line ? Vector3d(0, 0, 0) : Vector3d(random.between(0, 0.5) * u + random.between(-0.3, 0.3) * v);
  const double sign = random.bits() % 8 == 0 ? 1 : -1;
  separate(c, n, aside, sign * between_logs(random, 1e-6, 1e-3));
  return c;
}

inline constexpr u32 lattice_cases = 16 * 27 * 3;

/// Right angles, sizes and places on a lattice: coincident centres, exact touch, parallel faces, edges and axes.
template <class real>
Case<real> on_lattice(PairOfKinds kinds, u32 number) {
  using Eigen::Quaterniond;
  const double h = std::sqrt(0.5);
  const Quaterniond rotations[] = {Quaterniond(1, 0, 0, 0), Quaterniond(h, 0, 0, h), Quaterniond(0.5, 0.5, 0.5, 0.5),
                                   Quaterniond(std::sqrt(0.5 + 0.5 * h), 0, std::sqrt(0.5 - 0.5 * h), 0)};
  const auto shape = [&](u32 kind, const Quaterniond& rotation, u32 hull) {
    reference::WorldShape<real> world_shape = {{0, 0, 0}, rounded<real>(rotation), {0, 0, 0}, 0};
    if (kind == SHAPE_SPHERE) world_shape.size = {real(0.25), 0, 0};
    if (kind == SHAPE_CAPSULE || kind == SHAPE_CYLINDER) world_shape.size = {real(0.25), real(0.5), 0};
    if (kind == SHAPE_BOX) world_shape.size = {real(0.5), real(0.25), real(0.5)};
    if (kind == SHAPE_HULL) {
      world_shape.hull = hull;
      world_shape.size = rounded<real>(hulls<real>().sizes[hull]);
    }
    return world_shape;
  };
  Case<real> c = {kinds, shape(kinds.a, rotations[number % 4], 0),
                  shape(kinds.b, rotations[number / 4 % 4], number / 432 % 3)};
  const u32 cell = number / 16 % 27;
  c.b.center = {real(0.5) * real(cell % 3), real(0.5) * real(cell / 3 % 3), real(0.5) * real(cell / 9)};
  return c;
}

}  // namespace lockstep::test
