#include "host/scene/hull.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "host/error.hpp"
#include "host/scene/compile.hpp"
#include "host/scene/few_corners.hpp"
#include "host/scene/mass_properties.hpp"
#include "host/scene/read.hpp"
#include "include/lockstep/world.hpp"
#include "tests/shapes/oracle.hpp"
#include "tests/worlds.hpp"

namespace lockstep::test::hull_test {
namespace {

ConvexHull hull_of(const std::vector<Vector3>& points) {
  std::string refusal;
  ConvexHull hull = convex_hull(points, refusal);
  EXPECT_EQ(refusal, "");
  return hull;
}

std::string refusal_of(const std::vector<Vector3>& points) {
  std::string refusal;
  EXPECT_TRUE(convex_hull(points, refusal).vertices.empty());
  return refusal;
}

std::vector<Vector3> box_corners(const Vector3& half) {
  std::vector<Vector3> corners;
  for (int k = 0; k < 8; ++k)
    corners.push_back({k & 1 ? half[0] : -half[0], k & 2 ? half[1] : -half[1], k & 4 ? half[2] : -half[2]});
  return corners;
}

std::vector<Vector3> cloud(u32 seed, int count, double size) {
  Random random(seed);
  std::vector<Vector3> points;
  for (int i = 0; i < count; ++i) points.push_back(random.vector(size));
  return points;
}

// Euler's formula, edges with their faces, planes that no vertex is outside of.
void expect_sound(const ConvexHull& hull) {
  EXPECT_EQ(hull.vertices.size() + hull.faces.size(), hull.edges.size() + 2);
  for (std::size_t f = 0; f < hull.faces.size(); ++f) {
    EXPECT_NEAR(exact::length(hull.planes[f].normal), 1, 1e-14);
    for (const Vector3& v : hull.vertices) {
      EXPECT_LE(exact::dot(hull.planes[f].normal, v), hull.planes[f].offset + 4 * coplanar);
    }
    for (const u32 v : hull.faces[f]) {
      EXPECT_NEAR(exact::dot(hull.planes[f].normal, hull.vertices[v]), hull.planes[f].offset, 4 * coplanar);
    }
  }
  const auto follows = [&](u32 face, u32 a, u32 b) {
    const std::vector<u32>& f = hull.faces[face];
    for (std::size_t i = 0; i < f.size(); ++i)
      if (f[i] == a && f[(i + 1) % f.size()] == b) return true;
    return false;
  };
  for (const HullEdge& e : hull.edges) {
    EXPECT_TRUE(follows(e.face_left, e.vertex_a, e.vertex_b));
    EXPECT_TRUE(follows(e.face_right, e.vertex_b, e.vertex_a));
    // what the search for crossing edges builds on
    const Vector3 along = exact::subtract(hull.vertices[e.vertex_b], hull.vertices[e.vertex_a]);
    EXPECT_GT(exact::dot(exact::cross(hull.planes[e.face_left].normal, hull.planes[e.face_right].normal), along), 0);
  }
}

TEST(ConvexHull, ABoxHasSixFaces) {
  std::vector<Vector3> points = box_corners({1, 2, 3});
  points.push_back({1, 0.5, -0.25});  // on a face
  points.push_back({1, 2, 0});        // on an edge
  points.push_back({0, 0, 0});        // inside
  points.push_back(points[3]);        // twice
  const ConvexHull hull = hull_of(points);
  EXPECT_EQ(hull.vertices.size(), 8u);
  EXPECT_EQ(hull.faces.size(), 6u);
  EXPECT_EQ(hull.edges.size(), 12u);
  for (const auto& face : hull.faces) EXPECT_EQ(face.size(), 4u);
  expect_sound(hull);
}

TEST(ConvexHull, EqualPointsInAnyOrderGiveEqualTables) {
  for (u32 seed = 1; seed < 20; ++seed) {
    std::vector<Vector3> points = cloud(seed, 30, 1);
    const ConvexHull first = hull_of(points);
    expect_sound(first);
    std::reverse(points.begin(), points.end());
    std::rotate(points.begin(), points.begin() + 7, points.end());
    const ConvexHull second = hull_of(points);
    EXPECT_EQ(first.vertices, second.vertices);
    EXPECT_EQ(first.faces, second.faces);
    for (std::size_t f = 0; f < first.planes.size(); ++f) EXPECT_EQ(first.planes[f].offset, second.planes[f].offset);
  }
}

// All triples of points tried, in tests/shapes/oracle.hpp.
TEST(ConvexHull, AgreesWithTheOracle) {
  for (u32 seed = 30; seed < 40; ++seed) {
    const std::vector<Vector3> points = cloud(seed, 20, 1);
    std::vector<oracle::Vector3d> same;
    for (const Vector3& p : points) same.emplace_back(p[0], p[1], p[2]);
    const oracle::Polyhedron polyhedron(same);
    const ConvexHull hull = hull_of(points);
    ASSERT_EQ(hull.planes.size(), polyhedron.normals.size());
    for (const ConvexHull::Plane& plane : hull.planes) {
      const oracle::Vector3d n(plane.normal[0], plane.normal[1], plane.normal[2]);
      EXPECT_TRUE(std::ranges::any_of(polyhedron.normals, [&](const auto& m) { return (m - n).norm() < 1e-9; }));
    }
  }
}

TEST(ConvexHull, RefusesWhatIsNoSolid) {
  EXPECT_EQ(refusal_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}),
            "a hull needs at least 4 points that differ and are not in one plane, has 3; add some");
  EXPECT_EQ(refusal_of({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 1, 0}}),
            "a hull needs at least 4 points that differ and are not in one plane, has 3; add some");
  EXPECT_EQ(refusal_of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {5, 0, 0}}),
            "its points lie on a line; move some of them apart");
  EXPECT_EQ(refusal_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 1e-6}}),
            "its points lie in a plane; give it a thickness, or use a box");
  EXPECT_EQ(refusal_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, std::nan("")}}),
            "its points must be finite and below 1e15 m, one has the coordinate nan");
  std::vector<Vector3> ball = cloud(3, 400, 1);
  for (Vector3& p : ball) p = exact::unit(p);
  EXPECT_EQ(refusal_of(ball), "its hull has 400 corners, it can have 128; give fewer points");
}

