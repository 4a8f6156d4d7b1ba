// Every pair of kinds against the oracle: random shapes near, touching and deep in each other, and poses full of ties.
// LOCKSTEP_PAIRS=100000 tries as many random pairs of each kind; a usual run tries a few.
#include "cpu_reference/shapes/pairs.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/shapes/judge.hpp"
#include "tests/worlds.hpp"

namespace lockstep::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr const char* kind_names[] = {"sphere", "capsule", "box", "cylinder", "hull", "plane"};

bool is_pair_of_kinds(u32 a, u32 b) {
#define SHAPE_PAIR(first, second, manifold) \
  if (a == SHAPE_##first && b == SHAPE_##second) return true;
#define PATCH_PAIR(first, second)  // tests/shapes/hulls_and_cylinders_test.cpp
#include "kernels/shape_pairs.def"
#undef SHAPE_PAIR
#undef PATCH_PAIR
  return false;
}

int pair_count() {
  const char* wanted = std::getenv("LOCKSTEP_PAIRS");
  return wanted ? std::atoi(wanted) : 400;
}

template <class real>
reference::Placed<real> placed(const Vector3d& center, const Quaterniond& q, const Vector3d& size) {
  return {{real(center.x()), real(center.y()), real(center.z())},
          {real(q.x()), real(q.y()), real(q.z()), real(q.w())},
          {real(size.x()), real(size.y()), real(size.z())},
          0};
}

Vector3d random_size(u32 kind, Random& random) {
  const auto length = [&] { return random.between(0.2, 1); };
  switch (kind) {
    case SHAPE_SPHERE: return {length(), 0, 0};
    case SHAPE_CAPSULE:
    case SHAPE_CYLINDER: return {length(), length(), 0};
    case SHAPE_BOX: return {length(), length(), length()};
    default: return {0, 0, 0};
  }
}

Quaterniond random_turn(Random& random) {
  Eigen::Vector4d q;
  do {
    for (int k = 0; k < 4; ++k) q[k] = random.between(-1, 1);
  } while (q.norm() < 0.1 || q.norm() > 1);
  return Quaterniond(q.normalized());
}

// a at the origin, and b along a random direction so that along it their gap is between deep and apart.
template <class real>
struct Case {
  reference::Placed<real> a, b;
};

template <class real>
Case<real> random_case(u32 kind_a, u32 kind_b, Random& random) {
  const Vector3d size_a = random_size(kind_a, random), size_b = random_size(kind_b, random);
  const Quaterniond turn_a = random_turn(random), turn_b = random_turn(random);
  Case<real> c = {placed<real>({0, 0, 0}, turn_a, size_a), placed<real>({0, 0, 0}, turn_b, size_b)};
  const Vector3d direction =
      kind_b == SHAPE_PLANE ? Vector3d(turn_b * Vector3d::UnitZ()) : Vector3d(random_turn(random) * Vector3d::UnitX());
  const oracle::Body a = oracle::body(kind_a, c.a), b = oracle::body(kind_b, c.b);
  const double gap = random.between(-0.6, 0.15) * random.between(0, 1);
  // the plane's own support is its origin
  const double away = oracle::separation_along(a, b, direction) - gap;
  const Vector3d center = away * direction;
  c.b.center = {real(center.x()), real(center.y()), real(center.z())};
  return c;
}

template <class real>
class Pairs : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(Pairs, Precisions);

template <class real>
void expect_good(u32 kind_a, u32 kind_b, const Case<real>& c, const oracle::Tolerances& tolerances) {
  const real limit = real(0.2);
  const reference::HullTables<real> none = {};
  const reference::Manifold<real> m = reference::collide_shapes(kind_a, c.a, kind_b, c.b, none, limit);
  oracle::check_manifold(oracle::body(kind_a, c.a), oracle::body(kind_b, c.b), m, double(limit), tolerances);
}

// Shapes with edges that are apart are separated along an axis of faces and edges: a bound of their distance.
bool knows_the_distance(u32 kind_a, u32 kind_b) {
  return kind_a == SHAPE_SPHERE || kind_a == SHAPE_CAPSULE || kind_b == SHAPE_PLANE;
}

TYPED_TEST(Pairs, RandomPairs) {
  using real = TypeParam;
  for (u32 kind_a = 0; kind_a < SHAPE_KINDS; ++kind_a) {
    for (u32 kind_b = kind_a; kind_b < SHAPE_KINDS; ++kind_b) {
      if (!is_pair_of_kinds(kind_a, kind_b) || kind_a == SHAPE_HULL || kind_b == SHAPE_HULL) continue;
      Random random(100 * kind_a + kind_b);
      oracle::Tolerances tolerances;
      tolerances.apart = knows_the_distance(kind_a, kind_b);
      for (int n = 0; n < pair_count() && !this->HasFailure(); ++n) {
        SCOPED_TRACE(testing::Message() << kind_names[kind_a] << " and " << kind_names[kind_b] << ", pair " << n);
        expect_good(kind_a, kind_b, random_case<real>(kind_a, kind_b, random), tolerances);
      }
    }
  }
}

// Right angles and half turns, sizes and places on a lattice: coincident centres, shapes that touch exactly, parallel
// faces, edges and axes.
std::vector<Quaterniond> lattice_turns() {
  const double h = std::sqrt(0.5);
  return {Quaterniond(1, 0, 0, 0), Quaterniond(h, 0, 0, h), Quaterniond(0.5, 0.5, 0.5, 0.5),
          Quaterniond(std::sqrt(0.5 + 0.5 * h), 0, std::sqrt(0.5 - 0.5 * h), 0)};
}

Vector3d lattice_size(u32 kind) {
  if (kind == SHAPE_BOX) return {0.5, 0.25, 0.5};
  return kind == SHAPE_PLANE ? Vector3d(0, 0, 0) : Vector3d(0.25, kind == SHAPE_SPHERE ? 0 : 0.5, 0);
}

TYPED_TEST(Pairs, Ties) {
  using real = TypeParam;
  for (u32 kind_a = 0; kind_a < SHAPE_KINDS; ++kind_a) {
    for (u32 kind_b = kind_a; kind_b < SHAPE_KINDS; ++kind_b) {
      if (!is_pair_of_kinds(kind_a, kind_b) || kind_a == SHAPE_HULL || kind_b == SHAPE_HULL) continue;
      oracle::Tolerances tolerances;
      tolerances.apart = knows_the_distance(kind_a, kind_b);
      tolerances.patch = false;
      for (const Quaterniond& turn_a : lattice_turns()) {
        for (const Quaterniond& turn_b : lattice_turns()) {
          for (int place = 0; place < 27 && !this->HasFailure(); ++place) {
            const Vector3d center = 0.5 * Vector3d(place % 3, place / 3 % 3, place / 9);
            SCOPED_TRACE(testing::Message()
                         << kind_names[kind_a] << " and " << kind_names[kind_b] << ", place " << place << ", turns "
                         << turn_a.coeffs().transpose() << " and " << turn_b.coeffs().transpose());
            expect_good<real>(kind_a, kind_b,
                              {placed<real>({0, 0, 0}, turn_a, lattice_size(kind_a)),
                               placed<real>(center, turn_b, lattice_size(kind_b))},
                              tolerances);
          }
        }
      }
    }
  }
}

// A box that rests on another one, turned by any angle, touches it at four points that enclose what the patch allows.
TYPED_TEST(Pairs, APatchOfTwoBoxesHasFourPoints) {
  using real = TypeParam;
  for (int n = 0; n < 90; ++n) {
    SCOPED_TRACE(n);
    const double angle = n * 0.0174532925;
    const Quaterniond turned(Eigen::AngleAxisd(angle, Vector3d::UnitZ()));
    expect_good<real>(SHAPE_BOX, SHAPE_BOX,
                      {placed<real>({0, 0, 0}, Quaterniond(1, 0, 0, 0), {0.5, 0.5, 0.5}),
                       placed<real>({0.3, 0.1, 0.99998}, turned, {0.5, 0.25, 0.5})},
                      {});
  }
}

}  // namespace
}  // namespace lockstep::test
