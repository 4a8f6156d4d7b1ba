#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "tests/collision_states.hpp"

namespace lockstep::test::update_bounds_test {
namespace {

template <class real>
class UpdateBounds : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(UpdateBounds, Precisions);

BodyDescription compound(Random& random) {
  BodyDescription body = sphere_body(random.vector(10), random.between(0.1, 1), random.vector(20));
  body.angular_velocity = random.vector(50);
  body.shapes[0].offset = random.vector(2);
  return body;
}

template <class real>
real max_extent(const InitialState<real>& state) {
  return real(std::bit_cast<float>(state.buffers.counters[COUNTER_MAX_EXTENT]));
}

// A body that turns at a constant rate about its centre of mass, which moves on a line: the shape's centre at time t is
// x + v t + R(w t) o, by Rodrigues' formula in double. The bound must hold the sphere at all times of the step.
TYPED_TEST(UpdateBounds, EncloseTheSphereForTheWholeStep) {
  using real = TypeParam;
  Random random(4);
  std::vector<BodyDescription> bodies;
  for (int n = 0; n < 200; ++n) bodies.push_back(compound(random));
  InitialState<real> state = make_worlds<real>({bodies}, 16);
  state.params.substeps = 3;
  run_reference(state, {Stage::update_bounds});
  const double h = 3 * double(state.params.dt);
  for (u32 i = 0; i < bodies.size(); ++i) {
    const Bound<real> bound = state.buffers.bounds[i];
    const Vector3 &o = bodies[i].shapes[0].offset, &w = bodies[i].angular_velocity;
    const double rate = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    const Vector3 k = {w[0] / rate, w[1] / rate, w[2] / rate};
    const Vector3 cross = {k[1] * o[2] - k[2] * o[1], k[2] * o[0] - k[0] * o[2], k[0] * o[1] - k[1] * o[0]};
    const double along = k[0] * o[0] + k[1] * o[1] + k[2] * o[2];
    const double center[3] = {bound.center[0], bound.center[1], bound.center[2]};
    for (int n = 0; n <= 20; ++n) {
      const double t = h * n / 20, c = std::cos(rate * t), s = std::sin(rate * t);
      double squared_distance = 0;
      for (int a = 0; a < 3; ++a) {
        const double x =
            bodies[i].position[a] + bodies[i].velocity[a] * t + c * o[a] + s * cross[a] + (1 - c) * along * k[a];
        squared_distance += (x - center[a]) * (x - center[a]);
      }
      EXPECT_LE(std::sqrt(squared_distance) + bodies[i].shapes[0].radius, bound.extent + 1e-5);
    }
    EXPECT_LE(bound.extent, max_extent(state));
  }
}

// Without rotation the extent is r + h |v| and half of a margin that is given, and nothing is wasted.
TYPED_TEST(UpdateBounds, AreAsLargeAsTheMotionNeeds) {
  using real = TypeParam;
  InitialState<real> state = make_worlds<real>({{sphere_body({1, 2, 3}, 0.5, {3, 0, 4}), plane_body()}}, 16);
  state.params.dt = real(0.25);
  state.params.margin = real(0.5);
  run_reference(state, {Stage::update_bounds});
  const auto& bounds = state.buffers.bounds;
  EXPECT_EQ(bounds[0].center[0], 1);
  EXPECT_EQ(bounds[0].center[1], 2);
  EXPECT_EQ(bounds[0].center[2], 3);
  EXPECT_EQ(bounds[0].extent, real(2));
  EXPECT_EQ(bounds[1].extent, 0);
  EXPECT_GE(max_extent(state), real(2));
  EXPECT_LE(max_extent(state), real(2) * real(1.00001));
  EXPECT_EQ(state.buffers.counters[COUNTER_STATUS], 0u);
}

TYPED_TEST(UpdateBounds, NameTheFirstBodyWithoutAFinitePosition) {
  using real = TypeParam;
  std::vector<BodyDescription> bodies(5, sphere_body({1, 2, 3}, 0.5));
  InitialState<real> state = make_worlds<real>({bodies}, 16);
  state.params.margin = 0;
  state.buffers.positions[4].x = std::numeric_limits<real>::infinity();
  state.buffers.positions[2].y = std::numeric_limits<real>::quiet_NaN();
  run_reference(state, {Stage::update_bounds});
  EXPECT_EQ(state.buffers.counters[COUNTER_STATUS], u32(STATUS_OUT_OF_GRID));
  EXPECT_EQ(NONE - state.buffers.counters[COUNTER_BAD_BODY], 2u);
  EXPECT_EQ(state.buffers.bounds[2].extent, 0);
  EXPECT_EQ(state.buffers.bounds[3].extent, real(0.5));
  EXPECT_LE(max_extent(state), real(0.50001));
}

// Points of the surface: none is outside of the box, and some touch each of its sides.
template <class real>
void expect_tight_box(const BodyDescription& body, const std::vector<Vector3>& surface, double tolerance) {
  InitialState<real> state = make_worlds<real>({{body}}, 16);
  state.params.margin = 0;
  run_reference(state, {Stage::update_bounds});
  const Bound<real> bound = state.buffers.bounds[0];
  Vector3 most = {0, 0, 0};
  for (const Vector3& point : surface) {
    const Vector3 world = exact::rotate(body.orientation, exact::rotate(body.shapes[0].rotation, point));
    for (unsigned k = 0; k < 3; ++k) most[k] = std::max(most[k], world[k]);
  }
  for (unsigned k = 0; k < 3; ++k) {
    EXPECT_GE(bound.box[k], most[k] * (1 - 1e-7)) << "axis " << k;
    EXPECT_LE(bound.box[k], most[k] + tolerance) << "axis " << k;
  }
}

TYPED_TEST(UpdateBounds, BoxesEncloseTheShapesTightly) {
  using real = TypeParam;
  Random random(11);
  for (int n = 0; n < 60; ++n) {
    // at first along an axis, where a cylinder's root is of next to nothing
    const Quaternion rotation = n == 0   ? Quaternion{0, 0, 0, 1}
                                : n == 1 ? Quaternion{0.6, 0, 0, 0.8}
                                         : random.rotation();
    const Quaternion inner = n < 20 ? Quaternion{0, 0, 0, 1} : random.rotation();
    const double r = random.between(0.01, 2), l = random.between(0.01, 2);
    std::vector<Vector3> capsule, cylinder, corners;
    for (int k = 0; k < 360; ++k) {
      const double a = k * std::acos(-1) / 180, x = r * std::cos(a), y = r * std::sin(a);
      for (const double end : {-l, l}) {
        cylinder.push_back({x, y, end});
        for (int m = -90; m <= 90; m += 2) {
          const double c = std::cos(m * std::acos(-1) / 180), s = std::sin(m * std::acos(-1) / 180);
          capsule.push_back({c * x, c * y, end + r * s});
        }
      }
    }
    const Vector3 half = {r, l, random.between(0.01, 2)};
    for (int k = 0; k < 8; ++k)
      corners.push_back({k & 1 ? half[0] : -half[0], k & 2 ? half[1] : -half[1], k & 4 ? half[2] : -half[2]});
    BodyDescription bodies[] = {round_body(SHAPE_CAPSULE, {1, 2, 3}, r, l, rotation),
                                round_body(SHAPE_CYLINDER, {1, 2, 3}, r, l, rotation),
                                box_body({1, 2, 3}, half, rotation)};
    for (BodyDescription& body : bodies) body.shapes[0].rotation = inner;
    expect_tight_box<real>(bodies[0], capsule, 1e-3);  // as fine as the points lie
    expect_tight_box<real>(bodies[1], cylinder, 1e-3);
    expect_tight_box<real>(bodies[2], corners, 1e-4);
  }
}

TYPED_TEST(UpdateBounds, KernelMatchesReference) {
  using real = TypeParam;
  InitialState<real> state = make_worlds<real>(lively_worlds(), 1000);
  expect_kernel_matches(Stage::update_bounds, state, {});
  state.buffers.positions[100].x = std::numeric_limits<real>::quiet_NaN();
  state.buffers.motions[50].w[2] = std::numeric_limits<real>::infinity();
  state.buffers.motions[51].v[2] = std::numeric_limits<real>::max();
  const Buffers<real> after = expect_kernel_matches(Stage::update_bounds, state, {});
  EXPECT_EQ(after.counters[COUNTER_STATUS], u32(STATUS_OUT_OF_GRID));
  expect_kernel_matches(Stage::update_bounds, make_worlds<real>(worlds_of_all_kinds(), 1000), {});
}

}  // namespace
}  // namespace lockstep::test::update_bounds_test