TEST(ConvexHull, MassAndMomentsAreThoseOfTheSolid) {
  ShapeDescription hull;
  hull.kind = SHAPE_HULL;
  hull.points = box_corners({1, 2, 3});
  ShapeDescription box;
  box.kind = SHAPE_BOX;
  box.half_extents = {1, 2, 3};
  const MassProperties expected = mass_properties(box, 7), found = mass_properties(hull, 7);
  EXPECT_NEAR(found.mass, expected.mass, 1e-12 * expected.mass);
  for (unsigned k = 0; k < 6; ++k) EXPECT_NEAR(found.inertia[k], expected.inertia[k], 1e-12 * expected.inertia[0]);

  // the tetrahedron of the unit vectors: V = 1/6, centre at 1/4, moments 3/80 m about its centre with products -m/80
  hull.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const MassProperties corner = mass_properties(hull, 6);
  EXPECT_NEAR(corner.mass, 1, 1e-14);
  for (unsigned k = 0; k < 3; ++k) EXPECT_NEAR(corner.center[k], 0.25, 1e-14);
  for (unsigned k = 0; k < 3; ++k) EXPECT_NEAR(corner.inertia[k], 6.0 / 80, 1e-14);
  for (unsigned k = 3; k < 6; ++k) EXPECT_NEAR(corner.inertia[k], 1.0 / 80, 1e-14);
}

// A sheet of 2 x 2 x 0.0002 m has the mass of a box of that size, falls on a floor, from level or tilted, and rests
// there as the box does.
TEST(ConvexHull, AThinSheetIsASolid) {
  const Vector3 half = {1, 1, 1e-4};
  EXPECT_EQ(hull_of(box_corners(half)).faces.size(), 6u);
  EXPECT_EQ(hull_of(box_corners({1e-4, 1, 1e-4})).faces.size(), 6u);
  ShapeDescription sheet;
  sheet.kind = SHAPE_HULL;
  ASSERT_EQ(set_hull(box_corners(half), sheet), "");
  const ShapeDescription box = {.kind = SHAPE_BOX, .half_extents = half};
  for (const char* precision : {"float", "double"}) {
    for (const double tilt : {0.0, 0.2}) {
      const auto after = [&](const ShapeDescription& shape) {
        Scene scene;
        scene.name = scene.source = "sheet";
        scene.bodies.emplace_back();
        scene.bodies[0].kind = BODY_STATIC;
        scene.bodies[0].shapes.push_back({.kind = SHAPE_PLANE});
        BodyDescription body;
        body.shapes.push_back(shape);
        make_solid(body, 2700);
        EXPECT_NEAR(body.mass, 2700 * 2 * 2 * 2e-4, 1e-9);
        EXPECT_NEAR(body.inertia[0], body.mass / 3, 1e-6);
        body.position = {0, 0, 0.3};
        body.orientation = {std::sin(tilt / 2), 0, 0, std::cos(tilt / 2)};
        scene.bodies.push_back(body);
        World world(scene, {.device = "reference", .precision = precision});
        world.step(300);
        return std::pair(world.pose(world.bodies()[1]), world.velocity(world.bodies()[1]));
      };
      const auto [pose, velocity] = after(sheet);
      const auto [pose_of_box, velocity_of_box] = after(box);
      EXPECT_NEAR(pose.position[2], 1e-4, 1e-5) << precision << " " << tilt;
      EXPECT_NEAR(pose.position[2], pose_of_box.position[2], 1e-5) << precision << " " << tilt;
      EXPECT_NEAR(std::hypot(pose.orientation[0], pose.orientation[1]), 0, 1e-5) << precision << " " << tilt;
      EXPECT_LT(exact::length(velocity.linear) + exact::length(velocity.angular), 1e-4) << precision << " " << tilt;
    }
  }
}

