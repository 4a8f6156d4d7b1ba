// Lists of pairs: as the searches of the broad phase find them, and by every pair there is.
#pragma once

#include <array>
#include <cmath>
#include <utility>

#include "tests/collision_states.hpp"

namespace lockstep::test {

using PairList = std::vector<std::pair<u32, u32>>;

template <class real>
PairList pairs_of(const InitialState<real>& state) {
  PairList pairs;
  for (u32 p = 0; p < state.buffers.counters[COUNTER_PAIRS]; ++p)
    pairs.emplace_back(state.buffers.pairs[p].shape_a, state.buffers.pairs[p].shape_b);
  return pairs;
}

/// The same state for another search than the grid.
template <class real>
InitialState<real> with_search(Feature search, InitialState<real> state) {
  state.features &= ~static_cast<Features>(Feature::grid);
  state.features = with(state.features, search);
  resize(state.buffers, state.sizes, state.features);
  return state;
}
template <class real>
InitialState<real> with_tree(InitialState<real> state) {
  return with_search(Feature::bvh, std::move(state));
}
template <class real>
InitialState<real> with_comparison(InitialState<real> state) {
  return with_search(Feature::all_pairs, std::move(state));
}

template <class real>
void find_by_tree(InitialState<real>& state) {
  run_reference(state, {Stage::update_bounds, Stage::sort_shapes, Stage::build_tree, Stage::search_tree});
}

/// The pairs that the grid finds; the other searches must find the same ones.
template <class real>
PairList found(InitialState<real>& state) {
  run_reference(state, {Stage::update_bounds, Stage::sort_cells, Stage::find_pairs});
  const Buffers<real>& b = state.buffers;
  const PairList pairs = pairs_of(state);
  EXPECT_EQ(b.counters[COUNTER_STATUS], 0u);
  EXPECT_EQ(b.counters[COUNTER_PAIRS_NEEDED], pairs.size());
  EXPECT_EQ(b.pair_starts[state.sizes.shapes], pairs.size());
  if (b.pair_starts[state.sizes.shapes] != pairs.size()) return pairs;
  for (u32 i = 0; i < state.sizes.shapes; ++i) {
    for (u32 p = b.pair_starts[i]; p < b.pair_starts[i + 1]; ++p) EXPECT_EQ(pairs[p].first, i);
  }
  InitialState<real> tree = with_tree(state), comparison = with_comparison(state);
  find_by_tree(tree);
  run_reference(comparison, {Stage::update_bounds, Stage::compare_shapes});
  for (const InitialState<real>* other : {&tree, &comparison}) {
    EXPECT_EQ(pairs_of(*other), pairs);
    EXPECT_EQ(other->buffers.pair_starts, b.pair_starts);
    EXPECT_EQ(other->buffers.counters, b.counters);
  }
  return pairs;
}

template <class real>
bool may_touch(const InitialState<real>& state, u32 i, u32 j) {
  const ShapeInfo &a = state.buffers.shape_infos[i], &b = state.buffers.shape_infos[j];
  const BodyInfo &body_a = state.buffers.body_infos[a.body], &body_b = state.buffers.body_infos[b.body];
  const bool filtered = (a.category & b.mask) == 0 || (b.category & a.mask) == 0;
  const bool movable = body_a.kind == BODY_DYNAMIC || body_b.kind == BODY_DYNAMIC;
  return a.body != b.body && body_a.world == body_b.world && movable && !filtered;
}

template <class real>
std::array<real, 3> center_velocity(const InitialState<real>& state, u32 shape) {
  const u32 body = state.buffers.shape_infos[shape].body;
  const Bound<real>& c = state.buffers.bounds[shape];
  const Vec4<real> x = state.buffers.positions[body];
  const Motion<real>& m = state.buffers.motions[body];
  const real arm[3] = {c.center[0] - x.x, c.center[1] - x.y, c.center[2] - x.z};
  return {m.v[0] + (m.w[1] * arm[2] - m.w[2] * arm[1]), m.v[1] + (m.w[2] * arm[0] - m.w[0] * arm[2]),
          m.v[2] + (m.w[0] * arm[1] - m.w[1] * arm[0])};
}

template <class real>
real rotational_speed_of(const InitialState<real>& state, u32 shape) {
  const ShapeInfo& info = state.buffers.shape_infos[shape];
  if (info.kind == SHAPE_SPHERE) return 0;
  const real* w = state.buffers.motions[info.body].w;
  return std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]) * state.buffers.bounds[shape].bounding_radius;
}

/// The criterion of the broad phase, bounds with their margins, in the same precision and order of operations.
template <class real>
bool in_range(const InitialState<real>& state, u32 i, u32 j) {
  const auto length = [](const std::array<real, 3>& x) { return std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]); };
  const Buffers<real>& b = state.buffers;
  const Bound<real>&mine = b.bounds[i], &other = b.bounds[j];
  const auto v = center_velocity(state, i), w = center_velocity(state, j);
  const std::array<real, 3> d = {mine.center[0] - other.center[0], mine.center[1] - other.center[1],
                                 mine.center[2] - other.center[2]};
  const std::array<real, 3> u = {v[0] - w[0], v[1] - w[1], v[2] - w[2]};
  const real h = state.params.dt * real(state.params.substeps);
  if (!(length(d) - (mine.bounding_radius + other.bounding_radius) <= h * length(u))) return false;
  if (b.shape_infos[i].kind == SHAPE_SPHERE && b.shape_infos[j].kind == SHAPE_SPHERE) return true;
  const real rotational_speed = rotational_speed_of(state, i) + rotational_speed_of(state, j);
  for (u32 k = 0; k < 3; ++k) {
    if (!(std::abs(d[k]) <= mine.box[k] + other.box[k] + h * (std::abs(u[k]) + rotational_speed))) return false;
  }
  return true;
}

/// Every pair of bounded shapes that meets the criterion.
template <class real>
PairList brute_force(const InitialState<real>& state) {
  PairList pairs;
  for (u32 i = 0; i < state.sizes.shapes; ++i) {
    for (u32 j = i + 1; j < state.sizes.shapes; ++j) {
      const auto& infos = state.buffers.shape_infos;
      if (infos[i].kind == SHAPE_PLANE || infos[j].kind == SHAPE_PLANE) continue;
      if (may_touch(state, i, j) && in_range(state, i, j)) pairs.emplace_back(i, j);
    }
  }
  return pairs;
}

}  // namespace lockstep::test
