// Bodies on surfaces of triangles: as on what the triangles stand for.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "cpu_reference/collide.hpp"
#include "cpu_reference/shapes/overlap.hpp"
#include "host/scene/compile.hpp"
#include "tests/library_worlds.hpp"
#include "tests/shapes/seam_scenes.hpp"
#include "tests/stage_harness.hpp"
#include "tests/surfaces.hpp"

namespace lockstep::facets_test {
namespace {

using namespace seam_scenes;

Scene scene_of(std::vector<BodyDescription> bodies, double friction = 0.5, double dt = 1.0 / 120) {
  Scene scene;
  scene.name = scene.source = "surface";
  scene.settings.dt = dt;
  scene.materials = {{.name = "stuff", .friction = friction, .restitution = 0}};
  scene.bodies = std::move(bodies);
  return scene;
}

std::vector<BodyDescription> sliders() {
  const ShapeDescription rock = {
      .kind = SHAPE_HULL,
      .points = {{0.3, 0, -0.25}, {-0.3, 0.3, -0.25}, {-0.3, -0.3, -0.25}, {0.3, 0, 0.25}, {-0.3, 0, 0.25}}};
  BodyDescription rolling =
      solid({.kind = SHAPE_CYLINDER, .radius = 0.2, .half_length = 0.3}, {0.03, 0.02, 0.2}, {0, 2, 0}, lying);
  rolling.angular_velocity = {-10, 0, 0};
  return {solid(sphere(0.25), {0.03, 0.02, 0.25}, {2, 0.3, 0}),
          solid(box({0.3, 0.2, 0.2}), {0.03, 0.02, 0.2}, {3, 0.4, 0}),
          solid(box({0.05, 0.05, 0.05}), {0.03, 0.02, 0.05}, {3, 0.4, 0}),
          solid({.kind = SHAPE_CAPSULE, .radius = 0.2, .half_length = 0.3}, {0.03, 0.02, 0.2}, {0, 2, 0}, lying),
          rolling,
          solid({.kind = SHAPE_CYLINDER, .radius = 0.2, .half_length = 0.2}, {0.03, 0.02, 0.2}, {2, 0.3, 0}),
          solid(rock, {0.03, 0.02, 0.25}, {2, 0, 0})};
}

// A second of sliding and rolling over a flat ground of triangles is one on a plane: nothing trips at an edge.
TEST(Facets, AFlatGroundIsAPlane) {
  const BodyDescription ground = surface_body(hills(21, 0.5, [](double, double) { return 0.0; }));
  int n = 0;
  for (const BodyDescription& body : sliders()) {
    SCOPED_TRACE(n++);
    World on_plane(scene_of({level_floor(), body}), in_double()), on_facets(scene_of({ground, body}), in_double());
    for (int i = 0; i < 120; ++i) {
      on_plane.step();
      on_facets.step();
      const Pose a = on_plane.pose(on_plane.bodies()[1]), b = on_facets.pose(on_facets.bodies()[1]);
      for (unsigned k = 0; k < 3; ++k) ASSERT_NEAR(a.position[k], b.position[k], 3e-5) << i;
      for (unsigned k = 0; k < 4; ++k) ASSERT_NEAR(a.orientation[k], b.orientation[k], 1e-4) << i;
      for (const BodyContact& contact : on_facets.contacts()) ASSERT_EQ(std::abs(contact.normal[2]), 1) << i;
    }
    EXPECT_GT(std::abs(on_facets.pose(on_facets.bodies()[1]).position[0]) +
                  std::abs(on_facets.pose(on_facets.bodies()[1]).position[1]),
              0.3);
  }
}

// Without friction everything goes down a slope by g sin(alpha), over all edges.
TEST(Facets, ASlopeIsASlope) {
  const double slope = 0.5, sine = slope / std::sqrt(1 + slope * slope), cosine = sine / slope;
  const BodyDescription ground = surface_body(hills(41, 0.5, [&](double x, double y) { return -slope * x + 0 * y; }));
  const Quaternion rotated = exact::rotation({0, 1, 0}, std::sqrt((1 - cosine) / 2), std::sqrt((1 + cosine) / 2));
  for (const ShapeDescription& shape : {sphere(0.2), box({0.3, 0.25, 0.2}), box({1.3, 0.9, 0.2})}) {
    const Vector3 start = {-3 + 0.2 * sine, 0.11, 1.5 + 0.2 * cosine};
    World world(scene_of({ground, solid(shape, start, {0, 0, 0}, rotated)}, 0), in_double());
    world.step(120);
    const Twist v = world.velocity(world.bodies()[1]);
    EXPECT_NEAR(v.linear[0], g * sine * cosine, 1e-6);
    EXPECT_NEAR(v.linear[1], 0, 1e-6);
    EXPECT_NEAR(v.linear[2], -g * sine * sine, 1e-6);
    EXPECT_NEAR(exact::length(v.angular), 0, 1e-6);
  }
}

// A box lies on a ridge, and slides over it without friction; edges and vertices are under it, of both sides. That it
// is pushed to neither side is what the facets know of each other.
TEST(Facets, ABoxOnARidge) {
  const BodyDescription roof = surface_body(hills(9, 0.5, [](double x, double) { return -0.5 * std::abs(x); }));
  const BodyDescription still = solid(box({0.2, 0.2, 0.1}), {0, 0.1, 0.1});
  World resting(scene_of({roof, still}), in_double());
  resting.step(240);
  for (unsigned k = 0; k < 3; ++k) EXPECT_NEAR(resting.pose(resting.bodies()[1]).position[k], still.position[k], 1e-9);
  World world(scene_of({roof, solid(box({0.2, 0.2, 0.1}), {-0.1, 0.1, 0.1}, {1, 0, 0})}, 0, 1.0 / 2400), in_double());
  for (int i = 0; i < 100; ++i) {
    world.step();
    const Twist v = world.velocity(world.bodies()[1]);
    ASSERT_NEAR(v.angular[0], 0, 1e-9) << i;  // it tips over the ridge, and no other way
    ASSERT_NEAR(v.angular[2], 0, 1e-9) << i;
    ASSERT_NEAR(v.linear[1], 0, 1e-9) << i;
    for (const BodyContact& contact : world.contacts()) {
      if (exact::length(contact.impulse) == 0) continue;
      ASSERT_NEAR(contact.point[0], 0, 1e-3) << i;
      ASSERT_NEAR(contact.normal[1], 0, 1e-12) << i;
    }
  }
}

// In a gutter of two slopes: a ball at r sqrt(1 + s^2) above its line, a box on both of its lower edges.
TEST(Facets, InAGutter) {
  const double slope = 0.5;
  const BodyDescription gutter = surface_body(hills(9, 0.5, [&](double x, double) { return slope * std::abs(x); }));
  World world(scene_of({gutter, solid(sphere(0.2), {0.01, -0.9, 0.3}), solid(box({0.2, 0.3, 0.1}), {0.01, 0.4, 0.3})}),
              in_double());
  world.step(360);
  EXPECT_NEAR(world.pose(world.bodies()[1]).position[2], 0.2 * std::sqrt(1 + slope * slope), 2e-4);
  EXPECT_NEAR(world.pose(world.bodies()[2]).position[2], 0.1 + 0.2 * slope, 2e-4);
  EXPECT_LT(exact::length(world.velocity(world.bodies()[2]).linear), 1e-3);
}

// Every place around a cube of triangles at which a ball touches it: one contact is the nearest, and it is that of the
// cube. Others are those of planes that it is over as well.
TEST(Facets, ABallAndACube) {
  const BodyDescription cube = surface_body(cube_mesh(0.5));
  const Scene scene = scene_of({cube, solid(sphere(0.3), {0, 0, 3})});
  const InitialState<double> state = compile<double>(std::span<const Scene>(&scene, 1));
  const reference::HullTables<double> tables = reference::collide_tables(state.buffers);
  test::Random random(11);
  int faces = 0, edges = 0, corners = 0;
  for (int n = 0; n < 5000; ++n) {
    const Vector3 p = random.vector(1.1);
    Vector3 d = {0, 0, 0};  // from the nearest point of the cube
    int beyond = 0;
    for (unsigned k = 0; k < 3; ++k) {
      d[k] = p[k] > 0.5 ? p[k] - 0.5 : p[k] < -0.5 ? p[k] + 0.5 : 0;
      beyond += d[k] != 0;
    }
    const double distance = exact::length(d);
    const bool between = std::any_of(p.begin(), p.end(), [](double x) { return std::abs(std::abs(x) - 0.5) < 2e-3; });
    if (distance < 0.01 || between) continue;  // there facets may speak for each other
    (beyond == 1 ? faces : beyond == 2 ? edges : corners) += 1;
    int nearest = 0;
    for (std::size_t t = 0; t < 12; ++t) {
      const Shape<double>& shape = state.buffers.shapes[t];
      const reference::WorldShape<double> ball = {{p[0], p[1], p[2]}, {0, 0, 0, 1}, {0.3, 0, 0}, 0};
      const reference::WorldShape<double> facet = {{shape.offset[0], shape.offset[1], shape.offset[2]},
                                                   {0, 0, 0, 1},
                                                   {0.5, 0.5, 0.5},
                                                   state.buffers.shape_infos[t].hull};
      const reference::Manifold<double> m =
          reference::collide_shapes(SHAPE_SPHERE, ball, SHAPE_HULL, facet, tables, 10.0);
      if (m.count == 0) continue;
      ASSERT_EQ(m.count, 1u);
      const double gap = reference::gap_at(m, 0) + 0.0;
      ASSERT_GT(gap, distance - 0.3 - 1e-9) << n;
      if (gap > distance - 0.3 + 1e-9) continue;
      EXPECT_NEAR(m.normal.x, d[0] / distance, 1e-9);
      EXPECT_NEAR(m.normal.y, d[1] / distance, 1e-9);
      EXPECT_NEAR(m.normal.z, d[2] / distance, 1e-9);
      ++nearest;
    }
    EXPECT_EQ(nearest, 1) << p[0] << " " << p[1] << " " << p[2];
  }
  EXPECT_GT(std::min(faces, std::min(edges, corners)), 300);
}

// Rods and bars at random on hills and in them: what is told of a facet is of points on the ground over points of the
// body, and an overlap only of points that are under the ground. So nothing is told by what is beside a facet.
TEST(Facets, ContactsAreWhereGroundAndBodyAre) {
  const auto height = [](double x, double y) { return 0.4 * std::sin(1.7 * x) * std::cos(1.3 * y) - 0.05 * x * x; };
  const TriangleMesh mesh = hills(13, 0.5, height);
  const auto ground = [&](double x, double y) {  // of the triangle that is there
    double best = -1e30;
    for (const auto& [i, j, k] : mesh.triangles) {
      const Vector3 &a = mesh.vertices[i], &b = mesh.vertices[j], &c = mesh.vertices[k];
      const double twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
      const double u = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / twice;
      const double v = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / twice;
      if (u > -1e-9 && v > -1e-9 && u + v < 1 + 1e-9) best = a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2]);
    }
    return best;
  };
  std::vector<BodyDescription> bodies = {surface_body(mesh)};
  for (const ShapeDescription& shape :
       {ShapeDescription{.kind = SHAPE_CYLINDER, .radius = 0.09, .half_length = 0.3}, box({0.35, 0.1, 0.06}),
        ShapeDescription{.kind = SHAPE_CAPSULE, .radius = 0.1, .half_length = 0.25},
        ShapeDescription{.kind = SHAPE_HULL,
        .points = {{0.3, 0, 0}, {-0.3, 0.2, 0.1}, {-0.3, -0.2, 0.1}, {0, 0.1, -0.2}, {0, -0.1, -0.2}}}})
    bodies.push_back(solid(shape, {0, 0, 9}));
  const Scene scene = scene_of(bodies);
  const InitialState<double> state = compile<double>(std::span<const Scene>(&scene, 1));
  const reference::HullTables<double> tables = reference::collide_tables(state.buffers);
  const auto in_world = [&](u32 shape, const Vector3& p, const Quaternion& q) {
    const reference::Pose<double> pose = {{p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}};
    return reference::shape_in_world(pose, state.buffers.shapes[shape], state.buffers.shape_infos[shape].hull,
                                     {0, 0, 0});
  };
  test::Random random(21);
  const u32 facets = static_cast<u32>(mesh.triangles.size());
  int separated = 0, deep = 0;
  for (int n = 0; n < 400; ++n) {
    const u32 shape = facets + static_cast<u32>(n) % 4, kind = state.buffers.shape_infos[shape].kind;
    const double x = random.between(-1.5, 1.5), y = random.between(-1.5, 1.5);
    const reference::WorldShape<double> body =
        in_world(shape, {x, y, ground(x, y) + random.between(-0.05, 0.4)}, random.rotation());
    for (u32 t = 0; t < facets; ++t) {
      const reference::WorldShape<double> facet = in_world(t, {0, 0, 0}, {0, 0, 0, 1});
      const bool first = kind < SHAPE_HULL;  // pairs are stored in the order of kinds
      const reference::Manifold<double> m = first
                                                ? reference::collide_shapes(kind, body, SHAPE_HULL, facet, tables, 0.2)
                                                : reference::collide_shapes(SHAPE_HULL, facet, kind, body, tables, 0.2);
      for (u32 k = 0; k < m.count; ++k) {
        const double gap = reference::gap_at(m, k);
        const reference::ManifoldPoint<double>& point = m.points[k];
        const auto on_a = reference::sub3(point.anchor_a, reference::scale3(m.radius_a, m.normal));
        const auto on_b = reference::add3(point.anchor_b, reference::scale3(m.radius_b, m.normal));
        const auto on_body = first ? on_a : on_b, on_ground = first ? on_b : on_a;
        ASSERT_NEAR(on_ground.z, ground(on_ground.x, on_ground.y), 1e-9) << n << " " << t;
        const auto d = reference::sub3(on_a, on_b);
        ASSERT_NEAR(reference::length3(reference::sub3(d, reference::scale3(gap, m.normal))), 0, 1e-2) << n << " " << t;
        if (gap < -1e-3) {
          ASSERT_LT(on_body.z, ground(on_body.x, on_body.y)) << n << " " << t << " " << gap;
        }
        ++(gap < -1e-3 ? deep : separated);
      }
    }
  }
  EXPECT_GT(std::min(separated, deep), 100);
}

