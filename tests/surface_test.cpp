// What the triangles of a surface know of each other (host/scene/surface.hpp).
#include "host/scene/surface.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/surfaces.hpp"

namespace lockstep::surface_test {
namespace {

std::shared_ptr<const Surface> made(const TriangleMesh& mesh) {
  std::string flaw;
  std::shared_ptr<const Surface> surface = make_surface(mesh, flaw);
  EXPECT_EQ(flaw, "");
  return surface;
}

std::string flaw_of_surface(const TriangleMesh& mesh) {
  std::string flaw;
  EXPECT_EQ(make_surface(mesh, flaw), nullptr);
  return flaw;
}

int owned_edges(const Surface& surface) {
  int count = 0;
  for (const Facet& facet : surface.facets)
    for (unsigned k = 0; k < 3; ++k) count += facet.owned >> k & 1;
  return count;
}

int owned_corners(const Surface& surface) {
  int count = 0;
  for (const Facet& facet : surface.facets)
    for (unsigned k = 0; k < 3; ++k) count += facet.owned >> (3 + k) & 1;
  return count;
}

// A grid of 3 by 4 squares has 24 triangles, 20 vertices and, by Euler, 20 + 24 - 1 edges.
TEST(Surface, FlatGround) {
  const auto surface = made(height_field(std::vector(5, std::vector<double>(4, 0.7)), 0.5));
  ASSERT_EQ(surface->facets.size(), 24u);
  EXPECT_EQ(owned_edges(*surface), 43);
  EXPECT_EQ(owned_corners(*surface), 14);  // those of the rim: nothing sticks out
  for (const Facet& facet : surface->facets) {
    EXPECT_EQ(facet.normal, (Vector3{0, 0, 1}));
    for (const Vector3& across : facet.across) EXPECT_TRUE(across == facet.normal || across[2] == 0);
    for (unsigned k = 0; k < 3; ++k) EXPECT_EQ(facet.around[k].empty(), (facet.rim >> k & 1) == 0);
  }
  const std::vector<Vector3>& vertices = surface->mesh.vertices;
  EXPECT_EQ(vertices.front(), (Vector3{-0.75, -1, 0.7}));
  EXPECT_EQ(vertices.back(), (Vector3{0.75, 1, 0.7}));
}

// All edges of a cube but the diagonals are like roofs, and all corners stick out; turned inside out none is.
TEST(Surface, Cube) {
  TriangleMesh cube = cube_mesh(0.5);
  const auto surface = made(cube);
  EXPECT_EQ(owned_edges(*surface), 18);
  EXPECT_EQ(owned_corners(*surface), 8);
  int roofs = 0, corners = 0;
  for (std::size_t t = 0; t < surface->facets.size(); ++t) {
    for (unsigned k = 0; k < 3; ++k) {
      const Facet& facet = surface->facets[t];
      roofs += facet.across[k] != facet.normal;
      corners += !facet.around[k].empty();
      EXPECT_TRUE(facet.across[k] == facet.normal || exact::dot(facet.across[k], facet.normal) == 0);
    }
  }
  EXPECT_EQ(roofs, 24);    // each of 12 seen from both sides
  EXPECT_EQ(corners, 36);  // each triangle has three
  for (auto& triangle : cube.triangles) std::swap(triangle[0], triangle[1]);
  const auto room = made(cube);
  EXPECT_EQ(owned_corners(*room), 0);
  for (const Facet& facet : room->facets)
    for (const Vector3& across : facet.across) EXPECT_EQ(across, facet.normal);
}

// On a straight ridge bodies lie over all vertices, and edges tell of it.
TEST(Surface, Ridge) {
  const auto surface = made(height_field({{0, 1, 0}, {0, 1, 0}, {0, 1, 0}}, 1));
  EXPECT_EQ(owned_corners(*surface), 8);  // those of the rim
  int around = 0;
  for (std::size_t t = 0; t < surface->facets.size(); ++t)
    for (unsigned k = 0; k < 3; ++k)
      around += surface->mesh.triangles[t][k] == 4 && !surface->facets[t].around[k].empty();
  EXPECT_EQ(around, 6);  // all that meet in the middle know
}

TEST(Surface, FlawsAreReportedWithAPosition) {
  EXPECT_EQ(flaw_of_surface({}), "has no triangles; give a mesh that has");
  EXPECT_EQ(flaw_of_surface({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}}, {{0, 1, 3}, {0, 2, 1}}}),
            "has a triangle without area, 1 at (0, 0, 0); remove it");
  const std::string flaw = flaw_of_surface({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2}, {1, 2, 3}}});
  EXPECT_EQ(flaw.rfind("its triangles 0 and 1 run the same way along the edge from (1, 0, 0) to (0, 1, 0)", 0), 0u)
      << flaw;
}

}  // namespace
}  // namespace lockstep::surface_test
