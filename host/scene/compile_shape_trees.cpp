#include "host/scene/compile_shape_trees.hpp"

#include <algorithm>
#include <cmath>

#include "host/scene/extents.hpp"

namespace lockstep {

namespace {

template <class real>
Vector3 offset_of(const Shape<real>& shape) {
  return {double(shape.offset[0]), double(shape.offset[1]), double(shape.offset[2])};
}

// Around a shape, in the frame of its body: as cpu_reference/shape_bound.hpp, but that round ones take their bounding
// radius.
template <class real>
Extents box_of(const Shape<real>& shape, u32 kind) {
  const Quaternion rotation = {double(shape.rotation[0]), double(shape.rotation[1]), double(shape.rotation[2]),
                               double(shape.rotation[3])};
  const Vector3 center = offset_of(shape);
  const double bounding_radius = double(shape.bounding_radius);
  Vector3 half = {bounding_radius, bounding_radius, bounding_radius};
  if (kind == SHAPE_BOX || kind == SHAPE_HULL) {
    half = {0, 0, 0};
    for (unsigned axis = 0; axis < 3; ++axis) {
      Vector3 side = {0, 0, 0};
      side[axis] = double(shape.size[axis]);
      const Vector3 rotated = exact::rotate(rotation, side);
      for (unsigned k = 0; k < 3; ++k) half[k] += std::abs(rotated[k]);
    }
  }
  Extents box;
  for (unsigned k = 0; k < 3; ++k) {
    const double slack =
        2e-5 * bounding_radius + 1e-6 * std::abs(center[k]);  // covers the rounding of who looks for it
    box.low[k] = center[k] - half[k] - slack;
    box.high[k] = center[k] + half[k] + slack;
  }
  return box;
}

// Along Morton's curve through a box (cpu_reference/tree.hpp): a guess at what lies together.
u32 curve_key(const Vector3& at, const Extents& box) {
  constexpr u32 bits = 10;
  double width = 0;
  for (unsigned k = 0; k < 3; ++k) width = std::max(width, box.high[k] - box.low[k]);
  u32 key = 0;
  for (unsigned k = 0; k < 3; ++k) {
    const double fraction = width > 0 ? (at[k] - box.low[k]) / width : 0;
    const u32 cell = static_cast<u32>(std::clamp(fraction * (1 << bits), 0.0, (1 << bits) - 1.0));
    for (u32 bit = 0; bit < bits; ++bit) key |= (cell >> bit & 1) << (3 * bit + k);
  }
  return key;
}

template <class real>
void set_box(BoxBlock<real>& block, u32 k, const Extents& box) {
  real* const low[] = {block.low_x, block.low_y, block.low_z};
  real* const high[] = {block.high_x, block.high_y, block.high_z};
  for (unsigned axis = 0; axis < 3; ++axis) {
    low[axis][k] = static_cast<real>(std::max(box.low[axis], -3e38));
    high[axis][k] = static_cast<real>(std::min(box.high[axis], 3e38));
  }
}

template <class real>
class Forest {
 public:
  explicit Forest(Buffers<real>& buffers) : b_(buffers) {}

  void add_world(u32 world) {
    const WorldRange range = b_.world_ranges[world];
    WorldTrees trees = {count(b_.top_level_shapes), 0, count(b_.shape_trees), 0};
    const u32 end = range.first_shape + range.shape_count;
    for (u32 first = range.first_shape; first < end;) {
      u32 past = first;
      while (past < end && b_.shape_infos[past].body == b_.shape_infos[first].body) ++past;
      const std::vector<u32> items = items_of(first, past);
      if (items.size() >= fewest_in_tree) add_tree(items);
      for (u32 i = first; i < past; ++i)
        if ((b_.shape_infos[i].flags & SHAPE_IS_IN_TREE) == 0) b_.top_level_shapes.push_back(i);
      first = past;
    }
    trees.top_level_count = count(b_.top_level_shapes) - trees.first_top_level;
    trees.tree_count = count(b_.shape_trees) - trees.first_tree;
    b_.world_trees.push_back(trees);
  }

 private:
  static u32 count(const auto& elements) { return static_cast<u32>(elements.size()); }

