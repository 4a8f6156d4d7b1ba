// Contact impulses of least norm: closed forms of indeterminate supports, another algorithm, and what a world tells.
#include "host/report/least_norm.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "host/scene/read.hpp"
#include "tests/library_worlds.hpp"
#include "tests/worlds.hpp"

namespace lockstep::least_norm_test {
namespace {

using Eigen::Vector3d;

double squares(const std::vector<Vector3d>& impulses) {
  double sum = 0;
  for (const Vector3d& impulse : impulses) sum += impulse.squaredNorm();
  return sum;
}

// Of a body 0 that stands on what nothing moves.
SharedContact support(const Vector3d& point, const Vector3d& impulse, double friction,
                      const Vector3d& normal = Vector3d::UnitZ()) {
  SharedContact contact;
  contact.body_a = 0;
  contact.point = point;
  contact.normal = normal;
  contact.along = contact.across = friction;
  contact.impulse = impulse;
  return contact;
}

// Four feet at (+-1, +-0.5), in the order (-, -), (-, +), (+, -), (+, +).
std::vector<SharedContact> four_feet(const std::array<double, 4>& normal, const Vector3d& slope, double friction) {
  std::vector<SharedContact> feet;
  for (unsigned i = 0; i < 4; ++i)
    feet.push_back(
        support({i < 2 ? -1.0 : 1.0, i % 2 == 0 ? -0.5 : 0.5, 0}, normal[i] * (Vector3d::UnitZ() + slope), friction));
  return feet;
}

void expect_near(const Vector3d& actual, const Vector3d& expected, double tolerance = 1e-10) {
  EXPECT_LT((actual - expected).norm(), tolerance) << actual.transpose() << " is not " << expected.transpose();
}

TEST(LeastNorm, FourFeetCarryAQuarterEach) {
  for (const Vector3d& impulse : least_norm_impulses(four_feet({1.5, 0.5, 0.5, 1.5}, {0, 0, 0}, 0.5)))
    expect_near(impulse, {0, 0, 1});
}

// n_i = N / 4 + N (e_x x_i / sum x^2 + e_y y_i / sum y^2): of what is affine in the position, that of the same moments.
TEST(LeastNorm, AnEccentricLoadIsAffineInThePosition) {
  const std::vector<SharedContact> feet = four_feet({0.3, 1.1, 0.9, 1.7}, {0, 0, 0}, 0.5);
  double sum = 0, moment_x = 0, moment_y = 0;
  for (const SharedContact& foot : feet) {
    sum += foot.impulse.z();
    moment_x += foot.point.x() * foot.impulse.z();
    moment_y += foot.point.y() * foot.impulse.z();
  }
  const std::vector<Vector3d> impulses = least_norm_impulses(feet);
  for (std::size_t i = 0; i < feet.size(); ++i)
    expect_near(impulses[i], {0, 0, sum / 4 + moment_x * feet[i].point.x() / 4 + moment_y * feet[i].point.y()});
}

// On supports at 0, 1 and 3 m, the load at `x`: affine, with mean 1/3 and sum (x_i - 4/3)^2 = 14/3; where the last
// would pull, the first two carry it as a lever does.
TEST(LeastNorm, APlankOnThreeSupportsNeverPulls) {
  for (const double x : {1.0, 0.3}) {
    const double positions[] = {0, 1, 3};
    std::vector<SharedContact> supports;
    for (const double at : positions) supports.push_back(support({at, 0, 0}, {0, 0, 0}, 0.4));
    supports[0].impulse.z() = 1 - x / 3;  // told: on the outer two
    supports[2].impulse.z() = x / 3;
    const std::vector<Vector3d> impulses = least_norm_impulses(supports);
    for (unsigned i = 0; i < 3; ++i) {
      const double affine = 1.0 / 3 + (x - 4.0 / 3) * (positions[i] - 4.0 / 3) * 3 / 14;
      const double by_two[] = {1 - x, x, 0};
      expect_near(impulses[i], {0, 0, x == 1 ? affine : by_two[i]});
    }
  }
}

TEST(LeastNorm, FeetOnASlopeShareTheShear) {
  for (const Vector3d& impulse : least_norm_impulses(four_feet({1.4, 0.6, 0.6, 1.4}, {0.3, -0.1, 0}, 0.5)))
    expect_near(impulse, {0.3, -0.1, 1});
}

// All of its points at the edge of their cones: what slides goes on to be rubbed against its slip.
TEST(LeastNorm, WhatSlidesHasFrictionInProportionToItsNormalForces) {
  const std::vector<Vector3d> impulses = least_norm_impulses(four_feet({1.5, 0.7, 0.5, 1.5}, {0.3, 0.4, 0}, 0.5));
  const double normal[] = {1.05, 1.15, 0.95, 1.05};
  for (unsigned i = 0; i < 4; ++i) expect_near(impulses[i], normal[i] * Vector3d(0.3, 0.4, 1));
}

// A body in a groove with walls at +-a: both carry half straight up where the cone has that, else at its edge, phi =
// atan mu off the normal: W / 2 / cos(a - phi).
TEST(LeastNorm, AWedgePushesItsWallsAsLittleAsFrictionLets) {
  const double angle = 0.6;
  for (const double friction : {0.0, 0.3, 0.9}) {
    std::vector<SharedContact> walls;
    for (const double side : {-1.0, 1.0})
      walls.push_back(support({side, 0, 0}, {0, 0, 0}, friction, {-side * std::sin(angle), 0, std::cos(angle)}));
    for (SharedContact& wall : walls) wall.impulse = wall.normal / std::cos(angle);  // told: without friction, W = 2
    const std::vector<Vector3d> impulses = least_norm_impulses(walls);
    const double tilt = std::max(angle - std::atan(friction), 0.0);
    for (unsigned i = 0; i < 2; ++i) expect_near(impulses[i], {(i == 0 ? 1 : -1) * std::tan(tilt), 0, 1});
  }
}

TEST(LeastNorm, StackedCratesLoadAllFeetOfEach) {
  std::vector<SharedContact> contacts = four_feet({4, 2, 2, 4}, {0, 0, 0}, 0.5);
  for (SharedContact contact : four_feet({1, 3, 3, 1}, {0, 0, 0}, 0.5)) {
    contact.body_a = 1;
    contact.body_b = 0;
    contact.point.z() = 1;
    contacts.push_back(contact);
  }
  const std::vector<Vector3d> impulses = least_norm_impulses(contacts);
  for (unsigned i = 0; i < 8; ++i) expect_near(impulses[i], {0, 0, i < 4 ? 3.0 : 2.0});
}

TEST(LeastNorm, WithoutFrictionAlongAnAxisThereIsNone) {
  std::vector<SharedContact> feet = four_feet({1.5, 0.5, 0.5, 1.5}, {0, 0.2, 0}, 0);
  for (SharedContact& foot : feet) foot.axis = {1, 0, 0}, foot.across = 0.5;
  for (const Vector3d& impulse : least_norm_impulses(feet)) {
    EXPECT_EQ(impulse.x(), 0);
    expect_near(impulse, {0, 0.2, 1});
  }
}

TEST(LeastNorm, WhatIsDeterminedStays) {
  const SharedContact alone = support({1, 2, 3}, {0.5, 0, 1}, 0.4);  // outside of its cone: that is as wide, then
  EXPECT_LT((least_norm_impulses(std::span(&alone, 1))[0] - alone.impulse).norm(), 1e-9);
  const SharedContact idle = support({1, 2, 3}, {0, 0, 0}, 0.4);
  EXPECT_EQ(least_norm_impulses(std::span(&idle, 1))[0], Vector3d::Zero());
}

// ---- against another algorithm

// Force and moment about the origin of the contacts' impulses on each body.
Eigen::VectorXd sums_of(const std::vector<SharedContact>& contacts, const std::vector<Vector3d>& impulses,
                        std::size_t bodies) {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(6 * bodies));
  for (std::size_t i = 0; i < contacts.size(); ++i)
    for (const auto& [body, sign] : {std::pair(contacts[i].body_a, 1.0), std::pair(contacts[i].body_b, -1.0)}) {
      if (body == NONE) continue;
      sums.segment<3>(6 * body) += sign * impulses[i];
      sums.segment<3>(6 * body + 3) += sign * contacts[i].point.cross(impulses[i]);
    }
  return sums;
}

Vector3d on_round_cone(const Vector3d& x, const Vector3d& normal, double mu) {
  const double n = x.dot(normal);
  const Vector3d tangent = x - n * normal;
  const double t = tangent.norm();
  if (t <= mu * n) return x;
  if (mu * t <= -n) return Vector3d::Zero();
  const double s = (n + mu * t) / (1 + mu * mu);
  return s * (normal + mu / t * tangent);
}

// Dykstra's alternating projections of zero on {G r = w} and on the cones: they end at the nearest point of what these
// have in common (Boyle and Dykstra 1986).
std::vector<Vector3d> by_dykstra(const std::vector<SharedContact>& contacts, std::size_t bodies) {
  const auto count = static_cast<Eigen::Index>(contacts.size());
  Eigen::MatrixXd G(6 * static_cast<Eigen::Index>(bodies), 3 * count);
  std::vector<Vector3d> told;
  for (const SharedContact& contact : contacts) told.push_back(contact.impulse);
  for (Eigen::Index column = 0; column < 3 * count; ++column) {
    std::vector<Vector3d> unit(contacts.size(), Vector3d::Zero());
    unit[static_cast<std::size_t>(column / 3)][column % 3] = 1;
    G.col(column) = sums_of(contacts, unit, bodies);
  }
  const Eigen::VectorXd w = sums_of(contacts, told, bodies);
  const Eigen::MatrixXd inverse = G.completeOrthogonalDecomposition().pseudoInverse();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(3 * count), memory = x;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::VectorXd y = x - inverse * (G * x - w);  // what an affine set remembers changes nothing
    for (Eigen::Index k = 0; k < count; ++k)
      x.segment<3>(3 * k) =
          on_round_cone(y.segment<3>(3 * k) + memory.segment<3>(3 * k), contacts[static_cast<std::size_t>(k)].normal,
                        contacts[static_cast<std::size_t>(k)].along);
    memory += y - x;
  }
  std::vector<Vector3d> impulses;
  for (Eigen::Index k = 0; k < count; ++k) impulses.push_back(x.segment<3>(3 * k));
  return impulses;
}

