#include "host/scene/compile_articulations.hpp"

#include <algorithm>
#include <tuple>

namespace lockstep {

namespace {

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
    std::ranges::stable_sort(found_, {}, [](const Found& f) { return std::tuple(f.tree, f.level); });
    return std::move(found_);
  }

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

  const Buffers<real>& b_;
  std::vector<std::vector<u32>> joints_;  // of each body
  std::vector<bool> is_found_;
  std::vector<Found> found_;
  std::size_t next_ = 0;
  u32 trees_ = 0;
};

}  // namespace

template <class real>
void find_articulations(Buffers<real>& b) {
  b.articulations.clear();
  b.links.clear();
  b.link_levels.clear();
  for (JointInfo& joint : b.joint_infos) joint.direct = 0;
  std::vector<u32> link_of(b.body_infos.size(), NONE);
  const std::vector<Found> found = Search<real>(b).run();
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
}

template <class real>
void place_link_joints(Buffers<real>& b) {
  std::vector<u32> slots(b.joint_infos.size(), NONE);
  for (u32 slot = 0; slot < b.joint_lanes.size() * PACK; ++slot) {
    const u32 joint = b.joint_lanes[slot / PACK].joint[slot % PACK];
    if (joint != NONE) slots[joint] = slot;
  }
  for (LinkInfo& link : b.links) link.slot = link.joint == NONE ? NONE : slots[link.joint];
}

template void find_articulations<float>(Buffers<float>&);
template void find_articulations<double>(Buffers<double>&);
template void place_link_joints<float>(Buffers<float>&);
template void place_link_joints<double>(Buffers<double>&);

}  // namespace lockstep
