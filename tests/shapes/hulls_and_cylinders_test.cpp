// Pairs with a hull or a cylinder against the oracle: random poses near, touching and deep, faces that lie on each
// other, and poses full of ties. LOCKSTEP_PAIRS=100000 tries as many of each kind of pair; a usual run tries a few.
#include <gtest/gtest.h>

#include <cstdlib>

#include "cpu_reference/shapes/pairs.hpp"
#include "host/scene/hull_tables.hpp"
#include "tests/shapes/judge.hpp"
#include "tests/worlds.hpp"

namespace lockstep::test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr const char* kind_names[] = {"sphere", "capsule", "box", "cylinder", "hull", "plane"};
constexpr std::pair<u32, u32> pairs[] = {
    {SHAPE_SPHERE, SHAPE_HULL},       {SHAPE_CAPSULE, SHAPE_HULL},     {SHAPE_BOX, SHAPE_HULL},
    {SHAPE_HULL, SHAPE_HULL},         {SHAPE_HULL, SHAPE_PLANE},       {SHAPE_SPHERE, SHAPE_CYLINDER},
    {SHAPE_CYLINDER, SHAPE_PLANE},    {SHAPE_CAPSULE, SHAPE_CYLINDER}, {SHAPE_BOX, SHAPE_CYLINDER},
    {SHAPE_CYLINDER, SHAPE_CYLINDER}, {SHAPE_CYLINDER, SHAPE_HULL},
};

int pair_count(int usual) {
  const char* wanted = std::getenv("LOCKSTEP_PAIRS");
  return wanted ? std::atoi(wanted) : usual;
}

double between_logs(Random& random, double low, double high) {
  return std::exp(random.between(std::log(low), std::log(high)));
}

/// A box, a tetrahedron, a prism of six sides, a wedge with a sharp edge, a needle, and rocks, with the oracle's view.
template <class real>
struct Hulls {
  Buffers<real> buffers;
  std::vector<oracle::Polyhedron> polyhedra;
  std::vector<Vector3d> sizes;

