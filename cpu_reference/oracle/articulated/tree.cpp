#include "cpu_reference/oracle/articulated/tree.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lockstep::oracle::articulated {

namespace {

// Who is found from whom, breadth first.
struct Search {
  explicit Search(const System& whole) : system(whole), joints_of(whole.bodies.size()) {
    for (std::size_t j = 0; j < whole.joints.size(); ++j) {
      const Joint& joint = whole.joints[j];
      for (const std::size_t body : {joint.body_a, joint.body_b}) {
        if (is_link(body) && joint.type != JointType::distance) joints_of[body].push_back(j);
      }
    }
    link_of.assign(whole.bodies.size(), no_link);
    used.assign(whole.joints.size(), false);
  }

  bool is_link(std::size_t body) const { return body != world && system.bodies[body].is_link; }

  void add(Link link) {
    link.tree = link.parent == no_link ? trees++ : links[link.parent].tree;
    link_of[link.body] = links.size();
    if (link.joint != no_link) used[link.joint] = true;
    links.push_back(link);
  }

  // The other body of a joint becomes a child.
  void add_over(std::size_t joint, std::size_t parent_body, std::size_t parent) {
    const Joint& j = system.joints[joint];
    const bool child_is_b = j.body_a == parent_body;
    const std::size_t child = child_is_b ? j.body_b : j.body_a;
    if (!is_link(child) || link_of[child] != no_link) return;
    add({.body = child, .parent = parent, .joint = joint, .parent_body = parent_body, .child_is_b = child_is_b});
  }

  void grow() {
    for (; next < links.size(); ++next) {
      const std::size_t body = links[next].body;
      for (const std::size_t joint : joints_of[body]) add_over(joint, body, next);
    }
  }

  const System& system;
  std::vector<std::vector<std::size_t>> joints_of;
  std::vector<Link> links;
  std::vector<std::size_t> link_of;
  std::vector<bool> used;
  std::size_t next = 0, trees = 0;
};

Pose moved_pose(const Pose& pose, const Vector6& twist, double dt) {
  return {pose.x + dt * twist.head<3>(), (rotation_by_vector(dt * twist.tail<3>()) * pose.q).normalized()};
}

}  // namespace

Tree::Tree(const System& system) : system_(system) {
  Search search(system);
  for (std::size_t j = 0; j < system.joints.size(); ++j) {
    const Joint& joint = system.joints[j];
    if (joint.type == JointType::distance) continue;
    for (const std::size_t body : {joint.body_a, joint.body_b}) {
      if (!search.is_link(body)) search.add_over(j, body, no_link);
    }
  }
  search.grow();
  for (std::size_t body = 0; body < system.bodies.size(); ++body) {
    if (!system.bodies[body].is_link || search.link_of[body] != no_link) continue;
    search.add({.body = body});
    search.grow();
  }

  // the links of a tree in a row
  std::vector<std::size_t> order(search.links.size()), rank(search.links.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return search.links[i].tree; });
  for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = i;
  link_of_.assign(system.bodies.size(), no_link);
  for (const std::size_t i : order) {
    Link link = search.links[i];
    if (link.parent != no_link) link.parent = rank[link.parent];
    link.first = freedoms_;
    link.freedoms = link.joint == no_link ? 6 : articulated::freedoms(system.joints[link.joint].type);
    freedoms_ += link.freedoms;
    if (link.parent == no_link) starts_.push_back(links_.size());
    link_of_[link.body] = links_.size();
    links_.push_back(link);
  }
  starts_.push_back(links_.size());
  for (std::size_t j = 0; j < system.joints.size(); ++j) {
    const bool acts = search.is_link(system.joints[j].body_a) || search.is_link(system.joints[j].body_b);
    if (acts && !search.used[j]) closures_.push_back(j);
  }
}

Pose pose_of(const Configuration& configuration, std::size_t body) {
  return body == world ? Pose() : configuration.poses[body];
}

JointGeometry joint_geometry(const Joint& joint, const Configuration& at) {
  return joint_geometry(joint, pose_of(at, joint.body_a), pose_of(at, joint.body_b));
}

Configuration measured(const Tree& tree, std::vector<Pose> poses) {
  Configuration c = {std::move(poses), std::vector<Coordinates>(tree.size())};
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const Link& link = tree.link(i);
    if (link.joint == no_link) continue;
    const Joint& joint = tree.joint_of(link);
    c.coordinates[i] = measured(joint, joint_geometry(joint, c));
  }
  close_trees(tree, c);
  return c;
}

void close_trees(const Tree& tree, Configuration& c) {
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const Link& link = tree.link(i);
    if (link.joint == no_link) continue;
    const Joint& joint = tree.joint_of(link);
    const Pose parent = pose_of(c, link.parent_body);
    c.poses[link.body] =
        link.child_is_b ? pose_of_b(joint, parent, c.coordinates[i]) : pose_of_a(joint, parent, c.coordinates[i]);
  }
}

Configuration moved(const Tree& tree, const Configuration& from, const VectorXd& rates,
                    const std::vector<Vector6>& twists, double dt) {
  Configuration to = from;
  for (std::size_t body = 0; body < from.poses.size(); ++body) {
    if (tree.link_of(body) == no_link) to.poses[body] = moved_pose(from.poses[body], twists[body], dt);
  }
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const Link& link = tree.link(i);
    const auto own = rates.segment(link.first, link.freedoms);
    if (link.joint == no_link)
      to.poses[link.body] = moved_pose(from.poses[link.body], own, dt);
    else
      to.coordinates[i] = moved(tree.joint_of(link), from.coordinates[i], own, dt);
  }
  close_trees(tree, to);
  return to;
}

}  // namespace lockstep::oracle::articulated
