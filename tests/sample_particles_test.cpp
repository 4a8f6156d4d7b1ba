#include "host/scene/sample_particles.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "host/scene/mass_properties.hpp"
#include "host/scene/mesh.hpp"
#include "host/scene/solid_body.hpp"
#include "host/scene/triangle_mesh.hpp"

namespace lockstep::sample_particles_test {
namespace {

const std::string meshes = LOCKSTEP_SOURCE_DIR "/scenes/meshes/";

ShapeDescription mesh_shape(TriangleMesh mesh) {
  ShapeDescription shape;
  shape.kind = SHAPE_MESH;
  shape.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
  return shape;
}

TriangleMesh torus(double large, double small, u32 around, u32 across) {
  TriangleMesh mesh;
  const auto at = [&](u32 i, u32 j) { return (i % around) * across + j % across; };
  for (u32 i = 0; i < around; ++i) {
    for (u32 j = 0; j < across; ++j) {
      const double u = 2 * M_PI * i / around, v = 2 * M_PI * j / across, r = large + small * std::cos(v);
      mesh.vertices.push_back({r * std::cos(u), r * std::sin(u), small * std::sin(v)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

TriangleMesh cube(double half) {
  TriangleMesh mesh;
  for (u32 i = 0; i < 8; ++i)
    mesh.vertices.push_back({i & 1 ? half : -half, i & 2 ? half : -half, i & 4 ? half : -half});
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

ShapeDescription primitive(ShapeKind kind) {
  ShapeDescription shape;
  shape.kind = kind;
  shape.radius = 0.5;
  shape.half_length = 0.7;
  shape.half_extents = {0.5, 0.7, 1.1};
  return shape;
}

// How deep a point is in a primitive, m; negative outside.
double depth_in(const ShapeDescription& s, const Vector3& p) {
  const double rho = std::hypot(p[0], p[1]), z = std::abs(p[2]);
  switch (s.kind) {
    case SHAPE_BOX:
      return std::min({s.half_extents[0] - std::abs(p[0]), s.half_extents[1] - std::abs(p[1]), s.half_extents[2] - z});
    case SHAPE_CYLINDER: return std::min(s.radius - rho, s.half_length - z);
    case SHAPE_CAPSULE: return s.radius - std::hypot(rho, std::max(z - s.half_length, 0.0));
    default: return s.radius - std::hypot(rho, z);
  }
}

double nearest(const std::vector<Vector3>& points, const Vector3& p) {
  double least = 1e300;
  for (const Vector3& q : points) least = std::min(least, exact::length(exact::subtract(p, q)));
  return least;
}

TEST(MeshMass, OfACubeIsThatOfTheBox) {
  ShapeDescription box = primitive(SHAPE_BOX);
  box.half_extents = {0.3, 0.3, 0.3};
  ShapeDescription mesh = mesh_shape(cube(0.3));
  mesh.offset = box.offset = {1, -2, 0.5};
  const MassProperties a = mass_properties(box, 700), b = mass_properties(mesh, 700);
  EXPECT_NEAR(a.mass, b.mass, 1e-12 * a.mass);
  for (unsigned k = 0; k < 3; ++k) EXPECT_NEAR(a.center[k], b.center[k], 1e-15);
  for (unsigned k = 0; k < 6; ++k) EXPECT_NEAR(a.inertia[k], b.inertia[k], 1e-12 * a.inertia[0]);
}

// V = 2 pi^2 R r^2, I_z = m (R^2 + 3/4 r^2), I_x = m (R^2 / 2 + 5/8 r^2); the polyhedron's error is of second order.
TEST(MeshMass, OfATorusConvergesToTheClosedForm) {
  const double large = 0.35, small = 0.15;
  const auto errors = [&](u32 n) {
    const MassProperties m = mass_properties(mesh_shape(torus(large, small, 2 * n, n)), 1);
    const double mass = 2 * M_PI * M_PI * large * small * small;
    const double about = mass * (large * large + 0.75 * small * small);
    const double across = mass * (0.5 * large * large + 0.625 * small * small);
    return std::array{m.mass / mass - 1, m.inertia[2] / about - 1, m.inertia[0] / across - 1};
  };
  const auto coarse = errors(24), fine = errors(48);
  for (unsigned k = 0; k < 3; ++k) {
    EXPECT_LT(std::abs(coarse[k]), 0.04);
    EXPECT_NEAR(coarse[k] / fine[k], 4, 0.1);
  }
}

TEST(MeshMass, OfASphereConvergesToTheClosedForm) {
  const auto ball = [](u32 n) {  // of rings about z, and two poles
    TriangleMesh mesh;
    mesh.vertices = {{0, 0, -1}, {0, 0, 1}};
    for (u32 i = 1; i < n; ++i)
      for (u32 k = 0; k < 2 * n; ++k)
        mesh.vertices.push_back({std::sin(M_PI * i / n) * std::cos(M_PI * k / n),
                                 std::sin(M_PI * i / n) * std::sin(M_PI * k / n), -std::cos(M_PI * i / n)});
    const auto at = [&](u32 i, u32 k) { return 2 + (i - 1) * 2 * n + k % (2 * n); };
    for (u32 k = 0; k < 2 * n; ++k) {
      mesh.triangles.push_back({0, at(1, k + 1), at(1, k)});
      mesh.triangles.push_back({1, at(n - 1, k), at(n - 1, k + 1)});
      for (u32 i = 1; i + 1 < n; ++i) {
        mesh.triangles.push_back({at(i, k), at(i, k + 1), at(i + 1, k + 1)});
        mesh.triangles.push_back({at(i, k), at(i + 1, k + 1), at(i + 1, k)});
      }
    }
    EXPECT_EQ(flaw_of(mesh), "");
    const MassProperties m = mass_properties(mesh_shape(mesh), 1);
    return std::array{m.mass / (4 * M_PI / 3) - 1, m.inertia[0] / (0.4 * 4 * M_PI / 3) - 1};
  };
  const auto coarse = ball(16), fine = ball(32);
  for (unsigned k = 0; k < 2; ++k) {
    EXPECT_LT(std::abs(coarse[k]), 0.06);
    EXPECT_NEAR(coarse[k] / fine[k], 4, 0.1);
  }
}

TEST(MeshFlaws, EachIsNamed) {
  EXPECT_EQ(flaw_of(cube(1)), "");
  TriangleMesh open = cube(1);
  open.triangles.pop_back();
  EXPECT_NE(flaw_of(open).find("is open"), std::string::npos) << flaw_of(open);
  TriangleMesh flipped = cube(1);
  std::swap(flipped.triangles[3][0], flipped.triangles[3][1]);
  EXPECT_NE(flaw_of(flipped).find("run the same way along the edge"), std::string::npos) << flaw_of(flipped);
  TriangleMesh inside_out = cube(1);
  for (auto& t : inside_out.triangles) std::swap(t[0], t[1]);
  EXPECT_NE(flaw_of(inside_out).find("is inside out, its volume is -8 m^3"), std::string::npos) << flaw_of(inside_out);
  TriangleMesh crossing = cube(1);
  for (const auto& t : cube(1).triangles) crossing.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  for (const Vector3& v : cube(0.7).vertices) crossing.vertices.push_back(exact::add(v, {0.9, 0.3, 0.2}));
  EXPECT_NE(flaw_of(crossing).find("cuts itself"), std::string::npos) << flaw_of(crossing);
  EXPECT_NE(flaw_of({}).find("has no triangles"), std::string::npos);
}

TEST(MeshFlaws, CornersThatAreGivenTwiceAreOne) {
  TriangleMesh soup;
  for (const auto& t : cube(1).triangles) {
    for (const u32 corner : t) soup.vertices.push_back(cube(1).vertices[corner]);
    const u32 n = static_cast<u32>(soup.vertices.size());
    soup.triangles.push_back({n - 3, n - 2, n - 1});
  }
  EXPECT_NE(flaw_of(soup), "");
  EXPECT_EQ(flaw_of(welded(soup)), "");
  EXPECT_EQ(welded(soup).vertices.size(), 8u);
}

TEST(MeshFlaws, TheBuiltInMeshesHaveNone) {
  for (const char* name : {"torus", "gear", "pawn", "blob", "bowl"})
    EXPECT_EQ(flaw_of(welded(read_mesh(meshes + name + ".obj"))), "") << name;
}

// Also where what is below the point, or above it, meets in a corner or an edge right there, whichever way its
// triangles are numbered and cut.
TEST(MeshSearch, PointsAboveCornersAndEdgesAreOutside) {
  for (u32 mirror = 0; mirror < 8; ++mirror) {
    SCOPED_TRACE(mirror);
    TriangleMesh mesh = cube(1);
    for (auto& t : mesh.triangles)
      for (u32& corner : t) corner ^= mirror;  // mirrors it
    if (mirror == 1 || mirror == 2 || mirror == 4 || mirror == 7)
      for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
    ASSERT_EQ(flaw_of(mesh), "");
    const MeshSearch search(mesh, 0.4);
    const double tiny = 1e-16;
    for (const double x : {-1.0, -1 + tiny, -0.5, 0.0, 0.3, 1 - tiny, 1.0})
      for (const double y : {-1.0, -1 + tiny, -0.5, 0.0, 0.3, 1 - tiny, 1.0}) {
        EXPECT_FALSE(search.contains({x, y, 1.2}));
        EXPECT_FALSE(search.contains({x, y, -1.2}));
        const bool is_within = std::abs(x) < 0.9 && std::abs(y) < 0.9;
        if (is_within) {
          EXPECT_TRUE(search.contains({x, y, 0.1}));
        }
      }
  }
}

// Every particle lies within its primitive and touches the surface, and none of the surface is far from one.
TEST(SampleParticles, OfPrimitivesTouchTheSurfaceAndCoverIt) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1.2, 1.2);
  for (const ShapeKind kind : {SHAPE_SPHERE, SHAPE_CAPSULE, SHAPE_BOX, SHAPE_CYLINDER}) {
    SCOPED_TRACE(kind);
    const ShapeDescription shape = primitive(kind);
    const double r = 0.07;
    std::string refusal;
    const auto points = sample_particles(shape, {.radius = r}, refusal);
    EXPECT_EQ(refusal, "");
    for (const Vector3& p : points) ASSERT_NEAR(depth_in(shape, p), r, 1e-12);
    u32 asked = 0;
    while (asked < 2000) {  // random points at the depth of the centres, by bisection towards the middle
      Vector3 p = {uniform(random), uniform(random), uniform(random)};
      if (depth_in(shape, p) > r || depth_in(shape, {0, 0, 0}) < r) continue;
      double low = 0, high = 1;
      for (u32 i = 0; i < 60; ++i) {
        const double middle = (low + high) / 2;
        (depth_in(shape, exact::scale(middle, p)) > r ? low : high) = middle;
      }
      EXPECT_LT(nearest(points, exact::scale(low, p)), 1.6 * r);
      ++asked;
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j)
        ASSERT_GT(exact::length(exact::subtract(points[i], points[j])), 0.5 * r) << i << ' ' << j;
    }
  }
}

TEST(SampleParticles, OfASolidFillIt) {
  const double r = 0.05;
  for (const ShapeKind kind : {SHAPE_SPHERE, SHAPE_CAPSULE, SHAPE_BOX, SHAPE_CYLINDER}) {
    SCOPED_TRACE(kind);
    BodyDescription body;
    body.shapes = {primitive(kind)};
    make_solid_of_mass(body, 2);
    std::string refusal;
    ParticleSampler solid({.radius = r, .sampling = Sampling::solid}), surface({.radius = r});
    const ParticleFit fit = fit_of(body, solid.of(body, refusal), r);
    EXPECT_GT(fit.count, fit_of(body, surface.of(body, refusal), r).count);
    EXPECT_LT(fit.center_error, 0.01 * r);
    EXPECT_LT(fit.inertia_error, 0.12);
    EXPECT_GT(fit_of(body, surface.of(body, refusal), r).inertia_error, 2 * fit.inertia_error) << "a shell is no solid";
  }
}

// How often a mesh goes around a point: 1 inside, 0 outside. The sum of the solid angles of its triangles (Van Oosterom
// and Strackee 1983) asks no ray, and so meets no edge.
double winding_number(const TriangleMesh& mesh, const Vector3& p) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    Vector3 v[3];
    double l[3];
    for (unsigned k = 0; k < 3; ++k) v[k] = exact::subtract(mesh.vertices[t[k]], p), l[k] = exact::length(v[k]);
    const double volume = exact::dot(v[0], exact::cross(v[1], v[2]));
    const double rest = l[0] * l[1] * l[2] + exact::dot(v[0], v[1]) * l[2] + exact::dot(v[1], v[2]) * l[0] +
                        exact::dot(v[2], v[0]) * l[1];
    sum += 2 * std::atan2(volume, rest);
  }
  return sum / (4 * M_PI);
}

TEST(SampleParticles, OfMeshesAreOneRadiusBelowTheSurface) {
  for (const char* name : {"torus", "gear", "pawn", "blob", "bowl"}) {
    SCOPED_TRACE(name);
    const TriangleMesh mesh = welded(read_mesh(meshes + name + ".obj"));
    for (const Sampling sampling : {Sampling::surface, Sampling::solid}) {
      const double r = 0.04;
      std::string refusal;
      const auto points = sample_particles(mesh_shape(mesh), {.radius = r, .sampling = sampling}, refusal);
      EXPECT_EQ(refusal, "");
      ASSERT_GT(points.size(), 50u);
      const MeshSearch search(mesh, r);
      for (const Vector3& p : points) {
        ASSERT_NEAR(winding_number(mesh, p), 1, 1e-9);
        ASSERT_FALSE(search.nearest(p, 0.9999 * r).found);
        if (sampling == Sampling::surface) {
          ASSERT_TRUE(search.nearest(p, 1.0001 * r).found);
        }
      }
    }
  }
}

TEST(SampleParticles, AreTheSameEachTimeAndForCopies) {
  BodyDescription body;
  body.shapes = {mesh_shape(torus(0.35, 0.15, 24, 12)), primitive(SHAPE_BOX)};
  std::string refusal;
  ParticleSampler one({.radius = 0.05}), two({.radius = 0.05});
  EXPECT_EQ(one.of(body, refusal), two.of(body, refusal));
  const BodyDescription copy = body;
  EXPECT_EQ(&one.of(body, refusal), &one.of(copy, refusal));
}

TEST(SampleParticles, WhatIsTooFineIsRefusedAtOnce) {
  std::string refusal;
  EXPECT_TRUE(sample_particles(primitive(SHAPE_BOX), {.radius = 1e-6}, refusal).empty());
  EXPECT_EQ(refusal, "needs about 3.34e+12 particles of the radius 1e-06 m, more than 16777215; make them larger");
  refusal.clear();
  EXPECT_TRUE(sample_particles(mesh_shape(torus(0.35, 0.15, 24, 12)), {.radius = 1e-6}, refusal).empty());
  EXPECT_NE(refusal.find("make them larger"), std::string::npos) << refusal;
}

TEST(SampleParticles, WhatIsTooThinIsRefused) {
  std::string refusal;
  EXPECT_TRUE(sample_particles(primitive(SHAPE_BOX), {.radius = 0.6}, refusal).empty());
  EXPECT_EQ(refusal, "is too thin for particles of the radius 0.6 m; make them 0.5 m at most");
  refusal.clear();
  EXPECT_TRUE(sample_particles(mesh_shape(torus(0.35, 0.15, 24, 12)), {.radius = 0.2}, refusal).empty());
  EXPECT_NE(refusal.find("is too thin near"), std::string::npos) << refusal;
  refusal.clear();
  EXPECT_EQ(sample_particles(primitive(SHAPE_SPHERE), {.radius = 0.5}, refusal), (std::vector<Vector3>{{0, 0, 0}}));
}

}  // namespace
}  // namespace lockstep::sample_particles_test
