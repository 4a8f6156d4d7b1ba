#include "cpu_reference/oracle/joints/tree_ldlt.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <stdexcept>

#include "cpu_reference/oracle/joints/sets.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::Index;
using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Of what a row of a joint moves without the others, the share that has to be left with them.
constexpr double dependent = 1e-11;

template <class Vector>
void solve_cholesky(const double* factor, Vector&& x) {
  const Index n = x.rows();
  const Map<const MatrixXd> c(factor, n, n);
  c.triangularView<Eigen::Lower>().solveInPlace(x);
  c.triangularView<Eigen::Lower>().transpose().solveInPlace(x);
}

}  // namespace

TreeLdlt::TreeLdlt(const SparseMatrix& m, const SparseMatrix& g, const Mechanism& mechanism)
    : slot_of_velocity_(std::size_t(m.rows())), slot_of_row_(std::size_t(g.cols()), -1) {
  order(mechanism);
  assemble(m, g);
  factorise();
}

void TreeLdlt::order(const Mechanism& mechanism) {
  const std::size_t bodies = mechanism.bodies.size(), joints = mechanism.joints.size(), world = bodies;
  DisjointSets together(bodies + 1);
  std::vector<std::vector<std::uint32_t>> joints_of(bodies);
  std::vector<std::uint32_t> roots;  // joints
  for (std::uint32_t j = 0; j < joints; ++j) {
    const Mechanism::Joint& joint = mechanism.joints[j];
    std::vector<std::size_t> sets;
    for (const std::uint32_t body : joint.bodies) sets.push_back(together.find(body));
    const bool on_world = sets.size() == 1;
    if (on_world) sets.push_back(together.find(world));
    std::ranges::sort(sets);
    if (std::ranges::adjacent_find(sets) != sets.end()) {
      left_out_.insert(left_out_.end(), joint.rows.begin(), joint.rows.end());
      continue;
    }
    for (std::size_t i = 1; i < sets.size(); ++i) together.unite(sets[0], sets[i]);
    for (const std::uint32_t body : joint.bodies) joints_of[body].push_back(j);
    if (on_world) roots.push_back(j);
  }

  // from the roots outwards
  std::vector<bool> reached(bodies, false);
  const auto grow = [&](Node root) {
    std::size_t next = nodes_.size();
    nodes_.push_back(root);
    for (; next < nodes_.size(); ++next) {
      const Node node = nodes_[next];
      const auto add = [&](bool is_joint, std::uint32_t index) {
        const bool is_parent = node.parent != none && nodes_[node.parent].index == index;
        if (!is_parent) nodes_.push_back({is_joint, index, static_cast<std::uint32_t>(next)});
      };
      if (node.is_joint) {
        for (const std::uint32_t body : mechanism.joints[node.index].bodies) add(false, body);
      } else {
        reached[node.index] = true;
        for (const std::uint32_t joint : joints_of[node.index]) add(true, joint);
      }
    }
  };
  for (const std::uint32_t joint : roots) grow({true, joint});
  for (std::uint32_t body = 0; body < bodies; ++body) {
    if (!reached[body]) grow({false, body});
  }

  std::ranges::reverse(nodes_);
  for (Node& node : nodes_) {
    if (node.parent != none) node.parent = static_cast<std::uint32_t>(nodes_.size() - 1 - node.parent);
    const auto& members = node.is_joint ? mechanism.joints[node.index].rows : mechanism.bodies[node.index];
    std::vector<Index>& slots = node.is_joint ? slot_of_row_ : slot_of_velocity_;
    node.first = size_;
    node.size = static_cast<Index>(members.size());
    for (const Index member : members) slots[std::size_t(member)] = size_++;
  }
}

