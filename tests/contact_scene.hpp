// Contact problems for the tests of the contact stages: graphs without geometry, and small worlds that are stepped.
#pragma once

#include <cmath>
#include <cstring>
#include <utility>

#include "cpu_reference/pack_contacts.hpp"
#include "host/backends/reference_backend.hpp"
#include "host/step.hpp"
#include "tests/stage_harness.hpp"
#include "tests/worlds.hpp"

namespace lockstep::test {

using Graph = std::vector<std::pair<u32, u32>>;  // a contact for each pair of bodies; those of one pair in a row

inline BodyDescription body_of_kind(BodyKind kind) {
  BodyDescription body = sphere_body({0, 0, 0}, 1);
  body.kind = kind;
  return body;
}

/// Worlds that are given by who touches whom: body i has shape i; the poses mean nothing. Bodies are named within their
/// world.
template <class real>
InitialState<real> contact_graphs(const std::vector<std::vector<BodyKind>>& worlds, const std::vector<Graph>& graphs) {
  std::vector<std::vector<BodyDescription>> bodies;
  u32 count = 0;
  for (u32 w = 0; w < worlds.size(); ++w) {
    bodies.emplace_back();
    for (const BodyKind kind : worlds[w]) bodies.back().push_back(body_of_kind(kind));
    count += u32(graphs[w].size());
  }
  InitialState<real> state = make_worlds<real>(bodies, count);
  Buffers<real>& b = state.buffers;
  state.features = with(state.features, Feature::manifolds);  // a pair may be named several times in a row
  state.sizes.blocks = state.sizes.rows = MAX_COLORS + count;
  state.params.block_capacity = state.params.row_capacity = state.sizes.blocks;
  resize(b, state.sizes, state.features);
  std::ranges::fill(b.counters, 0u);
  for (u32 w = 0; w < worlds.size(); ++w) {
    const u32 first = b.world_ranges[w].first_body;
    u32 rank = 0;
    for (const auto& [a, c] : graphs[w])
      b.contacts[b.counters[COUNTER_CONTACTS]++] = {first + a, first + c, rank, first + a, first + c, w, rank, 0},
      ++rank;
  }
  return state;
}

/// Random contacts among dynamic bodies, and with two immovable ones at the end.
inline std::pair<std::vector<BodyKind>, Graph> random_graph(Random& random, u32 dynamic_bodies, u32 contacts) {
  std::vector<BodyKind> kinds(dynamic_bodies, BODY_DYNAMIC);
  kinds.push_back(BODY_STATIC);
  kinds.push_back(BODY_KINEMATIC);
  Graph graph;
  for (u32 i = 0; i < contacts; ++i) {
    const u32 a = random.bits() % dynamic_bodies;
    u32 b = random.bits() % u32(kinds.size());
    if (b == a) b = dynamic_bodies;
    graph.push_back({a, b});
  }
  return {kinds, graph};
}

/// The same with one to four contacts for each pair.
inline Graph with_manifolds(Random& random, const Graph& graph) {
  Graph result;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const u32 points = 1 + random.bits() % MANIFOLD_POINTS;
    if (result.empty() || result.back() != graph[i]) result.insert(result.end(), points, graph[i]);
  }
  return result;
}

/// Worlds of random contacts, one to four for each pair.
template <class real>
InitialState<real> random_worlds(u32 seed, std::initializer_list<std::pair<u32, u32>> bodies_and_contacts) {
  Random random(seed);
  std::vector<std::vector<BodyKind>> kinds;
  std::vector<Graph> graphs;
  for (const auto& [bodies, contacts] : bodies_and_contacts) {
    const auto [world, graph] = random_graph(random, bodies, contacts);
    kinds.push_back(world);
    graphs.push_back(with_manifolds(random, graph));
  }
  return contact_graphs<real>(kinds, graphs);
}

/// A hub that touches `count` others.
inline std::pair<std::vector<BodyKind>, Graph> star(u32 count, BodyKind hub = BODY_DYNAMIC) {
  std::vector<BodyKind> kinds(count + 1, BODY_DYNAMIC);
  kinds[0] = hub;
  Graph graph;
  for (u32 i = 1; i <= count; ++i) graph.push_back({i, 0});
  return {kinds, graph};
}