TEST(ConvexHull, CopiesShareATable) {
  Scene scene;
  scene.source = "test";
  for (int i = 0; i < 5; ++i) {
    BodyDescription body;
    body.mass = 1;
    body.inertia = {1, 1, 1};
    ShapeDescription hull;
    hull.kind = SHAPE_HULL;
    hull.points = box_corners({1, 2, i == 3 ? 4.0 : 3.0});
    body.shapes.push_back(hull);
    scene.bodies.push_back(body);
  }
  const InitialState<float> state = compile<float>(scene);
  EXPECT_EQ(state.sizes.hulls, 2u);
  EXPECT_EQ(state.buffers.shape_infos[4].hull, 0u);
  EXPECT_EQ(state.buffers.shape_infos[3].hull, 1u);
  EXPECT_EQ(state.buffers.hulls[1].first_vertex, 8u);
  EXPECT_EQ(state.buffers.shapes[3].size[2], 4);
  EXPECT_EQ(state.buffers.hull_planes.size(), 12u);
}

// A scene and a mesh beside it.
TEST(ConvexHull, IsReadFromAMesh) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "lockstep_hull_test";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "tent.obj") << "v 0 0 0\nv 2 0 0\nv 2 4 0\nv 0 4 0\nv 1 2 3\n"
                                        "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 4 3 2\nf 4 2 1\n";
  const auto write =
      [&](const std::string& shape) {
        std::ofstream(folder / "scene.json")
            << R"({"description": "a tent", "bodies": [{"density": 1, "shapes": [{"type": "hull", )" << shape
            << "}]}]}";
      };
  write(R"("mesh": "tent.obj", "scale": 0.5)");
  const Scene scene = read_scene((folder / "scene.json").string());
  EXPECT_EQ(scene.bodies[0].shapes[0].points.size(), 5u);
  EXPECT_NEAR(scene.bodies[0].mass, 1, 1e-6);  // a third of 2 m^2 times 1.5 m
  EXPECT_NEAR(scene.bodies[0].position[2], 1.5 / 4, 1e-6);
  for (const auto& [shape, message] :
       {std::pair{R"("mesh": "hut.obj")", "/mesh: names no file"},
        {R"("points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])", "/points: its points lie in a plane"},
        {R"("mesh": "scene.json")", "/mesh: cannot be read as a mesh"},
        {R"("radius": 1, "mesh": "tent.obj")", "/radius: does not belong to a hull"}}) {
    write(shape);
    try {
      read_scene((folder / "scene.json").string());
      ADD_FAILURE() << shape;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  }
  std::filesystem::remove_all(folder);
}

// Points of an ellipsoid: all of them are corners.
std::vector<Vector3> round_cloud(int count, const Vector3& half) {
  std::vector<Vector3> points;
  for (Vector3 p : cloud(7, count, 1)) {
    p = exact::unit(p);
    points.push_back({half[0] * p[0] + 10, half[1] * p[1], half[2] * p[2]});
  }
  return points;
}

TEST(FewCorners, HullARoundCloudNearly) {
  const Vector3 half = {1, 0.2, 0.05};
  std::vector<Vector3> all = round_cloud(5000, half);
  const std::vector<Vector3> few = few_corners(all);
  EXPECT_EQ(few.size(), most_hull_vertices);
  const ConvexHull hull = hull_of(few);
  EXPECT_EQ(hull.vertices.size(), most_hull_vertices);
  // in parts of its half sizes, as the ball of radius 1 that it is then
  std::vector<Vector3> ball = few;
  for (Vector3& p : ball) p = {(p[0] - 10) / half[0], p[1] / half[1], p[2] / half[2]};
  double least = 1;
  for (const ConvexHull::Plane& plane : hull_of(ball).planes) least = std::min(least, plane.offset);
  EXPECT_GT(least, 0.96);
  EXPECT_LT(least, 0.98);
  std::reverse(all.begin(), all.end());
  EXPECT_EQ(few_corners(all), few);
}

TEST(FewCorners, LeaveWhatHasFewAlone) {
  std::vector<Vector3> points = box_corners({1, 2, 3});
  EXPECT_EQ(few_corners(points), points);
  for (const Vector3& p : cloud(3, 5000, 0.9)) points.push_back(p);
  EXPECT_EQ(hull_of(few_corners(points)).vertices, hull_of(points).vertices);
  points[20][1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(few_corners(points).size(), points.size()) << "to be refused";
}

}  // namespace
}  // namespace lockstep::test::hull_test
