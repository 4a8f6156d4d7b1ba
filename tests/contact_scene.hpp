// Contact problems for the tests of the contact stages: graphs without geometry, and small worlds that are stepped.
#pragma once

#include <utility>

#include "host/backends/reference_backend.hpp"
#include "host/step.hpp"
#include "tests/stage_harness.hpp"
#include "tests/worlds.hpp"

namespace lockstep::test {

using Graph = std::vector<std::pair<u32, u32>>;  // a contact for each pair of bodies

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
  state.sizes.blocks = MAX_COLORS + count;
  state.params.block_capacity = state.sizes.blocks;
  resize(b, state.sizes, state.features);
  std::ranges::fill(b.counters, 0u);
  for (u32 w = 0; w < worlds.size(); ++w) {
    const u32 first = b.world_ranges[w].first_body;
    u32 rank = 0;
    for (const auto& [a, c] : graphs[w])
      b.contacts[b.counters[COUNTER_CONTACTS]++] = {first + a, first + c, 0, first + a, first + c, w, rank++, 0};
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

/// A hub that touches `count` others.
inline std::pair<std::vector<BodyKind>, Graph> star(u32 count, BodyKind hub = BODY_DYNAMIC) {
  std::vector<BodyKind> kinds(count + 1, BODY_DYNAMIC);
  kinds[0] = hub;
  Graph graph;
  for (u32 i = 1; i <= count; ++i) graph.push_back({i, 0});
  return {kinds, graph};
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

/// One stage on the device beside the reference, from these buffers, for every way to launch.
template <class real>
Buffers<real> run_twins(Stage stage, const InitialState<real>& state) {
  return run_one_stage<real>(stage, state.buffers, state.sizes, state.features, state.params);
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

}  // namespace lockstep::test