TEST(LeastNorm, IsWhatAlternatingProjectionsFind) {
  test::Random random(7);
  for (int problem = 0; problem < 10; ++problem) {
    std::vector<SharedContact> contacts;
    for (u32 i = 0; i < 12; ++i) {
      const Vector3 at = random.vector(1), direction = random.vector(1), push = random.vector(1);
      SharedContact contact = support({at[0], at[1], at[2]}, Vector3d::Zero(), random.between(0.1, 0.8),
                                      Vector3d(direction[0], direction[1], direction[2]).normalized());
      contact.body_a = i % 2;
      contact.body_b = i < 6 ? NONE : 1 - i % 2;
      contact.impulse =
          on_round_cone(Vector3d(push[0], push[1], push[2]) + contact.normal, contact.normal, 0.8 * contact.along);
      contacts.push_back(contact);
    }
    const std::vector<Vector3d> impulses = least_norm_impulses(contacts), expected = by_dykstra(contacts, 2);
    for (std::size_t i = 0; i < contacts.size(); ++i) expect_near(impulses[i], expected[i], 1e-6);
  }
}

TEST(LeastNorm, ANormalThatFloatRoundedChangesNoSum) {
  std::vector<SharedContact> feet = four_feet({1.5, 0.5, 0.5, 1.4}, {0.1, 0.2, 0}, 0.5);
  for (SharedContact& foot : feet) foot.normal = Vector3d(1e-5, -1e-5, 1 + 1e-5);
  std::vector<Vector3d> told;
  for (const SharedContact& foot : feet) told.push_back(foot.impulse);
  const Eigen::VectorXd change = sums_of(feet, least_norm_impulses(feet), 1) - sums_of(feet, told, 1);
  EXPECT_LT(change.lpNorm<Eigen::Infinity>(), 1e-12);
}