// Boxes, capsules and cylinders fall on each side, edge and corner of a cube of triangles as on a cube. What is left of
// the difference is that of more points.
TEST(Facets, ACubeOfTrianglesCarriesWhatACubeCarries) {
  BodyDescription whole = box_at({0, 0, 0.5});
  whole.kind = BODY_STATIC;
  const BodyDescription facets = surface_body(cube_mesh(0.5), {0, 0, 0.5});
  const std::vector<BodyDescription> bodies = {
      solid(box({0.8, 0.2, 0.1}), {0.1, 0.1, 1.1}), solid(box({0.3, 0.3, 0.3}), {0.15, 0.2, 1.3}),
      solid({.kind = SHAPE_CYLINDER, .radius = 0.3, .half_length = 0.2}, {0.2, 0.1, 1.2}),
      solid({.kind = SHAPE_CAPSULE, .radius = 0.1, .half_length = 0.6}, {0.1, 0.05, 1.1}, {0, 0, 0}, lying),
      solid(box({0.1, 0.1, 0.1}), {0.3, 0.3, 1.1}, {0.3, 0, 0})};
  for (std::size_t n = 0; n < bodies.size(); ++n) {
    SCOPED_TRACE(n);
    World on_box(scene_of({whole, bodies[n]}), in_double()), on_facets(scene_of({facets, bodies[n]}), in_double());
    on_box.step(60);
    on_facets.step(60);
    const Pose a = on_box.pose(on_box.bodies()[1]), b = on_facets.pose(on_facets.bodies()[1]);
    for (unsigned k = 0; k < 3; ++k) EXPECT_NEAR(a.position[k], b.position[k], 1e-4);
    for (unsigned k = 0; k < 4; ++k) EXPECT_NEAR(a.orientation[k], b.orientation[k], 1e-4);
  }
}

