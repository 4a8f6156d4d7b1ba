// Sleepers for the tests of single stages: graphs of contacts whose bodies sleep in islands that mean nothing.
#pragma once

#include "tests/contact_scene.hpp"

namespace lockstep::test {

/// What a body was like when it began to be still: as it is, or slower, or on its way by its velocity.
template <class real>
StillStart<real> still_start(const InitialState<real>& state, Random& random, u32 body) {
  const Buffers<real>& b = state.buffers;
  const u32 kind = random.bits() % 4;
  const double time = kind == 2 ? 4 * double(state.params.dt) * state.params.substeps : 0;
  const Vec4<real> x = b.positions[body], q = b.orientations[body];
  StillStart<real> start = {{x.x, x.y, x.z}, 0, {q.x, q.y, q.z, q.w}, {}, 0, {}, 0};
  for (unsigned k = 0; k < 3; ++k) {
    const double v = double(b.motions[body].v[k]), w = double(b.motions[body].w[k]);
    start.position[k] -= real(time * v);
    start.v[k] = real(kind == 3 ? v - 0.2 : v);
    start.w[k] = real(kind == 1 ? 0.5 * w : w);
  }
  return start;
}

/// Lets bodies of a state sleep: `awake_in` of each ten islands of about `size` bodies are awake, some of those woken.
/// Bodies may sleep after 5 steps; those who are awake have been still for up to 8, and move fast, slowly or not at
/// all.
template <class real>
void add_sleepers(InitialState<real>& state, Random& random, u32 size, u32 awake_in) {
  state.features = with(state.features, Feature::sleeping);
  Buffers<real>& b = state.buffers;
  const u32 bodies = state.sizes.bodies, worlds = state.sizes.worlds;
  b.sleep_laws.assign(bodies, {real(0.01), real(0.05), 1, 0});
  b.sleep_steps.assign(worlds, 5);
  b.sleepers.assign(bodies, {0, NONE});
  b.still_starts.assign(bodies, {});
  for (u32 w = 0; w < worlds; ++w) {
    const WorldRange& world = b.world_ranges[w];
    std::vector<u32> names(world.body_count / size + 1, NONE);
    for (u32 i = world.first_body; i < world.first_body + world.body_count; ++i) {
      if (b.body_infos[i].kind == BODY_STATIC) continue;
      const double speed = random.bits() % 3 == 0 ? 0.0 : random.bits() % 2 == 0 ? 0.003 : 1.0;
      set(b.motions[i].v, random.vector(speed));
      set(b.motions[i].w, random.vector(speed));
      if (b.body_infos[i].kind != BODY_DYNAMIC) continue;
      const u32 island = random.bits() % u32(names.size());
      if (island % 10 < awake_in) {
        b.sleepers[i] = {random.bits() % 9, random.bits() % 8 == 0 ? ISLAND_WAKES : NONE};
        b.still_starts[i] = still_start(state, random, i);
        continue;
      }
      if (names[island] == NONE) names[island] = i;
      b.sleepers[i] = {0, names[island]};
      set(b.motions[i].v, {0, 0, 0});
      set(b.motions[i].w, {0, 0, 0});
    }
  }
  resize(b, state.sizes, state.features);
}

/// Random contacts, ordered as the list of contacts is, of several worlds.
template <class real>
InitialState<real> sleeping_graphs(u32 seed, u32 worlds, u32 bodies, u32 contacts, u32 size, u32 awake_in) {
  Random random(seed);
  std::vector<std::vector<BodyKind>> kinds;
  std::vector<Graph> graphs;
  for (u32 w = 0; w < worlds; ++w) {
    auto [kind, graph] = random_graph(random, bodies, contacts);
    std::sort(graph.begin(), graph.end());
    graph.erase(std::unique(graph.begin(), graph.end()), graph.end());
    kinds.push_back(kind);
    graphs.push_back(graph);
  }
  InitialState<real> state = contact_graphs<real>(kinds, graphs);
  add_sleepers(state, random, size, awake_in);
  return state;
}

/// Lets nothing move, of bodies that began to be still where they are.
template <class real>
void let_rest(InitialState<real>& state) {
  Random random(1);
  for (Motion<real>& motion : state.buffers.motions) motion = {};
  for (u32 i = 0; i < state.sizes.bodies; ++i) state.buffers.still_starts[i] = still_start(state, random, i);
  for (StillStart<real>& start : state.buffers.still_starts) set(start.v, {0, 0, 0});
}

}  // namespace lockstep::test
