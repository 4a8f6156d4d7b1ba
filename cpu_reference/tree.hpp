// The tree of bounds: a packed R-tree (Kamel and Faloutsos, On packing R-trees, 1993). Shapes are sorted along Morton's
// space-filling curve (Lauterbach et al., Fast BVH Construction on GPUs, 2009); PACK neighbours of the order make a
// run, PACK runs a block, PACK blocks one of the next level, up to one block. Nothing points to anything: the parent of
// entry e is entry e / PACK one level up. kernels/tree.h is the twin.
//
// The order is a guess at what lies together. It decides how fast a search is, never what it finds.
#pragma once

#include <bit>

#include "cpu_reference/pair_test.hpp"

namespace lockstep::reference {

/// Box of nothing: what is missing in a block.
template <class real>
constexpr real tree_far = real(3e38);

/// Cells of the curve along an axis, as bits: so many that a body that has left for good leaves the others apart.
constexpr u32 cell_bits = 16;

/// Words in the order of the floats.
inline u32 ordered_word(float x) {
  const u32 bits = std::bit_cast<u32>(x);
  return (bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u;
}
inline float ordered_float(u32 word) {
  return std::bit_cast<float>((word & 0x80000000u) != 0 ? word ^ 0x80000000u : ~word);
}

/// Bits of a byte, three apart.
inline u32 spread_byte(u32 x) {
  x = (x | (x << 8)) & 0x0000f00fu;
  x = (x | (x << 4)) & 0x000c30c3u;
  return (x | (x << 2)) & 0x00249249u;
}
/// 24 bits of Morton's code, from the lowest bytes of three cells.
inline u32 morton_bytes(u32 x, u32 y, u32 z) {
  return spread_byte(x & 255) | (spread_byte(y & 255) << 1) | (spread_byte(z & 255) << 2);
}

/// Cells are cubes: the longest side of a world's box is divided.
template <class real>
u32 curve_cell(real x, float low, float width) {
  const real cells = real((1u << cell_bits) - 1);
  const real at = width > 0 ? (x - real(low)) / real(width) * cells : real(0);
  if (!(at > 0)) return 0;
  return at < cells ? u32(at) : (1u << cell_bits) - 1;
}

/// Shapes of about one size lie together, so that large ones do not spread the boxes of the small. The largest are 7.
template <class real>
u32 size_class(real extent, u32 max_extent_bits) {
  const real largest = real(std::bit_cast<float>(max_extent_bits));
  u32 size = 7;
  for (real x = 4 * extent; size > 0 && x <= largest; x = 4 * x) --size;
  return size;
}

inline u32 blocks_of(u32 count) { return (count + PACK - 1) / PACK; }

template <class real>
struct TreeBox {
  Vec3<real> low, high;
};

template <class real>
TreeBox<real> widened(const TreeBox<real>& box, real by) {
  return {sub3(box.low, Vec3<real>{by, by, by}), add3(box.high, Vec3<real>{by, by, by})};
}

/// Covers the rounding of the pair test and of the box's own sides.
template <class real>
real padded_extent(real center, real box) {
  const real rounding = sizeof(real) == 4 ? real(5e-7) : real(1e-15);
  return box * real(1.0001) + std::abs(center) * rounding;
}

/// Two shapes are no pair if these boxes are farther apart than the margin: of spheres that of the whole step, which
/// says no more than their spheres; of others what cpu_reference/pair_test.hpp asks of the boxes, shared out.
template <class real>
TreeBox<real> swept_box(const Buffers<real>& b, const Bounded<real>& of, real h) {
  const Bound<real>& bound = of.bound;
  const Vec3<real> center = of.center();
  Vec3<real> box = {bound.extent, bound.extent, bound.extent};
  if (b.shape_infos[of.shape].kind != SHAPE_SPHERE) {
    const Vec3<real> v = center_velocity(b, of);
    const real rotational_speed = rotational_speed_of(b, of);
    box = {bound.box[0] + h * (std::abs(v.x) + rotational_speed), bound.box[1] + h * (std::abs(v.y) + rotational_speed),
           bound.box[2] + h * (std::abs(v.z) + rotational_speed)};
  }
  const Vec3<real> half_extents = {padded_extent(center.x, box.x), padded_extent(center.y, box.y),
                                   padded_extent(center.z, box.z)};
  return {sub3(center, half_extents), add3(center, half_extents)};
}

/// Calls function(e) for each of the `entries` boxes of the lowest level for which, as for all above it, meets(block,
/// k) is true of its block and its slot there. Levels follow one another from the lowest up; each has a block for PACK
/// entries.
template <class real, class Meets, class Function>
void traverse_tree(const BoxBlock<real>* blocks, u32 entries, Meets&& meets, Function&& function) {
  struct Level {
    u32 first, entries;
  };
  std::vector<Level> levels = {{0, entries}};
  while (levels.back().entries > PACK)
    levels.push_back({levels.back().first + blocks_of(levels.back().entries), blocks_of(levels.back().entries)});
  const auto descend = [&](auto& self, std::size_t level, u32 block) -> void {
    for (u32 k = 0; k < PACK; ++k) {
      const u32 entry = block * PACK + k;
      if (entry >= levels[level].entries || !meets(blocks[levels[level].first + block], k)) continue;
      if (level == 0)
        function(entry);
      else
        self(self, level - 1, entry);  // below an entry is the block of its number
    }
  };
  descend(descend, levels.size() - 1, 0);
}

/// The same for those that meet a box.
template <class real, class Function>
void traverse_boxes(const BoxBlock<real>* blocks, u32 entries, const TreeBox<real>& box, Function&& function) {
  const auto meets = [&](const BoxBlock<real>& block, u32 k) {
    return block.low_x[k] <= box.high.x && block.high_x[k] >= box.low.x && block.low_y[k] <= box.high.y &&
           block.high_y[k] >= box.low.y && block.low_z[k] <= box.high.z && block.high_z[k] >= box.low.z;
  };
  traverse_tree(blocks, entries, meets, function);
}

}  // namespace lockstep::reference
