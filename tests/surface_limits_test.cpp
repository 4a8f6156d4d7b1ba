// How large surfaces may be, what a triangle takes, and that who asks for more hears it at once.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "host/scene/compile.hpp"
#include "host/scene/read.hpp"
#include "tests/refusal.hpp"
#include "tests/surfaces.hpp"

namespace lockstep::surface_limits_test {
namespace {

template <class real>
double bytes_a_triangle(const TriangleMesh& mesh) {
  const std::size_t triangles = mesh.triangles.size();
  BodyDescription ball;
  ball.mass = 1;
  ball.inertia = {1, 1, 1};
  ball.shapes.push_back({.kind = SHAPE_SPHERE, .radius = 0.5});
  Scene scene;
  scene.source = "surface";
  scene.bodies = {surface_body(mesh), ball};
  const InitialState<real> state = compile<real>(scene);
  std::size_t bytes = 0;
  for_each_buffer(state.buffers, [&](Buffer, const auto& elements) { bytes += elements.size() * sizeof(elements[0]); });
  return static_cast<double>(bytes) / static_cast<double>(triangles);
}

TriangleMesh bumps(u32 points) {
  return hills(points, 0.5, [](double x, double y) { return 0.1 * std::sin(3 * x) * std::cos(2 * y); });
}

// All edges of a dome are like roofs, and all corners stick out.
TriangleMesh dome(u32 points) {
  return hills(points, 1, [](double x, double y) { return -0.01 * (x * x + y * y); });
}

// All buffers of a scene, those that a step writes among them.
TEST(SurfaceLimits, BytesATriangle) {
  EXPECT_LE(bytes_a_triangle<float>(bumps(201)), 190);
  EXPECT_LE(bytes_a_triangle<float>(dome(201)), 190);
  EXPECT_LE(bytes_a_triangle<double>(bumps(201)), 350);
  EXPECT_LE(sizeof(FacetLinks), 16u);  // beside its share of the mesh, 24 bytes
}

// The larger surface has the smaller share of edges at its rim, and of what is there once.
TEST(SurfaceLimits, BytesATriangleDoNotGrow) {
  EXPECT_LT(bytes_a_triangle<float>(bumps(301)), bytes_a_triangle<float>(bumps(151)));
}

TEST(SurfaceLimits, HeightsThatAreTooManyAreRefused) {
  const u32 rows = 1001, columns = most_triangles / 2000 + 2;
  std::string row = "[0";
  for (u32 i = 1; i < columns; ++i) row += ",0";
  std::string heights = row + "]";
  for (u32 j = 1; j < rows; ++j) heights += "," + row + "]";
  const std::string text = R"({"description": "a plain", "bodies": [{"type": "static", "shapes": [)"
                           R"({"type": "height_field", "spacing": 1, "heights": [)" +
                           heights + "]}]}]}";
  EXPECT_EQ(
      refusal([&] { parse_scene(text, "plain.json"); }),
      fmt::format("plain.json: /bodies/0/shapes/0/heights: has {} triangles, a surface can have {}; give it fewer, "
                  "or larger ones",
                  2 * (rows - 1) * (columns - 1), most_triangles));
}

// What a file says that it has is refused before the rest is read: here there is none.
TEST(SurfaceLimits, MeshesThatAreTooLargeAreRefusedByTheirHeader) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "lockstep_surface_limits_test";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "large.ply") << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                                         "property float z\nelement face 900000000\n"
                                         "property list uchar int vertex_indices\nend_header\n";
  const std::string source = (folder / "scene.json").string();
  std::ofstream(source) << R"({"description": "a hill", "bodies": [{"type": "static", "shapes": [)"
                        << R"({"type": "mesh", "mesh": "large.ply"}]}]})";
  EXPECT_EQ(
      refusal([&] { read_scene(source); }),
      fmt::format("{}: /bodies/0/shapes/0/mesh: has 900000000 triangles, a surface can have {}; give it fewer, or "
                  "larger ones",
                  source, most_triangles));
  std::filesystem::remove_all(folder);
}

// The surfaces of a scene together, copies of a generator among them.
TEST(SurfaceLimits, CopiesAreCounted) {
  const std::string text = R"({"description": "tiles", "bodies": [{"generator": "grid", "counts": [1000, 1000, 2],)"
                           R"( "spacing": [2, 2, 2], "bodies": [{"type": "static", "shapes": [)"
                           R"({"type": "height_field", "spacing": 1, "heights": [[0, 0, 0, 0], [0, 0, 0, 0]]}]}]}]})";
  EXPECT_EQ(refusal([&] { parse_scene(text, "tiles.json"); }),
            fmt::format("tiles.json: /bodies/0: would bring the scene to 12000000 triangles, its surfaces can have {}; "
                        "make them fewer, or larger",
                        most_triangles));
}

}  // namespace
}  // namespace lockstep::surface_limits_test
