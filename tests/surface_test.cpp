// What the triangles of a surface know of each other (host/scene/surface.hpp).
#include "host/scene/surface.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

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
  for (const FacetLinks& facet : surface.facets)
    for (unsigned k = 0; k < 3; ++k) count += (facet.flags & FACET_OWNS_EDGE(k)) != 0;
  return count;
}

int owned_corners(const Surface& surface) {
  int count = 0;
  for (const FacetLinks& facet : surface.facets)
    for (unsigned k = 0; k < 3; ++k) count += (facet.flags & FACET_OWNS_CORNER(k)) != 0;
  return count;
}

bool is_roof(const Surface& surface, u32 t, u32 k) {
  return (surface.facets[t].flags >> FACET_EDGE_SHIFT(k) & 3) == FACET_EDGE_ROOF;
}

bool counts(const Surface& surface, u32 t, u32 k) { return (surface.facets[t].flags & FACET_CORNER_COUNTS(k)) != 0; }

// The triangles that follow a corner around its vertex, until it comes again.
std::multiset<u32> circle(const Surface& surface, u32 t, u32 k) {
  std::multiset<u32> triangles;
  u32 at = FACET_CORNER(t, k);
  do {
    at = next_corner(surface, at >> 2, at & 3);
    triangles.insert(at >> 2);
  } while (at != FACET_CORNER(t, k) && triangles.size() <= 3 * surface.facets.size());
  return triangles;
}

// Those that have a vertex.
std::multiset<u32> all_at(const Surface& surface, u32 vertex) {
  std::multiset<u32> triangles;
  for (u32 t = 0; t < surface.mesh.triangles.size(); ++t)
    for (const u32 corner : surface.mesh.triangles[t])
      if (corner == vertex) triangles.insert(t);
  return triangles;
}

void expect_whole_circles(const Surface& surface) {
  for (u32 t = 0; t < surface.facets.size(); ++t) {
    for (u32 k = 0; k < 3; ++k) {
      if (!counts(surface, t, k)) continue;
      EXPECT_EQ(circle(surface, t, k), all_at(surface, surface.mesh.triangles[t][k]));
    }
  }
}

// A grid of 3 by 4 squares has 24 triangles, 20 vertices and, by Euler, 20 + 24 - 1 edges.
TEST(Surface, FlatGround) {
  const auto surface = made(height_field(std::vector(5, std::vector<double>(4, 0.7)), 0.5));
  ASSERT_EQ(surface->facets.size(), 24u);
  EXPECT_EQ(owned_edges(*surface), 43);
  EXPECT_EQ(owned_corners(*surface), 14);  // those of the rim: nothing sticks out
  for (u32 t = 0; t < surface->facets.size(); ++t) {
    const Vector3 normal = normal_of_facet(*surface, t);
    EXPECT_EQ(normal, (Vector3{0, 0, 1}));
    for (u32 k = 0; k < 3; ++k) {
      const Vector3 across = across_facet(*surface, t, k);
      EXPECT_TRUE(across == normal || across[2] == 0);
      EXPECT_EQ(counts(*surface, t, k), (surface->facets[t].flags & FACET_IS_AT_RIM(k)) != 0);
    }
  }
  expect_whole_circles(*surface);
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
  for (u32 t = 0; t < surface->facets.size(); ++t) {
    for (u32 k = 0; k < 3; ++k) {
      const Vector3 across = across_facet(*surface, t, k), normal = normal_of_facet(*surface, t);
      roofs += is_roof(*surface, t, k);
      corners += counts(*surface, t, k);
      EXPECT_TRUE(is_roof(*surface, t, k) ? exact::dot(across, normal) == 0 : across == normal);
    }
  }
  expect_whole_circles(*surface);
  EXPECT_EQ(roofs, 24);    // each of 12 seen from both sides
  EXPECT_EQ(corners, 36);  // each triangle has three
  for (auto& triangle : cube.triangles) std::swap(triangle[0], triangle[1]);
  const auto room = made(cube);
  EXPECT_EQ(owned_corners(*room), 0);
  for (u32 t = 0; t < room->facets.size(); ++t)
    for (u32 k = 0; k < 3; ++k) EXPECT_EQ(across_facet(*room, t, k), normal_of_facet(*room, t));
}

