#include "host/scene/compile_articulations.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>
#include <unordered_map>

namespace lockstep {

namespace {

// Ten sweeps hardly bring the weight of what is heavier through a body.
constexpr double least_load = 10;

// A body that a search from the roots has reached.
struct Found {
  u32 tree, level;
  u32 body, parent;  // a body; NONE
  u32 joint;         // NONE where it floats
};

// Breadth first, from all bodies that are held at once: trees are as low as they can be.
template <class real>
class Search {
 public:
  explicit Search(const Buffers<real>& buffers)
      : b_(buffers), joints_(b_.body_infos.size()), is_found_(joints_.size()) {
    for (u32 joint = 0; joint < b_.joint_infos.size(); ++joint) {
      if (!is_hard(joint)) continue;
      for (const u32 body : ends(joint))
        if (moves(body)) joints_[body].push_back(joint);
    }
  }

  std::vector<Found> run() {
    for (u32 joint = 0; joint < b_.joint_infos.size(); ++joint) {
      const auto [a, b] = ends(joint);
      if (is_hard(joint) && moves(a) != moves(b)) add_root(moves(a) ? a : b, joint);
    }
    spread();
    for (u32 body = 0; body < joints_.size(); ++body) {
      if (!joints_[body].empty()) add_root(body, NONE);
      spread();
    }
    join_trees();
    std::ranges::stable_sort(found_, {}, [](const Found& f) { return std::tuple(f.tree, f.level); });
    return std::move(found_);
  }

  /// Joints that close loops, and are few enough in each tree.
  const std::vector<u32>& closures() const { return closures_; }

 private:
  std::array<u32, 2> ends(u32 joint) const { return {b_.joint_infos[joint].body_a, b_.joint_infos[joint].body_b}; }
  bool moves(u32 body) const { return body < b_.body_infos.size() && b_.body_infos[body].kind == BODY_DYNAMIC; }
  bool is_hard(u32 joint) const { return b_.joints[joint].softness == 0 && b_.joints[joint].spring == 0; }

  void add_root(u32 body, u32 joint) {
    if (is_found_[body]) return;
    is_found_[body] = true;
    found_.push_back({trees_++, 0, body, NONE, joint});
  }

  void spread() {
    for (; next_ < found_.size(); ++next_) {
      const Found from = found_[next_];
      for (const u32 joint : joints_[from.body]) {
        const auto [a, b] = ends(joint);
        const u32 other = a == from.body ? b : a;
        if (!moves(other) || is_found_[other]) continue;
        is_found_[other] = true;
        found_.push_back({from.tree, from.level + 1, other, from.body, joint});
      }
    }
  }

  // Trees with a joint between them, that neither of them has, are one where its loops are few enough.
  void join_trees() {
    std::vector<u32> tree_of(joints_.size() + 1, NONE), joined(trees_);
    std::vector<bool> is_in_tree(b_.joint_infos.size(), false);
    for (const Found& f : found_) {
      tree_of[f.body] = f.tree;
      if (f.joint != NONE) is_in_tree[f.joint] = true;
    }
    std::iota(joined.begin(), joined.end(), 0u);
    const auto first_of = [&](u32 tree) {
      while (joined[tree] != tree) tree = joined[tree] = joined[joined[tree]];
      return tree;
    };
    std::vector<std::pair<u32, u32>> loops;  // a tree, a joint
    for (u32 joint = 0; joint < b_.joint_infos.size(); ++joint) {
      if (!is_hard(joint) || is_in_tree[joint]) continue;
      const auto [a, b] = ends(joint);
      if (!moves(a) && !moves(b)) continue;
      loops.emplace_back(tree_of[moves(a) ? a : b], joint);
      if (!moves(a) || !moves(b)) continue;
      const u32 one = first_of(tree_of[a]), other = first_of(tree_of[b]);
      joined[std::max(one, other)] = std::min(one, other);
    }
    std::vector<u32> counts(trees_, 0);
    for (const auto& [tree, joint] : loops) ++counts[first_of(tree)];
    for (const auto& [tree, joint] : loops)
      if (counts[first_of(tree)] <= MAX_CLOSURES) closures_.push_back(joint);
    for (Found& f : found_)
      if (counts[first_of(f.tree)] <= MAX_CLOSURES) f.tree = first_of(f.tree);
  }