/// From contacts to blocks.
template <class real>
void lay_out(InitialState<real>& state) {
  for (const Stage stage :
       {Stage::partition_contacts, Stage::schedule_contacts, Stage::color_contacts, Stage::pack_contacts}) {
    if (stage == Stage::color_contacts || runs(stage, state.features))
      reference::run_stage(stage, state.buffers, state.params);
  }
}

/// Everything of the first sub-step up to the packed constraint stream.
template <class real>
void run_until_prepared(InitialState<real>& state) {
  run_reference(state, {Stage::begin_step, Stage::update_bounds, Stage::sort_cells, Stage::find_pairs, Stage::collide,
                        Stage::match_contacts});
  lay_out(state);
  for (const Stage stage : {Stage::split_bodies, Stage::couple_contacts, Stage::pack_points,
                            Stage::integrate_velocities, Stage::prepare_contacts}) {
    if (runs(stage, state.features)) reference::run_stage(stage, state.buffers, state.params);
  }
}

/// Impulses for a warm start, as no step before would have left them.
template <class real>
void draw_start_impulses(u32 seed, InitialState<real>& state) {
  Random random(seed);
  for (auto& start : state.buffers.start_impulses)
    start = {real(random.between(-0.2, 1)), real(random.between(-1, 1)), real(random.between(-1, 1)), 0};
}

/// Prepared, and with drawn impulses warm: ready for its first sweep.
template <class real>
InitialState<real> started(InitialState<real> state) {
  run_until_prepared(state);
  draw_start_impulses(7, state);
  for (const Stage stage : {Stage::pack_points, Stage::prepare_contacts, Stage::warm_start})
    reference::run_stage(stage, state.buffers, state.params);
  return state;
}

/// A coloured and packed problem with random geometry, bodies in motion, impulses to start from; one of three contacts
/// is general.
template <class real>
InitialState<real> prepared(InitialState<real> state) {
  Buffers<real>& b = state.buffers;
  Random random(b.counters[COUNTER_CONTACTS]);
  for (u32 i = 0; i < b.body_infos.size(); ++i) {
    set(b.motions[i].v, random.vector(1));
    set(b.motions[i].w, random.vector(1));
    b.body_infos[i].isotropic = random.bits() % 5 != 0 ? 1 : 0;
    if (b.body_infos[i].kind == BODY_DYNAMIC) {
      Motion<real>& m = b.motions[i];
      m.inverse_mass = real(random.between(0.5, 2));
      m.inertia_xx = real(random.between(1, 2));
      m.inertia_yy = b.body_infos[i].isotropic ? m.inertia_xx : real(random.between(1, 2));
      m.inertia_zz = b.body_infos[i].isotropic ? m.inertia_xx : real(random.between(1, 2));
      m.inertia_xy = m.inertia_xz = m.inertia_yz = b.body_infos[i].isotropic ? real(0) : real(0.2);
    }
  }
  lay_out(state);
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
    const u32 block = b.contact_slots[i] / PACK, lane = b.contact_slots[i] % PACK;
    ContactBlock<real>& c = b.contact_blocks[block];
    const bool general = !(reference::is_central(b, b.contacts[i].body_a, b.contacts[i].shape_a) &&
                           reference::is_central(b, b.contacts[i].body_b, b.contacts[i].shape_b));
    Vector3 n = random.vector(1);
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (double& x : n) x /= length;
    const double along_a = random.between(-1, -0.5), along_b = random.between(0.5, 1);
    const Vector3 off = general ? random.vector(0.3) : Vector3{};
    c.normal_x[lane] = real(n[0]);
    c.normal_y[lane] = real(n[1]);
    c.normal_z[lane] = real(n[2]);
    c.arm_a_x[lane] = real(along_a * n[0] + off[0]);
    c.arm_a_y[lane] = real(along_a * n[1] + off[1]);
    c.arm_a_z[lane] = real(along_a * n[2] + off[2]);
    c.arm_b_x[lane] = real(along_b * n[0] - off[0]);
    c.arm_b_y[lane] = real(along_b * n[1]);
    c.arm_b_z[lane] = real(along_b * n[2]);
    c.bias[lane] = real(random.between(-0.5, 0.5));
    c.friction[lane] = random.bits() % 8 == 0 ? real(0) : real(random.between(0, 1.5));
    c.w_nn[lane] = real(random.between(1, 2));
    c.w_11[lane] = real(random.between(2, 4));
    c.w_22[lane] = general ? real(random.between(2, 4)) : c.w_11[lane];
    c.w_n1[lane] = general ? real(random.between(-0.5, 0.5)) : real(0);
    c.w_n2[lane] = general ? real(random.between(-0.5, 0.5)) : real(0);
    c.w_12[lane] = general ? real(random.between(-0.5, 0.5)) : real(0);
    ImpulseBlock<real>& r = b.impulse_blocks[block];
    r.normal[lane] = real(random.between(0, 1));
    r.tangent_1[lane] = real(random.between(-0.5, 0.5)) * c.friction[lane] * r.normal[lane];
    r.tangent_2[lane] = real(random.between(-0.5, 0.5)) * c.friction[lane] * r.normal[lane];
  }
  return state;
}

