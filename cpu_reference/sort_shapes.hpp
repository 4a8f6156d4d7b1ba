// Puts the top-level shapes into the order of the tree of bounds: world by world, in a world the smaller before the
// larger, those of about one size along Morton's curve through the world's box, equal ones by index
// (cpu_reference/tree.hpp).
#pragma once

#include <algorithm>
#include <numeric>

#include "cpu_reference/tree.hpp"

namespace lockstep::reference {

struct CurveKey {
  u32 world, high, low;
  bool operator<(const CurveKey& other) const {
    if (world != other.world) return world < other.world;
    return high != other.high ? high < other.high : low < other.low;
  }
};

/// What is not bounded comes last.
template <class real>
CurveKey curve_key(const Buffers<real>& b, u32 i) {
  const u32 world = b.body_infos[b.shape_infos[top_level_shape(b, i)].body].world;
  const Bound<real>& bound = b.bounds[i];
  if (!(bound.extent > 0)) return {world, 0x07ffffffu, 0x00ffffffu};
  float low[3], width = 0;
  for (u32 k = 0; k < 3; ++k) {
    low[k] = ordered_float(b.world_boxes[world].low[k]);
    const float side = ordered_float(b.world_boxes[world].high[k]) - low[k];
    width = side > width ? side : width;
  }
  const u32 x = curve_cell(bound.center[0], low[0], width);
  const u32 y = curve_cell(bound.center[1], low[1], width);
  const u32 z = curve_cell(bound.center[2], low[2], width);
  const u32 size = size_class(bound.extent, b.counters[COUNTER_MAX_EXTENT]);
  return {world, (size << 24) | morton_bytes(x >> 8, y >> 8, z >> 8), morton_bytes(x, y, z)};
}

template <class real>
void sort_shapes(Buffers<real>& b, const StepParams<real>& params) {
  std::fill(b.world_boxes.begin(), b.world_boxes.end(), WorldBox{{NONE, NONE, NONE}, {0, 0, 0}});
  for (u32 i = 0; i < top_level_count(params); ++i) {
    if (!(b.bounds[i].extent > 0)) continue;
    WorldBox& box = b.world_boxes[b.body_infos[b.shape_infos[top_level_shape(b, i)].body].world];
    for (u32 k = 0; k < 3; ++k) {
      const u32 word = ordered_word(float(b.bounds[i].center[k]));
      box.low[k] = std::min(box.low[k], word);
      box.high[k] = std::max(box.high[k], word);
    }
  }
  std::vector<CurveKey> keys(top_level_count(params));
  for (u32 i = 0; i < top_level_count(params); ++i) keys[i] = curve_key(b, i);
  std::iota(b.tree_items.begin(), b.tree_items.end(), 0u);
  std::stable_sort(b.tree_items.begin(), b.tree_items.end(), [&](u32 i, u32 j) { return keys[i] < keys[j]; });
}

}  // namespace lockstep::reference