  Hulls() {
    HullIndex index;
    for (const std::vector<Vector3>& points : point_sets()) {
      std::string refusal;
      index.find_or_add(points, buffers, refusal);
      EXPECT_EQ(refusal, "");
      const Hull& hull = buffers.hulls.back();
      std::vector<Vector3d> rounded;
      Vector3d half = Vector3d::Zero();
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

template <class real>
reference::Vec3<real> rounded(const Vector3d& v) {
  return {real(v.x()), real(v.y()), real(v.z())};
}

template <class real>
reference::Placed<real> random_shape(u32 kind, const Quaterniond& q, Random& random) {
  const auto length = [&] { return between_logs(random, 0.1, 1); };
  reference::Placed<real> shape = {{0, 0, 0}, {real(q.x()), real(q.y()), real(q.z()), real(q.w())}, {0, 0, 0}, 0};
  if (kind == SHAPE_SPHERE) shape.size.x = real(length());
  if (kind == SHAPE_CAPSULE || kind == SHAPE_CYLINDER) shape.size = {real(length()), real(length()), 0};
  if (kind == SHAPE_BOX) shape.size = {real(length()), real(length()), real(length())};
  if (kind == SHAPE_HULL) {
    shape.hull = random.bits() % u32(hulls<real>().sizes.size());
    shape.size = rounded<real>(hulls<real>().sizes[shape.hull]);
  }
  return shape;
}

template <class real>
oracle::Body body(u32 kind, const reference::Placed<real>& shape) {
  return oracle::body(kind, shape, kind == SHAPE_HULL ? &hulls<real>().polyhedra[shape.hull] : nullptr);
}

Quaterniond random_turn(Random& random) {
  Eigen::Vector4d q;
  do {
    for (int k = 0; k < 4; ++k) q[k] = random.between(-1, 1);
  } while (q.norm() < 0.1 || q.norm() > 1);
  return Quaterniond(q.normalized());
}

template <class real>
struct Case {
  reference::Placed<real> a, b;
};

/// Moves b along -direction until the shapes are `gap` apart along it.
template <class real>
void move_apart(u32 kind_a, u32 kind_b, Case<real>& c, const Vector3d& direction, const Vector3d& aside, double gap) {
  const double away = oracle::separation_along(body(kind_a, c.a), body(kind_b, c.b), direction) - gap;
  c.b.center = rounded<real>(away * direction + aside);
}

/// From deep in each other to apart.
template <class real>
Case<real> anyhow(u32 kind_a, u32 kind_b, Random& random) {
  const Quaterniond turn_a = random_turn(random), turn_b = random_turn(random);
  Case<real> c = {random_shape<real>(kind_a, turn_a, random), random_shape<real>(kind_b, turn_b, random)};
  const Vector3d direction =
      kind_b == SHAPE_PLANE ? Vector3d(turn_b * Vector3d::UnitZ()) : Vector3d(random_turn(random) * Vector3d::UnitX());
  move_apart(kind_a, kind_b, c, direction, {0, 0, 0}, random.between(-0.6, 0.15) * random.between(0, 1));
  return c;
}

/// A face, cap, edge or side of a on one of b, turned about the normal, the tilt small or none, the depth small.
template <class real>
Case<real> lying(u32 kind_a, u32 kind_b, Random& random) {
  Case<real> c = {random_shape<real>(kind_a, Quaterniond::Identity(), random),
                  random_shape<real>(kind_b, Quaterniond::Identity(), random)};
  const auto flat_normal = [&](u32 kind, const reference::Placed<real>& shape) -> Vector3d {
    std::vector<Vector3d> normals = body(kind, shape).normals();
    if (kind == SHAPE_PLANE) return Vector3d::UnitZ();
    if (kind == SHAPE_CYLINDER || kind == SHAPE_CAPSULE)
      for (int k = 0; k < 3; ++k) normals.emplace_back(std::cos(0.7 * k), std::sin(0.7 * k), 0);
    if (normals.empty()) return Vector3d::UnitX();
    return normals[random.bits() % normals.size()];
  };
  const Vector3d n = random_turn(random) * Vector3d::UnitZ();
  const double tilts[] = {0, 0, 1e-7, 1e-5, 1e-3, 0.02};
  const AngleAxisd tilt(tilts[random.bits() % 6], random_turn(random) * Vector3d::UnitX());
  const Quaterniond turn_a =
      tilt * AngleAxisd(random.between(0, 6.28), n) * Quaterniond::FromTwoVectors(flat_normal(kind_a, c.a), -n);
  const Quaterniond turn_b = AngleAxisd(random.bits() % 2 ? random.between(0, 6.28) : 0, n) *
                             Quaterniond::FromTwoVectors(flat_normal(kind_b, c.b), n);
  c.a.rotation = {real(turn_a.x()), real(turn_a.y()), real(turn_a.z()), real(turn_a.w())};
  c.b.rotation = {real(turn_b.x()), real(turn_b.y()), real(turn_b.z()), real(turn_b.w())};
  const Vector3d aside = random.bits() % 4 == 0 ? Vector3d(0, 0, 0)
                                                : Vector3d(random.between(0, 0.5) * n.unitOrthogonal() +
                                                           random.between(-0.3, 0.3) * n.cross(n.unitOrthogonal()));
  const double sign = random.bits() % 8 == 0 ? 1 : -1;
  move_apart(kind_a, kind_b, c, n, aside, sign * between_logs(random, 1e-6, 1e-3));
  return c;
}

/// Right angles, sizes and places on a lattice: coincident centres, exact touch, parallel faces, edges and axes.
template <class real>
Case<real> on_lattice(u32 kind_a, u32 kind_b, u32 number) {
  const double h = std::sqrt(0.5);
  const Quaterniond turns[] = {Quaterniond(1, 0, 0, 0), Quaterniond(h, 0, 0, h), Quaterniond(0.5, 0.5, 0.5, 0.5),
                               Quaterniond(std::sqrt(0.5 + 0.5 * h), 0, std::sqrt(0.5 - 0.5 * h), 0)};
  Random random(1);
  const u32 place = number / 16 % 27;
  Case<real> c = {random_shape<real>(kind_a, turns[number % 4], random),
                  random_shape<real>(kind_b, turns[number / 4 % 4], random)};
  for (auto [kind, shape] : {std::pair{kind_a, &c.a}, {kind_b, &c.b}}) {
    if (kind == SHAPE_SPHERE) shape->size = {real(0.25), 0, 0};
    if (kind == SHAPE_CAPSULE || kind == SHAPE_CYLINDER) shape->size = {real(0.25), real(0.5), 0};
    if (kind == SHAPE_BOX) shape->size = {real(0.5), real(0.25), real(0.5)};
    if (kind == SHAPE_HULL) {
      shape->hull = shape == &c.a ? 0 : number / 432 % 3;
      shape->size = rounded<real>(hulls<real>().sizes[shape->hull]);
    }
  }
  c.b.center = {real(0.5) * real(place % 3), real(0.5) * real(place / 3 % 3), real(0.5) * real(place / 9)};
  return c;
}

template <class real>
class HullsAndCylinders : public testing::Test {
 protected:
  void expect_good(u32 kind_a, u32 kind_b, const Case<real>& c, bool patch) {
    const real limit = real(0.2);
    const auto m = reference::collide_shapes(kind_a, c.a, kind_b, c.b, hulls<real>().tables(), limit);
    oracle::Tolerances tolerances;
    tolerances.patch = patch;
    oracle::check_manifold(body(kind_a, c.a), body(kind_b, c.b), m, double(limit), tolerances);
  }
  std::string describe(const Case<real>& c) {
    std::string text;
    for (const auto& s : {c.a, c.b}) {
      for (const real x : {s.center.x, s.center.y, s.center.z, s.rotation.x, s.rotation.y, s.rotation.z, s.rotation.w,
                           s.size.x, s.size.y, s.size.z})
        text += " " + std::to_string(x);
      text += " hull " + std::to_string(s.hull) + ";";
    }
    return text;
  }
};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(HullsAndCylinders, Precisions);

TYPED_TEST(HullsAndCylinders, MeetAnyhow) {
  for (const auto& [a, b] : pairs) {
    Random random(100 * a + b);
    for (int n = 0; n < pair_count(200) && !this->HasFailure(); ++n) {
      const auto c = anyhow<TypeParam>(a, b, random);
      SCOPED_TRACE(testing::Message() << kind_names[a] << " and " << kind_names[b] << " " << n << this->describe(c));
      this->expect_good(a, b, c, false);
    }
  }
}

TYPED_TEST(HullsAndCylinders, LieOnEachOther) {
  for (const auto& [a, b] : pairs) {
    Random random(200 * a + b);
    for (int n = 0; n < pair_count(200) / 2 && !this->HasFailure(); ++n) {
      const auto c = lying<TypeParam>(a, b, random);
      SCOPED_TRACE(testing::Message() << kind_names[a] << " and " << kind_names[b] << " " << n << this->describe(c));
      this->expect_good(a, b, c, n % 10 == 0);
    }
  }
}

TYPED_TEST(HullsAndCylinders, MeetOnALattice) {
  for (const auto& [a, b] : pairs) {
    for (u32 n = 0; n < 432 * (b == SHAPE_HULL ? 3 : 1) && !this->HasFailure(); n += pair_count(0) > 0 ? 1 : 7) {
      const auto c = on_lattice<TypeParam>(a, b, n);
      SCOPED_TRACE(testing::Message() << kind_names[a] << " and " << kind_names[b] << " " << n << this->describe(c));
      this->expect_good(a, b, c, false);
    }
  }
}

}  // namespace
}  // namespace lockstep::test