// ---- in a world

std::vector<SharedContact> shared(std::span<const BodyContact> contacts, World& world) {
  std::vector<SharedContact> all;
  for (const BodyContact& contact : contacts) {
    const auto id = [&](BodyHandle body) { return world.description(body).kind == BODY_DYNAMIC ? body.id : NONE; };
    const auto& [p, n, j] = std::tuple(contact.point, contact.normal, contact.impulse);
    SharedContact one = support({p[0], p[1], p[2]}, {j[0], j[1], j[2]}, 0, {n[0], n[1], n[2]});
    one.body_a = id(contact.a);
    one.body_b = id(contact.b);
    all.push_back(one);
  }
  return all;
}

std::vector<Vector3d> impulses_of(const std::vector<SharedContact>& contacts) {
  std::vector<Vector3d> impulses;
  for (const SharedContact& contact : contacts) impulses.push_back(contact.impulse);
  return impulses;
}

// What is promised of any world: the same on each dynamic body, cones, and no larger norm.
void expect_shared_well(World& world, double friction) {
  const std::vector<BodyContact> told(world.contacts().begin(), world.contacts().end());
  const std::vector<BodyContact> found = world.least_norm_contacts();
  ASSERT_EQ(told.size(), found.size());
  ASSERT_FALSE(told.empty());
  const std::vector<SharedContact> before = shared(told, world), after = shared(found, world);
  double largest = 0;
  for (const SharedContact& contact : before) largest = std::max(largest, contact.impulse.norm());
  const Eigen::VectorXd change = sums_of(before, impulses_of(after), world.bodies().size()) -
                                 sums_of(before, impulses_of(before), world.bodies().size());
  EXPECT_LT(change.lpNorm<Eigen::Infinity>(), 1e-8 * largest);
  EXPECT_LE(squares(impulses_of(after)), squares(impulses_of(before)) * (1 + 1e-9));
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].a, told[i].a);
    EXPECT_EQ(found[i].point, told[i].point);
    const double n_told = before[i].impulse.dot(before[i].normal), n = after[i].impulse.dot(after[i].normal);
    const auto slope = [](const SharedContact& contact, double normal) {
      return normal > 0 ? (contact.impulse - normal * contact.normal).norm() / normal : 0;
    };
    EXPECT_GE(n, -1e-12 * largest);
    if (n > 1e-9 * largest) {
      EXPECT_LE(slope(after[i], n), std::max(friction, slope(before[i], n_told)) + 1e-9);
    }
  }
}