// On a straight ridge bodies lie over all vertices, and edges tell of it.
TEST(Surface, Ridge) {
  const auto surface = made(height_field({{0, 1, 0}, {0, 1, 0}, {0, 1, 0}}, 1));
  EXPECT_EQ(owned_corners(*surface), 8);  // those of the rim
  int around = 0;
  for (u32 t = 0; t < surface->facets.size(); ++t)
    for (u32 k = 0; k < 3; ++k) around += surface->mesh.triangles[t][k] == 4 && counts(*surface, t, k);
  EXPECT_EQ(around, 6);  // all that meet in the middle know
}

// Two pyramids that lean to each other until their tips meet, and two sheets that meet at a corner: who is asked at the
// shared vertex answers for all that is around it.
TEST(Surface, SeveralFansAtAVertexAreOneCircle) {
  TriangleMesh cones = {{{0, 0, 0}}, {}};
  for (const double x : {-2.0, 2.0}) {
    const u32 first = static_cast<u32>(cones.vertices.size());
    for (const auto& [u, v] : {std::pair(0.5, 0.0), std::pair(0.0, 0.5), std::pair(-0.5, 0.0), std::pair(0.0, -0.5)})
      cones.vertices.push_back({x + u, v, -1});
    for (u32 k = 0; k < 4; ++k) cones.triangles.push_back({0, first + k, first + (k + 1) % 4});
    cones.triangles.push_back({first, first + 2, first + 1});
    cones.triangles.push_back({first, first + 3, first + 2});
  }
  const auto both = made(cones);
  EXPECT_TRUE(counts(*both, 0, 0));
  EXPECT_EQ(circle(*both, 0, 0).size(), 8u);
  EXPECT_EQ(both->edges.size(), 2u);  // one of each fan: what is across is as without the other pyramid
  for (const SurfaceEdge& edge : both->edges) EXPECT_NEAR(exact::length(edge.across), 1, 1e-12);
  expect_whole_circles(*both);
  TriangleMesh sheets = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}}, {{0, 1, 2}, {0, 3, 4}}};
  const auto two = made(sheets);
  EXPECT_EQ(circle(*two, 0, 0), (std::multiset<u32>{0, 1}));
  expect_whole_circles(*two);
  EXPECT_EQ(owned_corners(*two), 5);
}

// Neighbours share the edge that the next corner says, and each looks across it at the other.
TEST(Surface, TheNextCornerIsBeyondTheEdge) {
  const auto surface = made(hills(9, 0.5, [](double x, double y) { return 0.3 * x * y - 0.2 * x * x; }));
  for (u32 t = 0; t < surface->facets.size(); ++t) {
    for (u32 k = 0; k < 3; ++k) {
      if ((surface->facets[t].flags >> FACET_EDGE_SHIFT(k) & 3) == FACET_EDGE_STORED) continue;
      const u32 next = next_corner(*surface, t, k), other = next >> 2, j = next & 3;
      EXPECT_EQ(surface->mesh.triangles[other][j], surface->mesh.triangles[t][k]);
      EXPECT_EQ(surface->mesh.triangles[other][(j + 2) % 3], surface->mesh.triangles[t][(k + 1) % 3]);
      const u32 back = (j + 2) % 3;
      EXPECT_EQ(is_roof(*surface, t, k), is_roof(*surface, other, back));
      if (!is_roof(*surface, t, k)) continue;
      EXPECT_EQ(across_facet(*surface, other, back), normal_of_facet(*surface, t));
    }
  }
  expect_whole_circles(*surface);
}

// Who asks for too much hears it before anything is made of it.
TEST(Surface, TooManyTrianglesAreRefusedWithTheLimit) {
  TriangleMesh mesh;
  mesh.triangles.resize(most_triangles + std::size_t{1});  // of no vertex: none is looked at
  EXPECT_EQ(flaw_of_surface(mesh), fmt::format("has {} triangles, a surface can have {}; give it fewer, or larger ones",
                                               most_triangles + 1, most_triangles));
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
