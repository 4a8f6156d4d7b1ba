#include "tests/shapes/oracle.hpp"

#include <gtest/gtest.h>

#include "cpu_reference/shapes/pairs.hpp"
#include "tests/shapes/cases.hpp"
#include "tests/shapes/judge.hpp"

namespace lockstep::oracle::oracle_test {
namespace {

using test::Random;
using test::random_rotation;

Body shape(u32 kind, Vector3d center, Vector3d size, Eigen::Quaterniond rotated = Eigen::Quaterniond::Identity()) {
  return {kind, center, rotated.toRotationMatrix(), size, nullptr};
}

TEST(Oracle, KnowsClosedForms) {
  const Body sphere = shape(SHAPE_SPHERE, {0, 0, 3}, {1, 0, 0});
  EXPECT_NEAR(separation(sphere, shape(SHAPE_SPHERE, {0, 3, -1}, {0.5, 0, 0})).distance, 3.5, 1e-10);
  EXPECT_NEAR(separation(sphere, shape(SHAPE_BOX, {0, 0, 0}, {1, 1, 1})).distance, 1, 1e-10);
  EXPECT_NEAR(separation(sphere, shape(SHAPE_BOX, {2, 2, 4}, {1, 1, 1})).distance, std::sqrt(2) - 1, 1e-10);
  EXPECT_NEAR(separation(sphere, shape(SHAPE_CYLINDER, {0, 2, 3}, {1.25, 1, 0})).distance, -0.25, 1e-10);
  EXPECT_NEAR(separation(sphere, shape(SHAPE_CYLINDER, {0, 4, 0}, {1, 1, 0})).distance, std::sqrt(9 + 4) - 1, 1e-9);
  // crossed cylinders, apart by the distance of their axes less the radii
  const Eigen::Quaterniond lying(Eigen::AngleAxisd(two_pi / 4, Vector3d::UnitX()));
  EXPECT_NEAR(
      separation(shape(SHAPE_CYLINDER, {0, 0, 0}, {1, 4, 0}), shape(SHAPE_CYLINDER, {2.5, 0, 0}, {1, 4, 0}, lying))
          .distance,
      0.5, 1e-10);
  // boxes that overlap by their corners: the least way out is along an axis
  EXPECT_NEAR(separation(shape(SHAPE_BOX, {0, 0, 0}, {1, 1, 1}), shape(SHAPE_BOX, {1.5, 1.6, 1.7}, {1, 1, 1})).distance,
              -0.3, 1e-10);
}

// A hull of a box's corners and the box are one shape; a turn of both changes nothing.
TEST(Oracle, AgreesWithItself) {
  Random random(7);
  for (int i = 0; i < 60; ++i) {
    const Vector3d size(random.between(0.2, 1), random.between(0.2, 1), random.between(0.2, 1));
    std::vector<Vector3d> corners;
    for (int k = 0; k < 8; ++k)
      corners.emplace_back(k & 1 ? size.x() : -size.x(), k & 2 ? size.y() : -size.y(), k & 4 ? size.z() : -size.z());
    const Polyhedron polyhedron(corners);
    ASSERT_EQ(polyhedron.normals.size(), 6u);
    ASSERT_EQ(polyhedron.edges.size(), 3u);
    const Body cylinder =
        shape(SHAPE_CYLINDER, Vector3d(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)),
              {random.between(0.2, 1), random.between(0.2, 1), 0}, random_rotation(random));
    const Body box = shape(SHAPE_BOX, {0, 0, 0}, size);
    Body hull = shape(SHAPE_HULL, {0, 0, 0}, size);
    hull.hull = &polyhedron;
    const double expected = separation(cylinder, box).distance;
    EXPECT_NEAR(separation(cylinder, hull).distance, expected, 1e-9);
    const Eigen::Matrix3d rotated = random_rotation(random).toRotationMatrix();
    Body cylinder_rotated = cylinder, box_rotated = box;
    for (Body* body : {&cylinder_rotated, &box_rotated})
      body->axes = rotated * body->axes, body->center = rotated * body->center;
    EXPECT_NEAR(separation(box_rotated, cylinder_rotated).distance, expected, 1e-9);
  }
}

TEST(Oracle, CutsContactPatches) {
  const Body low = shape(SHAPE_BOX, {0, 0, 0}, {1, 1, 1}), high = shape(SHAPE_BOX, {0.5, 0.5, 1.99}, {1, 1, 1});
  const Polygon square = contact_patch(high, low, Vector3d::UnitZ(), 0.995, Vector3d::UnitX(), Vector3d::UnitY());
  EXPECT_NEAR(best_area_of_four(square), 1.5 * 1.5, 0.02);
  const Body coin = shape(SHAPE_CYLINDER, {0, 0, 1.49}, {0.5, 0.5, 0});
  const Polygon disc = contact_patch(coin, low, Vector3d::UnitZ(), 0.995, Vector3d::UnitX(), Vector3d::UnitY());
  EXPECT_NEAR(best_area_of_four(disc), 2 * 0.25, 0.005);  // a square in a circle
}

// Of a regular octagon in the unit circle, of area sqrt(8): every second corner, a square of area 2.
TEST(Oracle, KnowsTheWidestFour) {
  Polygon octagon;
  for (int i = 0; i < 8; ++i) octagon.emplace_back(std::cos(two_pi * i / 8), std::sin(two_pi * i / 8));
  EXPECT_NEAR(area(octagon), std::sqrt(8), 1e-12);
  EXPECT_NEAR(best_area_of_four(octagon), 2, 1e-12);
  EXPECT_NEAR(best_area_of_four_with(octagon[3], octagon), 2, 1e-12);
  // three corners of a square, of which the fourth is left out
  const Polygon square = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  EXPECT_NEAR(best_area_of_four({square[0], square[1], square[2]}) / best_area_of_four(square), 0.5, 1e-12);
  // the middle of a side, and three corners: a quarter is left out
  EXPECT_NEAR(best_area_of_four_with({0.5, 0}, square), 0.75, 1e-12);
}

// A judge that complains of nothing would let everything pass.
TEST(Oracle, ComplainsOfWhatIsWrong) {
  const reference::HullTables<double> none = {};
  const reference::WorldShape<double> low = {{0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1}, 0};
  const reference::WorldShape<double> high = {{0.5, 0.5, 1.9999}, {0, 0, 0, 1}, {1, 1, 1}, 0};
  const reference::Manifold<double> good = reference::collide_shapes(SHAPE_BOX, high, SHAPE_BOX, low, none, 0.1);
  ASSERT_EQ(good.count, 4u);
  const auto complaint = [&](const reference::Manifold<double>& m) -> std::string {
    const Verdict verdict = judge(body(SHAPE_BOX, high), body(SHAPE_BOX, low), m, 0.1);
    EXPECT_TRUE(verdict.wide || m.normal.z < 0.9);
    return verdict.complaints.empty() ? "" : verdict.complaints[0];
  };
  EXPECT_EQ(complaint(good), "");
  reference::Manifold<double> bad = good;
  bad.count = 3;
  EXPECT_EQ(complaint(bad).substr(0, 17), "3 points hold 0.5");
  bad = good;
  bad.points[3].feature = bad.points[0].feature;
  EXPECT_EQ(complaint(bad), "points 0 and 3 have one feature");
  bad = good;
  bad.points[2].anchor_a.x += 2;
  EXPECT_NE(complaint(bad).find("point 2 of 4 is out of its shape by"), std::string::npos);
  bad = good;
  for (auto& point : bad.points) point.anchor_a.z += 3e-5;
  EXPECT_NE(complaint(bad).find("deepest point"), std::string::npos);
  bad = good;
  bad.normal = {0, 0, -1};
  EXPECT_NE(complaint(bad).find("the normal loses"), std::string::npos);
  bad = good;
  bad.normal = {1, 0, 0};
  EXPECT_NE(complaint(bad).find("the normal loses"), std::string::npos);
  bad.count = 0;
  const Verdict unseen = judge(body(SHAPE_BOX, high), body(SHAPE_BOX, low), bad, 0.1);
  ASSERT_EQ(unseen.complaints.size(), 1u);
  EXPECT_EQ(unseen.complaints[0].substr(0, 11), "no manifold");
}

}  // namespace
}  // namespace lockstep::oracle::oracle_test