// What lies wholly in front of a slab is not held by the far side of it, however all is turned in space: a disc that
// slides out over a corner is not torn down.
TEST(Facets, NothingSticksToTheFarSideOfASlab) {
  const ShapeDescription disc = {.kind = SHAPE_CYLINDER, .radius = 0.28, .half_length = 0.15};
  test::Random random(3);
  for (int n = 0; n < 40; ++n) {
    const Quaternion q = random.rotation();
    BodyDescription slab = surface_body(cube_mesh(0.2), exact::rotate(q, {0, 0, -0.2}));
    slab.orientation = q;
    Scene scene = scene_of(
        {slab, solid(disc, exact::rotate(q, {0.28, -0.14, 0.15}), exact::rotate(q, {3.5, -1.7, 0}), q)}, 0.5, 1.0 / 60);
    scene.gravity = exact::rotate(q, {0, 0, -g});
    World world(scene, in_double());
    world.step();
    EXPECT_LT(exact::length(world.velocity(world.bodies()[1]).angular), 1.5) << n;
  }
}

// From below a surface is not there: a ball flies up through it and stays above.
TEST(Facets, ASurfaceHasOneSide) {
  const BodyDescription ground = surface_body(hills(5, 1, [](double, double) { return 0.0; }));
  World world(scene_of({ground, solid(sphere(0.2), {0.3, 0.2, -1}, {0, 0, 7})}, 0), in_double());
  world.step(30);
  const double t = 30.0 / 120;
  EXPECT_NEAR(world.pose(world.bodies()[1]).position[2], -1 + 7 * t - g / 2 * t * (t + 1.0 / 120), 1e-9);
  world.step(300);
  EXPECT_NEAR(world.pose(world.bodies()[1]).position[2], 0.2, 1e-3);
}