World crate_world(const std::string& precision, double offset, bool sleeping = false) {
  Scene scene = ground_scene();
  if (sleeping) scene.settings.sleeping = SleepSettings{};
  BodyDescription crate = box_at({0, 0, 0.5}, 10);
  crate.shapes[0].offset[0] = -offset;
  scene.bodies.push_back(crate);
  return World(scene, {.device = "reference", .precision = precision});
}

TEST(LeastNorm, ACrateOfAWorldLoadsItsFeetByItsCentreOfMass) {
  for (const std::string precision : {"float", "double"}) {
    for (const double offset : {0.0, 0.1}) {
      for (const bool sleeping : {false, true}) {
        World world = crate_world(precision, offset, sleeping);
        world.step(200);
        EXPECT_EQ(world.is_asleep(world.bodies()[1]), sleeping);
        const std::vector<BodyContact> contacts = world.least_norm_contacts();
        ASSERT_EQ(contacts.size(), 4u);
        double sum = 0;
        for (const BodyContact& contact : contacts) sum += contact.impulse[2];
        const double x = world.pose(world.bodies()[1]).position[0];
        for (const BodyContact& contact : contacts) {  // at -0.5 and 0.5 of the middle, which is `offset` behind x
          const double side = contact.point[0] - x + offset;
          EXPECT_NEAR(contact.impulse[2], sum / 4 * (1 + 4 * offset * side), 2e-4 * sum) << precision << offset;
        }
        expect_shared_well(world, 0.5);
      }
    }
  }
}

TEST(LeastNorm, PilesKeepTheirSums) {
  for (const char* name : {"box_stack", "card_house", "arch"}) {
    SCOPED_TRACE(name);
    const Scene scene = read_scene(name);
    World world(scene, {.device = "reference", .precision = "double"});
    world.step(30);
    double friction = 0;
    for (const Material& material : scene.materials) friction = std::max(friction, material.friction);
    expect_shared_well(world, friction);
  }
}

TEST(LeastNorm, AWorldWithoutContactsHasNone) {
  World world(empty_scene(), in_double());
  world.add(ball_at({0, 0, 0}));
  world.step();
  EXPECT_TRUE(world.least_norm_contacts().empty());
}

TEST(LeastNorm, WhatWasRemovedSinceIsLeftAsItWasTold) {
  World world = crate_world("double", 0);
  const BodyHandle other = world.add(box_at({3, 0, 0.5}, 1));
  world.step(100);
  world.remove(other);
  EXPECT_EQ(world.least_norm_contacts().size(), 8u);
}

}  // namespace
}  // namespace lockstep::least_norm_test