template <class real>
InitialState<real> random_problem(u32 seed, u32 dynamic_bodies, u32 contacts) {
  Random random(seed);
  const auto [kinds, graph] = random_graph(random, dynamic_bodies, contacts);
  return prepared(contact_graphs<real>({kinds}, {with_manifolds(random, graph)}));
}

/// More contacts on one body than there are colours.
template <class real>
InitialState<real> star_problem(u32 count) {
  const auto [kinds, graph] = star(count);
  return prepared(contact_graphs<real>({kinds}, {graph}));
}

/// A heap of boxes and spheres that overlap, in motion, on a plane: pairs of one to four points.
inline std::vector<BodyDescription> overlapping_bodies(Random& random) {
  std::vector<BodyDescription> bodies = {plane_body()};
  for (int i = 0; i < 80; ++i) {
    const Vector3 at = {random.between(-1.5, 1.5), random.between(-1.5, 1.5), random.between(0.2, 1.5)};
    const Vector3 size = {random.between(0.2, 0.4), random.between(0.2, 0.4), random.between(0.2, 0.4)};
    bodies.push_back(i % 5 == 0 ? sphere_body(at, 0.4)
                                : box_body(at, size, i % 2 == 0 ? Quaternion{0, 0, 0, 1} : random.rotation()));
    bodies.back().velocity = random.vector(1);
    bodies.back().angular_velocity = random.vector(2);
    if (i % 10 == 9) bodies.back().kind = BODY_KINEMATIC;
  }
  return bodies;
}

/// A ball of 10 m, its surface strewn by the golden angle with small ones that fly inwards at 1 m/s.
inline std::vector<BodyDescription> strewn_ball(u32 count) {
  std::vector<BodyDescription> bodies = {sphere_body({0, 0, 0}, 10)};
  bodies[0].mass = 1000;
  bodies[0].inertia = {4e4, 4e4, 4e4};
  for (u32 i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, ring = std::sqrt(1 - z * z), azimuth = 2.399963229728653 * i;
    const Vector3 out = {ring * std::cos(azimuth), ring * std::sin(azimuth), z};
    bodies.push_back(sphere_body({10.25 * out[0], 10.25 * out[1], 10.25 * out[2]}, 0.25, {-out[0], -out[1], -out[2]}));
  }
  return bodies;
}

/// The speed at which ball i of them leaves the large one, m/s.
template <class real>
double leaving_speed(const std::vector<BodyDescription>& strewn, const Buffers<real>& after, u32 i) {
  double speed = 0;
  for (u32 axis = 0; axis < 3; ++axis)
    speed += double(after.motions[i].v[axis] - after.motions[0].v[axis]) * strewn[i].position[axis] / 10.25;
  return speed;
}

/// No ball comes closer to the large one, and those that are pushed do not leave it; more are pushed than there are
/// colours.
template <class real>
void expect_all_are_stopped(const std::vector<BodyDescription>& strewn, const Buffers<real>& after) {
  u32 pushed = 0;
  for (u32 k = 0; k + 1 < strewn.size(); ++k) {
    const u32 ball = std::max(after.contacts[k].body_a, after.contacts[k].body_b);
    EXPECT_GT(leaving_speed(strewn, after, ball), -1e-3) << ball;
    if (!(after.cached_impulses[k].normal > real(1e-3))) continue;
    EXPECT_LT(leaving_speed(strewn, after, ball), 1e-3) << ball;
    ++pushed;
  }
  EXPECT_GT(pushed, MAX_COLORS);
}

