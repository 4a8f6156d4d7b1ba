#include "cpu_reference/oracle/joints/joint_ldlt.hpp"

#include "cpu_reference/oracle/dense.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

JointLdlt::JointLdlt(const SparseMatrix& m, const SparseMatrix& g, const Mechanism& mechanism)
    : tree_(m, g, mechanism) {
  const auto count = static_cast<Index>(tree_.left_out().size());
  if (count == 0) return;
  std::vector<Eigen::Triplet<double>> entries;
  for (Index k = 0; k < count; ++k) {
    for (SparseMatrix::InnerIterator entry(g, tree_.left_out()[std::size_t(k)]); entry; ++entry)
      entries.emplace_back(int(entry.row()), int(k), entry.value());
  }
  closing_ = SparseMatrix(m.rows(), count);
  closing_.setFromTriplets(entries.begin(), entries.end());
  MatrixXd s(count, count);
  for (Index k = 0; k < count; ++k) {
    VectorXd v = closing_.col(k), l = VectorXd::Zero(g.cols());
    tree_.solve(v, l);
    s.col(k) = closing_.transpose() * v;
  }
  mobility_ = 0.5 * (s + s.transpose());
  inverse_ = pseudo_inverse(mobility_, redundant_rows);
}

void JointLdlt::solve(VectorXd& v, VectorXd& l) const {
  const std::vector<Index>& left_out = tree_.left_out();
  if (left_out.empty()) return tree_.solve(v, l);
  const VectorXd h = v, s = l;
  tree_.solve(v, l);
  VectorXd rate = closing_.transpose() * v;
  for (std::size_t k = 0; k < left_out.size(); ++k) rate[Index(k)] += s[left_out[k]];
  const VectorXd closing = -inverse_ * rate;
  v = h + closing_ * closing;
  l = s;
  tree_.solve(v, l);
  for (std::size_t k = 0; k < left_out.size(); ++k) l[left_out[k]] = closing[Index(k)];
}

VectorXd JointLdlt::solve(const VectorXd& c) const {
  VectorXd v = VectorXd::Zero(tree_.velocities()), l = -c;
  solve(v, l);
  return l;
}

VectorXd JointLdlt::beyond(const VectorXd& c) const {
  const std::vector<Index>& left_out = tree_.left_out();
  VectorXd v = VectorXd::Zero(tree_.velocities()), y = -c;
  if (left_out.empty()) return VectorXd::Zero(c.size());
  tree_.solve(v, y);
  VectorXd rate = closing_.transpose() * v;
  for (std::size_t k = 0; k < left_out.size(); ++k) rate[Index(k)] -= c[left_out[k]];
  for (int k = 0; k < 3; ++k) rate -= mobility_ * (inverse_ * rate);
  v = closing_ * rate;
  y = VectorXd::Zero(c.size());
  tree_.solve(v, y);
  for (std::size_t k = 0; k < left_out.size(); ++k) y[left_out[k]] = rate[Index(k)];
  return y;
}

std::unique_ptr<JointSolver> make_joint_ldlt(const GlobalConeProblem& problem) {
  return std::make_unique<JointLdlt>(problem.m, problem.g,
                                     mechanism_of(problem.m, problem.g, problem.bodies, joint_blocks(problem)));
}

}  // namespace lockstep::oracle