// Bullets fly 8 m in a step: onto facets that they are not over at its start, onto a ridge and its vertices. Grounds
// from which they slide off, for a step holds one impact.
TEST(Facets, BulletsDoNotPass) {
  const BodyDescription dome = surface_body(hills(41, 0.5, [](double x, double y) { return -0.03 * (x * x + y * y); }));
  const BodyDescription roof = surface_body(hills(41, 0.5, [](double x, double) { return -0.5 * std::abs(x); }));
  test::Random random(5);
  for (const BodyDescription& ground : {dome, roof}) {
    for (int n = 0; n < 60; ++n) {
      SCOPED_TRACE(n);
      Vector3 target = {random.between(-4, 4), random.between(-4, 4), 0};
      if (n % 3 == 0) target = {0, n % 2 ? 0.5 : 0.6, 0};  // on the ridge: a vertex, an edge
      const Vector3 displacement = {random.between(-3, 3), random.between(-3, 3), random.between(-3, -6)};
      BodyDescription bullet =
          n % 2
              ? solid(sphere(0.02), exact::subtract(target, displacement), exact::scale(100, displacement))
              : solid(box({0.03, 0.02, 0.01}), exact::subtract(target, displacement), exact::scale(100, displacement));
      bullet.continuous = true;
      Scene scene = scene_of({ground, bullet}, 0, 1.0 / 60);
      World world(scene, in_double());
      world.step(2);
      const Vector3 p = world.pose(world.bodies()[1]).position;
      // above the ground that is under it, or out over the end of the ground
      const std::optional<BodyHit> below = world.cast_ray({p[0], p[1], p[2] + 0.01}, {0, 0, -1}, 1e3);
      EXPECT_TRUE(below || std::max(std::abs(p[0]), std::abs(p[1])) > 9.9) << p[0] << " " << p[1] << " " << p[2];
      EXPECT_LT(exact::length(world.velocity(world.bodies()[1]).linear), 100 * exact::length(displacement));
    }
  }
}