  // Of the shapes of a body, those that a tree of it would hold.
  std::vector<u32> items_of(u32 first, u32 past) const {
    std::vector<u32> items;
    items.reserve(past - first);
    if (b_.body_infos[b_.shape_infos[first].body].kind == BODY_DYNAMIC) return items;
    for (u32 i = first; i < past; ++i) {
      if (b_.shape_infos[i].flags & SHAPE_IS_TRIGGER) return {};
      if (b_.shape_infos[i].kind != SHAPE_PLANE) items.push_back(i);
    }
    return items;
  }

  void add_tree(std::vector<u32> items) {
    ShapeTree<real> tree = {};
    tree.body = b_.shape_infos[items[0]].body;
    tree.first_item = count(b_.shape_tree_items);
    tree.item_count = count(items);
    tree.first_block = count(b_.shape_tree_blocks);
    Extents whole;
    double radius = 0;
    for (const u32 i : items) {
      const Shape<real>& shape = b_.shapes[i];
      b_.shape_infos[i].flags |= SHAPE_IS_IN_TREE;
      whole.unite(box_of(shape, b_.shape_infos[i].kind));
      radius = std::max(radius, exact::length(offset_of(shape)) + double(shape.bounding_radius));
      tree.largest = std::max(tree.largest, shape.bounding_radius);
    }
    tree.radius = static_cast<real>(radius * 1.000001);
    sort_along_curve(items, whole);
    b_.shape_tree_items.insert(b_.shape_tree_items.end(), items.begin(), items.end());
    b_.shape_trees.push_back(tree);

    std::size_t blocks = 0;
    for (std::size_t entries = items.size(); entries > 1 || blocks == 0;)
      blocks += entries = (entries + PACK - 1) / PACK;
    b_.shape_tree_blocks.reserve(b_.shape_tree_blocks.size() + blocks);
    std::vector<Extents> boxes = add_level(
        items.size(), [&](std::size_t e) { return box_of(b_.shapes[items[e]], b_.shape_infos[items[e]].kind); });
    while (boxes.size() > 1) boxes = add_level(boxes.size(), [&](std::size_t e) { return boxes[e]; });
  }

  // In order of their places along the curve, then of their indices.
  void sort_along_curve(std::vector<u32>& items, const Extents& whole) const {
    std::vector<std::pair<u32, u32>> keys;
    keys.reserve(items.size());
    for (const u32 i : items) keys.emplace_back(curve_key(offset_of(b_.shapes[i]), whole), i);
    std::ranges::sort(keys);
    for (std::size_t k = 0; k < keys.size(); ++k) items[k] = keys[k].second;
  }

  // Blocks of so many boxes; what each of them spans.
  template <class BoxAt>
  std::vector<Extents> add_level(std::size_t boxes, BoxAt&& box_at) {
    std::vector<Extents> above;
    above.reserve((boxes + PACK - 1) / PACK);
    for (std::size_t e = 0; e < boxes; e += PACK) {
      BoxBlock<real>& block = b_.shape_tree_blocks.emplace_back();
      Extents& united = above.emplace_back();
      for (u32 k = 0; k < PACK; ++k) {
        const Extents box = e + k < boxes ? box_at(e + k) : Extents{};
        set_box(block, k, box);
        united.unite(box);
      }
    }
    return above;
  }

  Buffers<real>& b_;
};

}  // namespace

template <class real>
void compile_shape_trees(InitialState<real>& state) {
  Buffers<real>& b = state.buffers;
  Forest<real> forest(b);
  for (u32 world = 0; world < b.world_ranges.size(); ++world) forest.add_world(world);
  if (b.shape_trees.empty()) {
    b.top_level_shapes.clear();
    b.world_trees.clear();
    return;
  }
  state.features = with(state.features, Feature::shape_trees);
  state.sizes.shape_trees = static_cast<u32>(b.shape_trees.size());
  state.sizes.tree_shapes = static_cast<u32>(b.shape_tree_items.size());
  state.sizes.shape_tree_blocks = static_cast<u32>(b.shape_tree_blocks.size());
}

template void compile_shape_trees<float>(InitialState<float>&);
template void compile_shape_trees<double>(InitialState<double>&);

}  // namespace lockstep