void TreeLdlt::assemble(const SparseMatrix& m, const SparseMatrix& g) {
  std::vector<std::uint32_t> node_of(std::size_t(size_), none);
  std::size_t size = 0;
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    for (Index k = 0; k < node.size; ++k) node_of[std::size_t(node.first + k)] = i;
    node.factor = size;
    size += std::size_t(node.size * node.size);
    node.lower = size;
    if (node.parent != none) size += std::size_t(node.size * nodes_[node.parent].size);
  }
  data_.assign(size, 0.0);
  for (int column = 0; column < m.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator entry(m, column); entry; ++entry) {
      const Index a = slot_of_velocity_[std::size_t(entry.row())], b = slot_of_velocity_[std::size_t(entry.col())];
      const Node& node = nodes_[node_of[std::size_t(a)]];
      data_[node.factor + std::size_t((b - node.first) * node.size + a - node.first)] = entry.value();
    }
  }
  for (int row = 0; row < g.outerSize(); ++row) {
    const Index at_row = slot_of_row_[std::size_t(row)];
    if (at_row < 0) continue;
    const std::uint32_t joint_node = node_of[std::size_t(at_row)];
    const Node& joint = nodes_[joint_node];
    for (SparseMatrix::InnerIterator entry(g, row); entry; ++entry) {
      const Index at = slot_of_velocity_[std::size_t(entry.row())];
      const std::uint32_t body_node = node_of[std::size_t(at)];
      const Node& body = nodes_[body_node];
      const bool joint_is_child = joint.parent == body_node;
      const Node& child = joint_is_child ? joint : body;
      const Node& parent = joint_is_child ? body : joint;
      const Index in_child = (joint_is_child ? at_row : at) - child.first;
      const Index in_parent = (joint_is_child ? at : at_row) - parent.first;
      data_[child.lower + std::size_t(in_child * parent.size + in_parent)] = -entry.value();
    }
  }
}

void TreeLdlt::factorise() {
  for (Node& node : nodes_) eliminate(node);
  for (std::size_t row = 0; row < slot_of_row_.size(); ++row) {
    const Index slot = slot_of_row_[row];
    if (slot < 0) continue;
    const auto node = std::ranges::upper_bound(nodes_, slot, {}, &Node::first) - 1;
    if (!node->left_out) continue;
    left_out_.push_back(static_cast<Index>(row));
    slot_of_row_[row] = -1;
  }
  std::ranges::sort(left_out_);
}

void TreeLdlt::eliminate(Node& node) {
  Map<MatrixXd> d(data_.data() + node.factor, node.size, node.size);
  const double sign = node.is_joint ? -1 : 1;
  d *= sign;
  const VectorXd alone = d.diagonal();
  Eigen::Ref<MatrixXd> block(d);
  const Eigen::LLT<Eigen::Ref<MatrixXd>> cholesky(block);
  const bool regular =
      cholesky.info() == Eigen::Success && (d.diagonal().array().square() > dependent * alone.array()).all();
  if (!regular && !node.is_joint) throw std::runtime_error("M is not positive definite");
  node.left_out = !regular;
  if (node.left_out || node.parent == none) return;
  const Node& parent = nodes_[node.parent];
  Map<MatrixXd> k(data_.data() + node.lower, parent.size, node.size);
  MatrixXd response = k.transpose();
  solve_cholesky(data_.data() + node.factor, response);
  Map<MatrixXd>(data_.data() + parent.factor, parent.size, parent.size).noalias() -= sign * k.lazyProduct(response);
  k = sign * response.transpose();
}

void TreeLdlt::solve(VectorXd& v, VectorXd& l) const {
  VectorXd x = VectorXd::Zero(size_);
  for (std::size_t i = 0; i < slot_of_velocity_.size(); ++i) x[slot_of_velocity_[i]] = v[Index(i)];
  for (std::size_t i = 0; i < slot_of_row_.size(); ++i) {
    if (slot_of_row_[i] >= 0) x[slot_of_row_[i]] = l[Index(i)];
  }
  const auto has_parent = [&](const Node& node) { return node.parent != none && !nodes_[node.parent].left_out; };
  const auto lower = [&](const Node& node) {
    return Map<const MatrixXd>(data_.data() + node.lower, nodes_[node.parent].size, node.size);
  };
  const auto segment = [&](const Node& node) { return x.segment(node.first, node.size); };
  for (const Node& node : nodes_) {
    if (node.left_out) continue;
    if (has_parent(node)) segment(nodes_[node.parent]).noalias() -= lower(node).lazyProduct(segment(node));
    auto own = segment(node);
    solve_cholesky(data_.data() + node.factor, own);
    if (node.is_joint) own = -own;
  }
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
    if (node->left_out || !has_parent(*node)) continue;
    segment(*node).noalias() -= lower(*node).transpose().lazyProduct(segment(nodes_[node->parent]));
  }
  for (std::size_t i = 0; i < slot_of_velocity_.size(); ++i) v[Index(i)] = x[slot_of_velocity_[i]];
  for (std::size_t i = 0; i < slot_of_row_.size(); ++i) l[Index(i)] = slot_of_row_[i] >= 0 ? x[slot_of_row_[i]] : 0;
}

}  // namespace lockstep::oracle