// Rays straight down meet the ground at its height, also along edges and through vertices.
TEST(Facets, RaysMeetTheHeightOfTheGround) {
  const auto height = [](double x, double y) { return 0.5 * x - 0.25 * y + (x > 0 ? x : 0); };
  World world(scene_of({surface_body(hills(9, 0.5, height)), solid(sphere(0.1), {50, 0, 5})}), in_double());
  test::Random random(3);
  for (int n = 0; n < 500; ++n) {
    Vector3 p = {random.between(-2, 2), random.between(-2, 2), 9};
    if (n % 4 == 1) p[0] = 0.5 * std::floor(2 * p[0]);
    if (n % 4 == 2) p = {0.5 * std::floor(2 * p[0]), 0.5 * std::floor(2 * p[1]), 9};
    if (n % 4 == 3) p[1] = p[0];
    const std::optional<BodyHit> hit = world.cast_ray(p, {0, 0, -1}, 20);
    ASSERT_TRUE(hit.has_value()) << p[0] << " " << p[1];
    EXPECT_NEAR(hit->distance, 9 - height(p[0], p[1]), 1e-12);
    EXPECT_FALSE(world.cast_ray({p[0], p[1], -9}, {0, 0, 1}, 30).has_value());  // from below there is nothing
  }
  EXPECT_EQ(world.overlapping_sphere({1, 1, height(1, 1) + 0.3}, 0.4).size(), 1u);
  EXPECT_TRUE(world.overlapping_sphere({1, 1, height(1, 1) + 0.8}, 0.2).empty());
  EXPECT_EQ(world.overlapping_box({{-1, -1, height(-1, -1) + 0.2}, {0, 0, 0, 1}}, {0.1, 0.1, 0.25}).size(), 1u);
}