  const Buffers<real>& b_;
  std::vector<std::vector<u32>> joints_;  // of each body
  std::vector<bool> is_found_;
  std::vector<Found> found_;
  std::vector<u32> closures_;
  std::size_t next_ = 0;
  u32 trees_ = 0;
};

// Whether some body of the tree, whose links are those, is between loads of `least_load` times its own mass: what is
// behind it, and what is before it, or what holds the root.
template <class real>
bool carries(std::span<const Found> links, const Buffers<real>& b) {
  std::unordered_map<u32, std::size_t> index_of;  // a body's, among the links
  std::vector<double> behind(links.size(), 0), most(links.size(), 0), second(links.size(), 0);
  for (std::size_t i = 0; i < links.size(); ++i) index_of[links[i].body] = i;
  const auto add_side = [&](std::size_t link, double mass) {
    second[link] = std::max(second[link], std::min(most[link], mass));
    most[link] = std::max(most[link], mass);
  };
  for (std::size_t i = links.size(); i-- > 0;) {
    behind[i] += b.masses[links[i].body].mass;
    if (links[i].parent == NONE) continue;
    const std::size_t parent = index_of[links[i].parent];
    behind[parent] += behind[i];
    add_side(parent, behind[i]);
  }
  std::vector<std::size_t> root(links.size());
  for (std::size_t i = 0; i < links.size(); ++i) {
    root[i] = links[i].parent == NONE ? i : root[index_of[links[i].parent]];
    if (links[root[i]].joint != NONE)
      add_side(i, std::numeric_limits<double>::infinity());
    else if (root[i] != i)
      add_side(i, behind[root[i]] - behind[i]);
    if (second[i] >= least_load * b.masses[links[i].body].mass) return true;
  }
  return false;
}

// Leaves those that carry, and what closes loops in them.
template <class real>
void keep_those_that_carry(std::vector<Found>& found, std::vector<u32>& closures, const Buffers<real>& b) {
  std::vector<bool> is_kept(b.body_infos.size() + 1, false);
  std::vector<Found> kept;
  for (std::size_t first = 0, end; first < found.size(); first = end) {
    for (end = first; end < found.size() && found[end].tree == found[first].tree;) ++end;
    const std::span<const Found> tree = std::span(found).subspan(first, end - first);
    if (!carries(tree, b)) continue;
    kept.insert(kept.end(), tree.begin(), tree.end());
    for (const Found& link : tree) is_kept[link.body] = true;
  }
  found = std::move(kept);
  std::erase_if(closures, [&](u32 joint) {
    return !is_kept[b.joint_infos[joint].body_a] && !is_kept[b.joint_infos[joint].body_b];
  });
}

// `link_of`: of each body, NONE of what cannot move.
template <class real>
void set_closures(const std::vector<u32>& joints, const std::vector<u32>& link_of, Buffers<real>& b) {
  if (joints.empty()) return;
  std::vector<std::pair<u32, u32>> loops;  // a link, a joint
  for (const u32 joint : joints) {
    const u32 link = link_of[b.joint_infos[joint].body_a];
    loops.emplace_back(link != NONE ? link : link_of[b.joint_infos[joint].body_b], joint);
  }
  std::ranges::sort(loops);
  u32 columns = static_cast<u32>(b.links.size());  // no less than a first link
  for (const Articulation& tree : b.articulations) {
    const u32 begin = b.link_levels[tree.first_level], end = b.link_levels[tree.first_level + tree.level_count];
    const u32 first = static_cast<u32>(b.closures.size());
    while (b.closures.size() < loops.size() && loops[b.closures.size()].first < end) {
      const u32 joint = loops[b.closures.size()].second;
      b.closures.push_back({joint, NONE, link_of[b.joint_infos[joint].body_a], link_of[b.joint_infos[joint].body_b]});
    }
    const u32 count = static_cast<u32>(b.closures.size()) - first;
    b.closure_sets.push_back({first, count, columns - begin, end - begin});
    columns += count * LINK_ROWS * (end - begin);
  }
}

}  // namespace

template <class real>
void find_articulations(Trees trees, Buffers<real>& b) {
  b.articulations.clear();
  b.links.clear();
  b.link_levels.clear();
  b.closure_sets.clear();
  b.closures.clear();
  for (JointInfo& joint : b.joint_infos) joint.direct = 0;
  std::vector<u32> link_of(b.body_infos.size() + 1, NONE);
  Search<real> search(b);
  std::vector<Found> found = search.run();
  std::vector<u32> closures = search.closures();
  if (trees == Trees::that_carry) keep_those_that_carry(found, closures, b);
  for (u32 i = 0; i < found.size(); ++i) {
    const Found& f = found[i];
    const bool new_tree = i == 0 || found[i - 1].tree != f.tree, new_level = new_tree || found[i - 1].level != f.level;
    if (new_level) b.link_levels.push_back(i);
    if (new_tree) b.articulations.push_back({static_cast<u32>(b.link_levels.size()) - 1, 0, f.body, 0});
    if (new_level) ++b.articulations.back().level_count;
    const u32 parent = f.parent == NONE ? NONE : link_of[f.parent];
    const u32 is_b = f.joint != NONE && b.joint_infos[f.joint].body_b == f.body ? 1 : 0;
    if (parent != NONE && b.links[parent].child_count++ == 0) b.links[parent].first_child = i;
    if (f.joint != NONE && b.joint_infos[f.joint].free == FREE_NOTHING) b.joint_infos[f.joint].direct = 1;
    link_of[f.body] = i;
    b.links.push_back({f.body, parent, f.joint, NONE, 0, 0, is_b, 0});
  }
  if (!b.links.empty()) b.link_levels.push_back(static_cast<u32>(b.links.size()));
  for (const u32 joint : closures)
    if (b.joint_infos[joint].free == FREE_NOTHING) b.joint_infos[joint].direct = 1;
  set_closures(closures, link_of, b);
}

u32 count_closure_columns(std::span<const ClosureSet> sets, u32 links) {
  u32 columns = links;
  for (const ClosureSet& set : sets) columns += set.count * LINK_ROWS * set.links;
  return sets.empty() ? 0 : columns;
}

template <class real>
void set_link_joints(Buffers<real>& b) {
  std::vector<u32> slots(b.joint_infos.size(), NONE);
  for (u32 slot = 0; slot < b.joint_lanes.size() * PACK; ++slot) {
    const u32 joint = b.joint_lanes[slot / PACK].joint[slot % PACK];
    if (joint != NONE) slots[joint] = slot;
  }
  for (LinkInfo& link : b.links) link.slot = link.joint == NONE ? NONE : slots[link.joint];
  for (ClosureInfo& closure : b.closures) closure.slot = slots[closure.joint];
}

template void find_articulations<float>(Trees, Buffers<float>&);
template void find_articulations<double>(Trees, Buffers<double>&);
template void set_link_joints<float>(Buffers<float>&);
template void set_link_joints<double>(Buffers<double>&);

}  // namespace lockstep