/// Two spheres of different size and mass that touch, moving and turning; ready to be solved.
template <class real>
InitialState<real> pair_of_spheres() {
  BodyDescription a = sphere_body({0.3, 0.2, 2}, 1, {-1, 0.5, 0.2}), b = sphere_body({1.2, 1.4, 2}, 0.5, {-2, -3, 0.1});
  b.mass = 3;
  b.inertia = {0.3, 0.3, 0.3};
  a.angular_velocity = {1, 2, -1};
  b.angular_velocity = {-3, 0.5, 1};
  InitialState<real> state = make_worlds<real>({{a, b}}, 16);
  state.buffers.gravities[0] = {0, 0, 0, 0};
  run_until_prepared(state);
  return state;
}

template <class real>
void set_material(InitialState<real>& state, double friction, double restitution) {
  for (auto& pair : state.buffers.material_pairs) pair = {real(friction), real(restitution)};
}

/// Steps the reference; a step that runs out of room fails the test.
template <class real>
Buffers<real> run_steps(const InitialState<real>& state, int steps) {
  ReferenceBackend<real> backend(state);
  for (int i = 0; i < steps; ++i) {
    step(backend, state.params);
    EXPECT_EQ(backend.buffers().counters[COUNTER_STATUS], 0u) << "step " << i;
  }
  return backend.buffers();
}

/// The sum over the bodies of m v and of x cross m v + I w, about the origin; isotropic bodies only.
template <class real>
std::pair<Vector3, Vector3> momentum(const Buffers<real>& b) {
  Vector3 linear = {}, angular = {};
  for (u32 i = 0; i < b.body_infos.size(); ++i) {
    if (b.body_infos[i].kind != BODY_DYNAMIC) continue;
    const double m = double(b.masses[i].mass), inertia = double(b.masses[i].inertia[0]);
    const auto &v = b.motions[i].v, &w = b.motions[i].w;
    const Vector3 x = {double(b.positions[i].x), double(b.positions[i].y), double(b.positions[i].z)};
    for (u32 k = 0; k < 3; ++k) {
      const u32 k1 = (k + 1) % 3, k2 = (k + 2) % 3;
      linear[k] += m * double(v[k]);
      angular[k] += m * (x[k1] * double(v[k2]) - x[k2] * double(v[k1])) + inertia * double(w[k]);
    }
  }
  return {linear, angular};
}

/// Sixty balls of random masses that fly into each other, turning, without weight.
template <class real>
InitialState<real> balls_that_collide() {
  std::vector<BodyDescription> bodies;
  Random random(3);
  for (u32 i = 0; i < 60; ++i) {
    bodies.push_back(sphere_body(random.vector(1), 0.3, random.vector(3)));
    bodies.back().mass = random.between(0.5, 2);
    const double moment = bodies.back().mass * 0.4 * 0.09;
    bodies.back().inertia = {moment, moment, moment};
    bodies.back().angular_velocity = random.vector(2);
  }
  InitialState<real> state = make_worlds<real>({bodies}, 2048);
  state.buffers.gravities[0] = {0, 0, 0, 0};
  return state;
}

/// What the solver makes of their velocities adds up, to within `rounding` (kg m/s, kg m^2/s); and it changes them. The
/// state is prepared.
template <class real>
void expect_solving_keeps_momentum(InitialState<real> state, double rounding) {
  ASSERT_GT(state.buffers.counters[COUNTER_CONTACTS], 100u);
  const auto [linear, angular] = momentum(state.buffers);
  const Buffers<real> before = state.buffers;
  reference::run_stage(Stage::solve_constraints, state.buffers, state.params);
  const auto [linear_after, angular_after] = momentum(state.buffers);
  double change = 0;
  for (u32 k = 0; k < 3; ++k) {
    EXPECT_NEAR(linear_after[k], linear[k], rounding);
    EXPECT_NEAR(angular_after[k], angular[k], rounding);
  }
  for (u32 i = 0; i < state.params.bodies; ++i)
    change = std::max(change, std::abs(double(state.buffers.motions[i].v[0] - before.motions[i].v[0])));
  EXPECT_GT(change, 1);
}