// All kinds of bodies at once, fast ones among them, on hills that stand and hills that are moved: with lanes and
// without, found by the grid and by the tree.
template <class real>
class FacetTwins : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(FacetTwins, Precisions);

TYPED_TEST(FacetTwins, KernelMatchesReference) {
  using real = TypeParam;
  const auto height = [](double x, double y) { return 0.4 * std::floor(3 * std::sin(2 * x) * std::cos(1.7 * y)) / 3; };
  std::vector<BodyDescription> bodies = {surface_body(hills(9, 0.5, height))};
  bodies.push_back(surface_body(cube_mesh(0.4), {0.2, 0.1, 0.5}));
  bodies.back().kind = BODY_KINEMATIC;
  bodies.back().angular_velocity = {1, 2, 3};
  test::Random random(8);
  for (int n = 0; n < 5; ++n) {
    for (BodyDescription body : sliders()) {
      body.position = exact::add(random.vector(1.5), {0, 0, 1.8});
      body.velocity = exact::add(random.vector(n == 4 ? 60 : 2), {0, 0, -3});
      body.angular_velocity = random.vector(n == 4 ? 30 : 2);
      body.orientation = random.rotation();
      body.continuous = n == 4;
      bodies.push_back(body);
    }
  }
  for (const BroadPhase broad_phase : {BroadPhase::grid, BroadPhase::bvh}) {
    Scene scene = scene_of(bodies, 0.5, 1.0 / 60);
    scene.settings.broad_phase = broad_phase;
    const InitialState<real> state = compile<real>(std::span<const Scene>(&scene, 1));
    expect_twins_agree(state, broad_phase == BroadPhase::grid ? 12 : 4, launch_options({{1, 0}, {16, 0}}));
  }
}

TEST(Facets, InvalidSurfacesAreRefused) {
  BodyDescription moving = surface_body(cube_mesh(0.5));
  moving.kind = BODY_DYNAMIC;
  moving.mass = 1;
  moving.inertia = {1, 1, 1};
  EXPECT_EQ(refusal([&] { World world(scene_of({moving})); }),
            "body: has facets of a surface, and only static and kinematic bodies may");
  BodyDescription bare;
  bare.kind = BODY_STATIC;
  bare.shapes.push_back({.kind = SHAPE_FACET});
  EXPECT_EQ(refusal([&] { World world(scene_of({bare})); }),
            "body: has facets of no surface; make_surface() makes one");
}

}  // namespace
}  // namespace lockstep::facets_test
