// Continuous collision: the impact within the step instead of the closest points at its start.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/event_worlds.hpp"

namespace lockstep::test::continuous_test {
namespace {

template <class real>
class Continuous : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(Continuous, Precisions);

constexpr double bullet_radius = 0.005, wall_half = 0.005;

BodyDescription continuous(BodyDescription body, Vector3 velocity = {0, 0, 0}, Vector3 angular_velocity = {0, 0, 0}) {
  body.continuous = true;
  body.velocity = velocity;
  body.angular_velocity = angular_velocity;
  return body;
}

BodyDescription wall(double half_width = 50) {
  BodyDescription body = box_body({0, 0, 0}, {wall_half, half_width, half_width});
  body.kind = BODY_STATIC;
  return body;
}

// Steps of 1/60 s without gravity, friction and, unless it is given, restitution.
template <class real>
InitialState<real> weightless(const std::vector<BodyDescription>& bodies, double restitution = 0) {
  InitialState<real> state = make_event_worlds<real>({bodies}, 64);
  state.buffers.gravities[0] = {0, 0, 0, 0};
  state.buffers.material_pairs[0] = {0, real(restitution)};
  state.params.theta = 1;
  return state;
}

template <class real>
Buffers<real> after_steps(const InitialState<real>& state, u32 steps) {
  Simulation<real> simulation = simulate_in_reference(state);
  for (u32 i = 0; i < steps; ++i) simulation.step();
  const Buffer wanted[] = {Buffer::positions, Buffer::motions};
  return simulation.backend().download(wanted);
}

// 8 m a step against 1 cm, from all distances: straight, and 80 degrees off.
TYPED_TEST(Continuous, ABulletDoesNotPassAThinWall) {
  using real = TypeParam;
  for (const double degrees : {0.0, 45.0, 80.0}) {
    const double angle = degrees * 3.14159265358979 / 180;
    const Vector3 velocity = {500 * std::cos(angle), 500 * std::sin(angle), 0};
    for (const double distance : {0.011, 0.02, 1.0, 3.7, 8.0, 8.3, 9.9}) {
      SCOPED_TRACE(std::to_string(degrees) + " degrees from " + std::to_string(distance));
      const BodyDescription bullet = continuous(sphere_body({-distance, -20, 0}, bullet_radius), velocity);
      const Buffers<real> b = after_steps(weightless<real>({wall(), bullet}), 12);
      EXPECT_NEAR(double(b.positions[1].x), -(wall_half + bullet_radius), 1e-4);
      EXPECT_NEAR(double(b.motions[1].v[0]), 0, 1e-3);
      EXPECT_NEAR(double(b.motions[1].v[1]), velocity[1], 1e-3);  // smooth: it slides on
      EXPECT_EQ(b.positions[1].z, 0);
    }
  }
}

TYPED_TEST(Continuous, RestitutionKeepsTheSpeed) {
  using real = TypeParam;
  for (const Vector3& velocity : {Vector3{500, 0, 0}, Vector3{300, 400, 0}, Vector3{80, 490, 0}}) {
    const BodyDescription bullet = continuous(sphere_body({-4.3, -20, 0}, bullet_radius), velocity);
    const Buffers<real> b = after_steps(weightless<real>({wall(), bullet}, 1), 11);
    EXPECT_NEAR(double(b.motions[1].v[0]), -velocity[0], 1e-4 * velocity[0]);
    EXPECT_NEAR(double(b.motions[1].v[1]), velocity[1], 1e-4 * 500);
    EXPECT_LT(b.positions[1].x, -1);
  }
}

// Two bullets that meet: equal masses without loss change their velocities, with it they stay together.
TYPED_TEST(Continuous, TwoBulletsMeet) {
  using real = TypeParam;
  for (const double restitution : {0.0, 1.0}) {
    const BodyDescription one = continuous(sphere_body({-5, 0, 0}, bullet_radius), {500, 0, 0});
    const BodyDescription other = continuous(sphere_body({3, 0, 0}, bullet_radius), {-400, 0, 0});
    const Buffers<real> b = after_steps(weightless<real>({one, other}, restitution), 4);
    EXPECT_NEAR(double(b.motions[0].v[0]), restitution == 0 ? 50 : -400, 0.01);
    EXPECT_NEAR(double(b.motions[1].v[0]), restitution == 0 ? 50 : 500, 0.01);
    EXPECT_GE(b.positions[1].x - b.positions[0].x, 2 * bullet_radius - 1e-4);
    EXPECT_EQ(b.motions[0].w[2], 0);
  }
}

// What passes the edge of a wall, or another ball, by a little more than nothing is left alone to the last bit. The
// closest points at the start of the step would have turned it.
TYPED_TEST(Continuous, WhatPassesByIsNotTouched) {
  using real = TypeParam;
  const double beside = 0.5 + bullet_radius + 0.002;
  const std::vector<std::vector<BodyDescription>> scenes = {
      {wall(0.5), sphere_body({-4, 0, beside}, bullet_radius, {500, 0, 0})},
      {wall(0.5), sphere_body({-4, beside, 0}, bullet_radius, {499, 0, 20})},
      {sphere_body({0, 0, 0}, 0.5), sphere_body({-4, 0, beside}, bullet_radius, {500, 0, 0})}};
  for (std::vector<BodyDescription> bodies : scenes) {
    const Vector3 velocity = bodies[1].velocity;
    bodies[0].kind = BODY_STATIC;
    const Buffers<real> ghost = after_steps(weightless<real>(bodies), 3);
    EXPECT_LT(ghost.motions[1].v[0], 480);
    bodies[1].continuous = true;
    const Buffers<real> b = after_steps(weightless<real>(bodies), 3);
    for (int k = 0; k < 3; ++k) EXPECT_EQ(b.motions[1].v[k], real(velocity[k]));
    EXPECT_NEAR(double(b.positions[1].x), -4 + velocity[0] * 3 / 60, 1e-4);
  }
}

// Boxes and capsules, turning and not, thrown at the wall, some to hit it with a corner first: their middles stay on
// this side, and what the wall gives back is little.
TYPED_TEST(Continuous, BoxesAndCapsulesDoNotPass) {
  using real = TypeParam;
  Random random(70);
  for (int n = 0; n < 200; ++n) {
    SCOPED_TRACE(n);
    const Vector3 position = {random.between(-9, -0.5), 0, 0};
    const Quaternion rotation = random.rotation();
    const Vector3 velocity = {random.between(200, 500), random.between(-100, 100), 0};
    const Vector3 angular_velocity = random.vector(n % 4 == 0 ? 0 : 30);
    const BodyDescription body = n % 2 ? box_body(position, {0.1, 0.05, 0.02}, rotation)
                                       : round_body(SHAPE_CAPSULE, position, 0.03, 0.1, rotation);
    const Buffers<real> b = after_steps(weightless<real>({wall(), continuous(body, velocity, angular_velocity)}), 8);
    EXPECT_LT(b.positions[1].x, -0.01);
    EXPECT_LT(std::abs(b.motions[1].v[0]), 0.06 * velocity[0]);
  }
}

// A rod turns beside a wall at 20 rad/s, a third of a radian in the step: its end comes to the wall, not through it.
TYPED_TEST(Continuous, TheEndOfARotatingRodIsStopped) {
  using real = TypeParam;
  for (const double angle : {0.2, 0.3, 0.4}) {
    const Quaternion lying = {std::sin(angle / 2), 0, 0, std::cos(angle / 2)};  // z axis towards -y
    BodyDescription rod = round_body(SHAPE_CAPSULE, {0, 0, 0}, 0.01, 1, lying);
    rod = continuous(rod, {0, 0, 0}, {20, 0, 0});
    BodyDescription ground = box_body({0, -0.6, 0}, {5, 0.05, 5});
    ground.kind = BODY_STATIC;
    InitialState<real> state = weightless<real>({ground, rod});
    Simulation<real> simulation = simulate_in_reference(state);
    double lowest = 1;
    for (int i = 0; i < 4; ++i) {
      simulation.step();
      const Buffer wanted[] = {Buffer::positions, Buffer::orientations};
      const Buffers<real>& b = simulation.backend().download(wanted);
      const Vec4<real> q = b.orientations[1];
      const double axis_y = 2 * (double(q.y) * q.z - double(q.w) * q.x);
      lowest = std::min(lowest, b.positions[1].y - std::abs(axis_y) - 0.01);
    }
    EXPECT_GT(lowest, -0.55 - 0.05);
    EXPECT_LT(lowest, -0.5);
  }
}

// Time and normal of the impact of two spheres are the roots of a quadratic: those that meet have a contact with that
// normal, those that miss by more than the margin have none.
TYPED_TEST(Continuous, SpheresMeetWhereTheyShould) {
  using real = TypeParam;
  Random random(71);
  u32 hits = 0, misses = 0;
  for (int n = 0; n < 2000; ++n) {
    const Vector3 x = random.vector(3);
    Vector3 v;
    for (unsigned k = 0; k < 3; ++k) v[k] = -x[k] * random.between(30, 90);
    const Vector3 aside = random.vector(60);
    for (unsigned k = 0; k < 3; ++k) v[k] += aside[k];
    const double radius = 0.2 + 0.3;
    double xx = 0, xv = 0, vv = 0;
    for (unsigned k = 0; k < 3; ++k) xx += x[k] * x[k], xv += x[k] * v[k], vv += v[k] * v[k];
    if (xx < radius * radius) continue;
    const double h = 1.0 / 60, root = xv * xv - vv * (xx - radius * radius);
    const double time = root > 0 ? (-xv - std::sqrt(root)) / vv : h;
    const double nearest_time = std::clamp(-xv / vv, 0.0, h);
    const double nearest = std::sqrt(xx + 2 * nearest_time * xv + nearest_time * nearest_time * vv) - radius;

    InitialState<real> state =
        weightless<real>({continuous(sphere_body(x, 0.2), v, random.vector(5)), sphere_body({0, 0, 0}, 0.3)});
    run_reference(state, {Stage::update_bounds, Stage::sort_cells, Stage::find_pairs, Stage::collide});
    const Buffers<real>& b = state.buffers;
    if (nearest > 0.0051) {
      EXPECT_EQ(b.counters[COUNTER_CONTACTS], 0u);
      ++misses;
    } else if (nearest < -0.05 && time > 0 && time < h) {
      ASSERT_EQ(b.counters[COUNTER_CONTACTS], 1u);
      for (unsigned k = 0; k < 3; ++k)
        EXPECT_NEAR(double(b.contact_points[0].normal[k]), (x[k] + time * v[k]) / radius, 3e-3);
      ++hits;
    }
  }
  EXPECT_GT(hits, 200u);
  EXPECT_GT(misses, 300u);
}

// A ball rolls on a plane as it does without: what touches at the start of the step has no impact to look for.
TYPED_TEST(Continuous, ABallAtRestStaysAtRest) {
  using real = TypeParam;
  InitialState<real> state =
      make_event_worlds<real>({{plane_body(), continuous(sphere_body({0, 0, 0.1}, 0.1), {3, 0, 0})}}, 16);
  state.params.theta = 1;
  InitialState<real> plain = state;
  plain.buffers.shape_infos[1].flags &= ~u32(SHAPE_IS_CONTINUOUS);
  const Buffers<real> a = after_steps(state, 120), b = after_steps(plain, 120);
  EXPECT_NEAR(double(a.positions[1].x), double(b.positions[1].x), 1e-4);
  EXPECT_NEAR(double(a.positions[1].z), double(b.positions[1].z), 1e-5);
  EXPECT_NEAR(double(a.motions[1].w[1]), double(b.motions[1].w[1]), 1e-3);
}

TYPED_TEST(Continuous, TwinsAgree) {
  using real = TypeParam;
  std::vector<std::vector<BodyDescription>> worlds = lively_worlds();
  Random random(72);
  for (auto& world : worlds) {
    for (u32 n = 0; n < 60; ++n) {
      const Vector3 position = random.vector(3);
      world.push_back(n % 2 ? box_body(position, {0.3, 0.1, 0.05}, random.rotation())
                            : round_body(SHAPE_CAPSULE, position, 0.05, 0.3, random.rotation()));
      world.back().velocity = random.vector(100);
      world.back().angular_velocity = random.vector(20);
    }
    for (u32 n = 0; n < world.size(); n += 3) world[n].continuous = true;
  }
  expect_twins_agree(make_event_worlds<real>(worlds, 200000), 3, launches_of_a_step<real>());
}

}  // namespace
}  // namespace lockstep::test::continuous_test