/// Balls of 1 and 3 kg that touch, the first at x, and come closer at 3 m/s; they bounce with half of that.
template <class real>
InitialState<real> balls_that_bounce(double x = 0) {
  BodyDescription left = sphere_body({x, 0, 0}, 0.5, {2, 0, 0}), right = sphere_body({x + 1, 0, 0}, 0.5, {-1, 0, 0});
  right.mass = 3;
  InitialState<real> state = make_worlds<real>({{left, right}}, 16);
  state.buffers.gravities[0] = {0, 0, 0, 0};
  state.params.theta = 1;
  set_material(state, 0, 0.5);
  return state;
}

/// Momentum, and the relative velocity times -e: to within `rounding`, m/s.
template <class real>
void expect_they_bounced(const Buffers<real>& after, double rounding) {
  const double common = (1 * 2 - 3 * 1) / 4.0;
  EXPECT_NEAR(double(after.motions[0].v[0]), common - 3 / 4.0 * 0.5 * 3, rounding);
  EXPECT_NEAR(double(after.motions[1].v[0]), common + 1 / 4.0 * 0.5 * 3, rounding);
}

/// Balls of 1 kg and half a metre, each on the one below, the lowest on the ground, at rest.
template <class real>
InitialState<real> column_of_balls(u32 height) {
  std::vector<BodyDescription> bodies;
  for (u32 i = 0; i < height; ++i) bodies.push_back(sphere_body({0, 0, 0.5 + i}, 0.5));
  bodies.push_back(plane_body());
  InitialState<real> state = make_worlds<real>({bodies}, 64);
  state.params.theta = 1;
  return state;
}

/// Each contact of the column carries what is above it, m g dt: to within `tolerance`, N s.
template <class real>
void expect_column_bears_its_weight(const Buffers<real>& after, u32 height, double tolerance) {
  ASSERT_EQ(after.cached_count[0], height);
  for (u32 i = 0; i < height; ++i) {
    const ContactKey& key = after.cached_keys[i];
    const u32 lower = key.shape_b == height ? 0 : std::max(key.shape_a, key.shape_b);
    EXPECT_NEAR(double(after.cached_impulses[i].normal), (height - lower) * 9.81 / 60, tolerance) << i;
  }
}

/// The bodies of one world of several move with the bits that they have alone.
template <class real>
void expect_world_is_as_alone(const Buffers<real>& all, u32 world, const Buffers<real>& alone) {
  const WorldRange& range = all.world_ranges[world];
  ASSERT_EQ(range.body_count, alone.body_infos.size());
  ASSERT_GT(alone.counters[COUNTER_CONTACTS], 40u);
  for (u32 i = 0; i < range.body_count; ++i) {
    EXPECT_EQ(std::memcmp(&all.positions[range.first_body + i], &alone.positions[i], sizeof(Vec4<real>)), 0) << i;
    EXPECT_EQ(std::memcmp(&all.motions[range.first_body + i], &alone.motions[i], sizeof(Motion<real>)), 0) << i;
  }
}

/// Both ended at the same velocities: within 1e-7 m/s and 1e-6 rad/s, or so many times that.
inline void expect_same_velocities(const Buffers<double>& one, const Buffers<double>& other, double times = 1) {
  for (u32 i = 0; i < one.body_infos.size(); ++i) {
    for (u32 k = 0; k < 3; ++k) {
      EXPECT_NEAR(one.motions[i].v[k], other.motions[i].v[k], 1e-7 * times) << i;
      EXPECT_NEAR(one.motions[i].w[k], other.motions[i].w[k], 1e-6 * times) << i;
    }
  }
}

/// Both solve the same problem, each by its own number of sweeps, and end at the same velocities: m/s, rad/s.
inline void expect_both_converge_alike(InitialState<double> one, InitialState<double> other) {
  ASSERT_GT(one.buffers.counters[COUNTER_CONTACTS], 60u);
  for (InitialState<double>* state : {&one, &other})
    reference::run_stage(Stage::solve_constraints, state->buffers, state->params);
  expect_same_velocities(one.buffers, other.buffers, 10);
}

/// Every way to launch, one of them by a single thread.
inline std::vector<DeviceOptions> launches_of_all_threads_and_one() {
  std::vector<DeviceOptions> launches = all_launch_options();
  launches.back().threads = 1;
  return launches;
}

/// One stage on the device beside the reference, from these buffers, for every way to launch.
template <class real>
Buffers<real> run_twins(Stage stage, const InitialState<real>& state) {
  return run_one_stage<real>(stage, state.buffers, state.sizes, state.features, state.params);
}

}  // namespace lockstep::test
