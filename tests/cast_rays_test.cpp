#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "host/backends/device_backend.hpp"
#include "tests/query_worlds.hpp"

namespace lockstep::test::cast_rays_test {
namespace {

template <class real>
class CastRays : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(CastRays, Precisions);

Vector3 along(const RayQuery& ray, double distance) {
  return exact::add(ray.origin, exact::scale(distance / exact::length(ray.direction), ray.direction));
}

// Marches in steps of the distance that is free, which never pass a surface.
std::optional<double> march(const BodyDescription& body, const RayQuery& ray) {
  double distance = 0;
  for (int i = 0; i < 20000 && distance < ray.length; ++i) {
    const double gap = exact_distance(body, along(ray, distance));
    if (gap < 1e-10) return distance;
    distance += gap;
  }
  return std::nullopt;
}

template <class real>
Simulation<real> simulate_bodies(const std::vector<BodyDescription>& bodies) {
  return simulate_in_reference(make_event_worlds<real>({bodies}, 1024));
}

// Every kind of shape against the march; rays that only graze are left out.
TYPED_TEST(CastRays, MeetWhatAMarchMeets) {
  using real = TypeParam;
  Random random(80);
  const double tolerance = sizeof(real) == 4 ? 2e-4 : 1e-7;
  u32 hits[6] = {}, misses = 0;
  for (u32 n = 0; n < 100; ++n) {
    BodyDescription body =
        n % 5 == 4 ? plane_body(random.vector(0.3), random.rotation()) : any_body(random, n / 5, 0.3);
    if (n % 3 == 0) body.shapes[0].offset = random.vector(0.2);
    if (n % 3 == 0 && n % 5 != 4) body.shapes[0].rotation = random.rotation();
    Simulation<real> simulation = simulate_bodies<real>({body});
    std::vector<RayQuery> rays;
    while (rays.size() < 50) {
      RayQuery ray;
      ray.origin = random.vector(3);
      ray.direction = exact::subtract(random.vector(0.6), ray.origin);
      ray.length = 10;
      if (rays.size() % 10 == 0) ray.direction = {0, 0, rays.size() % 20 == 0 ? 1.0 : -1.0};
      if (exact_distance(body, ray.origin) > 1e-3) rays.push_back(ray);
    }
    const std::vector<RayHit> answers = simulation.cast_rays(rays);
    for (u32 k = 0; k < rays.size(); ++k) {
      const RayHit& hit = answers[k];
      const std::optional<double> expected = march(body, rays[k]);
      if (!hit.hit) {
        if (expected) {  // a graze: a little farther in it is outside again
          EXPECT_GT(exact_distance(body, along(rays[k], *expected + 0.02)), -0.02);
        }
        ++misses;
        continue;
      }
      ++hits[body.shapes[0].kind];
      if (!expected) continue;
      // how slowly the ray goes in says how sharp the distance is
      Vector3 gradient;
      for (unsigned i = 0; i < 3; ++i) {
        Vector3 near_point = hit.point, far_point = hit.point;
        near_point[i] -= 1e-5, far_point[i] += 1e-5;
        gradient[i] = (exact_distance(body, far_point) - exact_distance(body, near_point)) / 2e-5;
      }
      const double slope = -exact::dot(gradient, rays[k].direction) / exact::length(rays[k].direction);
      EXPECT_NEAR(exact_distance(body, hit.point), 0, tolerance);
      if (slope < 0.1 || exact::length(gradient) < 0.999) continue;  // grazes, and edges
      EXPECT_NEAR(hit.distance, *expected, tolerance / slope);
      for (unsigned i = 0; i < 3; ++i) EXPECT_NEAR(hit.normal[i], gradient[i], 2e-3);
    }
  }
  for (const ShapeKind kind : {SHAPE_SPHERE, SHAPE_CAPSULE, SHAPE_BOX, SHAPE_CYLINDER, SHAPE_PLANE})
    EXPECT_GT(hits[kind], 100u) << kind;
  EXPECT_GT(misses, 500u);
}

// A cube given by its planes is met where the box is.
TYPED_TEST(CastRays, AHullIsMetByItsPlanes) {
  using real = TypeParam;
  BodyDescription box = box_body({0, 0, 0}, {0.5, 0.5, 0.5});
  InitialState<real> plain = make_event_worlds<real>({{box, sphere_body({9, 9, 9}, 1)}}, 16), state = plain;
  state.features = with(state.features, Feature::hulls);
  state.sizes.hulls = 1;
  state.sizes.hull_faces = 6;
  state.buffers.shape_infos[0].kind = SHAPE_HULL;
  resize(state.buffers, state.sizes, state.features);
  state.buffers.hulls[0] = {0, 8, 0, 6, 0, 12};
  const real half = real(0.5);
  state.buffers.hull_planes = {{1, 0, 0, half},  {-1, 0, 0, half}, {0, 1, 0, half},
                               {0, -1, 0, half}, {0, 0, 1, half},  {0, 0, -1, half}};
  Simulation<real> hull = simulate_in_reference(state), other = simulate_in_reference(plain);
  Random random(81);
  std::vector<RayQuery> rays(200);
  for (RayQuery& ray : rays) {
    ray.origin = random.vector(2);
    ray.direction = random.vector(1);
  }
  const std::vector<RayHit> a = hull.cast_rays(rays), b = other.cast_rays(rays);
  u32 hits = 0;
  for (u32 i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(a[i].hit, b[i].hit);
    EXPECT_EQ(a[i].distance, b[i].distance);
    EXPECT_EQ(a[i].normal, b[i].normal);
    hits += a[i].hit ? 1 : 0;
  }
  EXPECT_GT(hits, 5u);
}

// The nearest one, of two at one place that of smaller index; in the mask, in the world, within the length, no trigger,
// nothing that the ray starts in.
TYPED_TEST(CastRays, TheFirstThatCounts) {
  using real = TypeParam;
  std::vector<BodyDescription> row;
  for (const double x : {9.0, 3.0, 3.0, 6.0, 1.5}) row.push_back(sphere_body({x, 0, 0}, 1));
  row[3].shapes[0].category = 2;
  row[4] = trigger_body(row[4]);
  Simulation<real> simulation =
      simulate_in_reference(make_event_worlds<real>({{sphere_body({2, 0, 0}, 0.5)}, row}, 64));
  RayQuery ray;
  ray.world = 1;
  RayQuery flipped = ray, masked = ray, shorter = ray, inside = ray, elsewhere = ray, behind = ray;
  flipped.origin = {100, 0, 0};
  flipped.direction = {-3, 0, 0};
  masked.mask = 2;
  shorter.length = 1.99;
  inside.origin = {3, 0, 0};
  elsewhere.world = 0;
  behind.direction = {-1, 0, 0};
  const std::vector<RayQuery> rays = {ray, flipped, masked, shorter, inside, elsewhere, behind};
  const std::vector<RayHit> hits = simulation.cast_rays(rays);
  const u32 expected[] = {1, 0, 3, NONE, 3, 0, NONE};
  const double distances[] = {2, 90, 5, 0, 2, 1.5, 0};
  for (u32 i = 0; i < 7; ++i) {
    EXPECT_EQ(hits[i].hit, expected[i] != NONE) << i;
    EXPECT_EQ(hits[i].body, expected[i]) << i;
    EXPECT_EQ(hits[i].distance, distances[i]) << i;
  }
  EXPECT_EQ(hits[1].point, (Vector3{10, 0, 0}));
  EXPECT_EQ(hits[1].normal, (Vector3{1, 0, 0}));
  EXPECT_EQ(simulation.cast_rays(std::span(rays).first(1))[0].body, 1u);  // fewer than before
}

TYPED_TEST(CastRays, RefusesInvalidRays) {
  using real = TypeParam;
  Simulation<real> simulation = simulate_bodies<real>({sphere_body({0, 0, 0}, 1), sphere_body({3, 0, 0}, 1)});
  std::vector<RayQuery> bad(4);
  bad[0].direction = {0, 0, 0};
  bad[1].origin[1] = NAN;
  bad[2].length = -1;
  bad[3].world = 1;
  for (const RayQuery& ray : bad) EXPECT_THROW(simulation.cast_rays(std::span(&ray, 1)), Error);
}

std::vector<std::vector<BodyDescription>> crowded_worlds() {
  std::vector<std::vector<BodyDescription>> worlds(3);
  for (u32 w = 0; w < 3; w += 2) {
    Random random(90 + w);
    for (u32 n = 0; n < 100; ++n) worlds[w].push_back(any_body(random, n, 3));
    worlds[w].push_back(plane_body({0, 0, -2}));
    worlds[w][7] = trigger_body(worlds[w][7]);
  }
  return worlds;
}

template <class real>
void fill_rays(InitialState<real>& state, u32 count) {
  Random random(91);
  for (u32 i = 0; i < count; ++i) {
    const Vector3 from = random.vector(4), to = random.vector(1);
    const double length = exact::length(to);
    Ray<real>& ray = state.buffers.rays[i];
    set(ray.origin, from);
    set(ray.direction, {to[0] / length, to[1] / length, to[2] / length});
    if (i % 10 == 0) set(ray.direction, {0, 0, -1});
    ray.range = real(random.between(1, 20));
    state.buffers.ray_filters[i] = {0, i % 3, random.bits() | (i % 2), 0};
  }
  state.params.queries = count;
}

TYPED_TEST(CastRays, KernelMatchesReference) {
  using real = TypeParam;
  InitialState<real> state = make_query_worlds<real>(crowded_worlds(), 1000, 0);
  fill_rays(state, 900);
  const Buffers<real> after =
      run_one_stage(Stage::cast_rays, state.buffers, state.sizes, state.features, state.params, launches());
  EXPECT_GT(std::count_if(after.ray_shapes.begin(), after.ray_shapes.end(), [](u32 s) { return s != NONE; }), 100);
  EXPECT_EQ(after.ray_shapes[950], NONE);
}

// The kernels of the queries are built when they are wanted, beside those of the step.
TYPED_TEST(CastRays, ARunningSimulationAnswersLikeTheReference) {
  using real = TypeParam;
  const InitialState<real> state =
      make_event_worlds<real>({{plane_body(), sphere_body({0, 0, 1}, 0.5), sphere_body({0.1, 0, 3}, 0.5)}}, 16);
  CheckedBackend<real>* backend = new CheckedBackend<real>(state, test_device());
  Simulation<real> simulation(std::unique_ptr<Backend<real>>(backend), state.params);
  simulation.step();
  EXPECT_FALSE(has(backend->features(), Feature::queries));
  RayQuery down;
  down.origin = {0.2, 0.1, 9};
  down.direction = {0, 0, -1};
  for (u32 count : {1u, 5u, 2u}) {
    const std::vector<RayQuery> rays(count, down);
    for (const RayHit& hit : simulation.cast_rays(rays)) EXPECT_EQ(hit.body, 2u);
    simulation.step();
  }
  VolumeQuery box;
  box.kind = SHAPE_BOX;
  box.center = {0, 0, 0.5};
  box.half_extents = {0.2, 0.2, 0.2};
  const std::vector<Overlap> overlaps = simulation.find_overlaps(std::span(&box, 1));
  ASSERT_EQ(overlaps.size(), 1u);  // the box hangs over the ground, in the lower ball
  EXPECT_EQ(overlaps[0].body, 1u);
  simulation.step();
}

}  // namespace
}  // namespace lockstep::test::cast_rays_test
