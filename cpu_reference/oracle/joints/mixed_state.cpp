#include "cpu_reference/oracle/joints/mixed_state.hpp"

#include <algorithm>
#include <cmath>

#include "cpu_reference/oracle/cone/cone.hpp"
#include "cpu_reference/oracle/dense.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double roundings = 64;  // of the load that a defect may be made of

VectorXd start_of(const VectorXd& given, Index size) {
  return given.size() == size ? given : VectorXd(VectorXd::Zero(size));
}

// The rows of sparse columns that are not empty, and what is in them.
template <int Rows>
void gather(const SparseMatrix& matrix, Index first, std::vector<Index>& rows,
            Eigen::Matrix<double, Eigen::Dynamic, Rows>& values) {
  rows.clear();
  for (int k = 0; k < Rows; ++k) {
    for (SparseMatrix::InnerIterator entry(matrix, first + k); entry; ++entry) rows.push_back(entry.row());
  }
  std::ranges::sort(rows);
  rows.erase(std::ranges::unique(rows).begin(), rows.end());
  values.setZero(Index(rows.size()), Rows);
  for (int k = 0; k < Rows; ++k) {
    for (SparseMatrix::InnerIterator entry(matrix, first + k); entry; ++entry)
      values(std::ranges::lower_bound(rows, entry.row()) - rows.begin(), k) = entry.value();
  }
}

// M^-1 H - M^-1 G R^-1 G^T M^-1 H: how velocities answer where joints do.
SparseMatrix with_joints(const SparseMatrix& responses, const SparseMatrix& moves_l, const SparseMatrix& g,
                         const JointSolver& joints) {
  SparseMatrix result(responses.rows(), responses.cols());
  std::vector<Eigen::Triplet<double>> entries;
  for (Index column = 0; column < responses.cols(); ++column) {
    VectorXd moves = responses.col(column);
    const VectorXd seen = g.transpose() * moves;
    if (!seen.isZero(0)) moves -= moves_l * joints.solve(seen);
    for (Index k = 0; k < moves.size(); ++k) {
      if (moves[k] != 0) entries.emplace_back(int(k), int(column), moves[k]);
    }
  }
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

}  // namespace

double BoundedLaw::velocity(double q, double e) const {
  if (spring_compliance > 0) {
    const double left = spring_compliance / (e + spring_compliance), idle = slowest + left * (q - slowest),
                 far = left * e * max_impulse;
    return std::clamp(speed, idle - far, idle + far);
  }
  const double driven = std::clamp(speed, q - e * max_impulse, q + e * max_impulse);
  return driven + (std::clamp(driven, slowest, fastest) - driven) * e / (e + bound_compliance);
}

template <int Rows>
SolvedRows<Rows> MixedState::solved_rows(const SparseMatrix& columns, const SparseMatrix& responses,
                                         Index first) const {
  SolvedRows<Rows> rows;
  gather<Rows>(columns, first, rows.seen, rows.sees);
  gather<Rows>(responses, first, rows.moved, rows.moves);
  rows.mobility.setZero();
  for (std::size_t k = 0; k < rows.seen.size(); ++k) {
    const auto found = std::ranges::lower_bound(rows.moved, rows.seen[k]);
    if (found == rows.moved.end() || *found != rows.seen[k]) continue;
    rows.mobility += rows.sees.row(Index(k)).transpose() * rows.moves.row(found - rows.moved.begin());
  }
  rows.mobility = (0.5 * (rows.mobility + rows.mobility.transpose())).eval();
  return rows;
}

MixedState::MixedState(const MixedProblem& problem, const JointMethod& joints, bool articulated, double accuracy,
                       MixedImpulses start)
    : p_(problem), articulated_(articulated), blocks_(joint_blocks(problem.cones)) {
  const GlobalConeProblem& cones = p_.cones;
  moves_r_ = inverse_times(cones.m, cones.h);
  moves_l_ = inverse_times(cones.m, cones.g);
  moves_z_ = inverse_times(cones.m, p_.d);
  free_ = inverse_times(cones.m, cones.f.sparseView());
  if (cones.g.cols() > 0) joints_ = joints.make(cones, accuracy);
  const bool through_joints = articulated && joints_;
  const SparseMatrix response_r = through_joints ? with_joints(moves_r_, moves_l_, cones.g, *joints_) : moves_r_;
  const SparseMatrix response_z = through_joints ? with_joints(moves_z_, moves_l_, cones.g, *joints_) : moves_z_;
  for (Index i = 0; i < cones.mu.size(); ++i) {
    contacts_.push_back(solved_rows<3>(cones.h, response_r, 3 * i));
    cones_.emplace_back(contacts_.back().mobility, cones.mu[i]);
    mobility_.push_back(largest_eigenvalue(through_joints ? solved_rows<3>(cones.h, moves_r_, 3 * i).mobility
                                                          : contacts_.back().mobility));
  }
  for (Index i = 0; i < p_.d.cols(); ++i) rows_.push_back(solved_rows<1>(p_.d, response_z, i));

  const VectorXd q = cones.h.transpose() * free_ + cones.w, s = cones.g.transpose() * free_ + cones.b;
  scale_ = q.squaredNorm() + s.squaredNorm() + VectorXd(p_.d.transpose() * free_).squaredNorm();
  load_ = load();
  x_ = {start_of(start.r, cones.h.cols()), start_of(start.l, cones.g.cols()), start_of(start.z, p_.d.cols())};
  v_ = velocities(x_);
}

double MixedState::load() const {
  const GlobalConeProblem& cones = p_.cones;
  VectorXd pushes(p_.d.cols());
  for (Index i = 0; i < pushes.size(); ++i) {
    const BoundedLaw& law = p_.laws[std::size_t(i)];
    pushes[i] = law.max_impulse + (law.spring_compliance > 0 ? std::abs(law.slowest) / law.spring_compliance : 0);
  }
  const VectorXd sizes = free_.cwiseAbs() + moves_z_.cwiseAbs() * pushes;
  double largest = 0;
  for (Index i = 0; i < cones.mu.size(); ++i)
    largest = std::max(largest, contacts_[std::size_t(i)].size(sizes).norm() + cones.w.segment<3>(3 * i).norm());
  for (const VectorXd& rows : {VectorXd(cones.g.cwiseAbs().transpose() * sizes + cones.b.cwiseAbs()),
                               VectorXd(p_.d.cwiseAbs().transpose() * sizes)})
    if (rows.size() > 0) largest = std::max(largest, rows.maxCoeff());
  return largest;
}

VectorXd MixedState::velocities(const MixedImpulses& x) const {
  return free_ + moves_r_ * x.r + moves_l_ * x.l + moves_z_ * x.z;
}

void MixedState::sweep() {
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const SolvedRows<3>& contact = contacts_[i];
    auto r = x_.r.segment<3>(3 * Index(i));
    const Vector3d own = r;
    const Vector3d q = contact.velocity(v_) + p_.cones.w.segment<3>(3 * Index(i)) - contact.mobility * own;
    r = cones_[i].solve(q);
    contact.push(r - own, v_);
  }
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const SolvedRows<1>& row = rows_[i];
    const double e = row.mobility(0, 0), own = x_.z[Index(i)];
    if (!(e > 0)) continue;
    const double q = row.velocity(v_)[0] - e * own;
    x_.z[Index(i)] = (p_.laws[i].velocity(q, e) - q) / e;
    row.push(SolvedRows<1>::Impulse(x_.z[Index(i)] - own), v_);
  }
}

void MixedState::close_joints() {
  if (!joints_) return;
  const VectorXd change = joints_->solve(-(p_.cones.g.transpose() * v_ + p_.cones.b));
  x_.l += change;
  v_ += moves_l_ * change;
}

VectorXd MixedState::beyond_joints() const {
  if (!joints_) return {};
  return joints_->beyond(p_.cones.g.transpose() * free_ + p_.cones.b);
}

void MixedState::set(const MixedImpulses& x) {
  x_ = x;
  v_ = velocities(x_);
}

void MixedState::settle() {
  v_ = velocities(x_);
  if (articulated_) close_joints();
}

double MixedState::residual() const {
  double sum = 0;
  const auto add = [&](double w) {
    if (w > roundings * 0x1p-53 * load_) sum += w * w;
  };
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Vector3d w = p_.cones.w.segment<3>(3 * Index(i)), u = contacts_[i].velocity(v_) + w;
    const double rho = mobility_[i] > 0 ? 1 / mobility_[i] : 0;
    add(mobility_[i] * natural_map(x_.r.segment<3>(3 * Index(i)), u, p_.cones.mu[Index(i)], rho).norm());
  }
  const VectorXd rates = p_.cones.g.transpose() * v_ + p_.cones.b;
  for (std::size_t k = 0; p_.cones.g.cols() > 0 && k + 1 < blocks_.size(); ++k) {
    const Index first = blocks_[k], size = blocks_[k + 1] - blocks_[k];
    add(rates.segment(first, size).norm());
  }
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const double u = rows_[i].velocity(v_)[0], e = p_.laws[i].mobility;
    add(std::abs(u - p_.laws[i].velocity(u - e * x_.z[Index(i)], e)));
  }
  if (sum == 0) return 0;
  double scale = scale_;
  if (scale == 0) {
    const VectorXd change = v_ - free_;
    scale = VectorXd(p_.cones.h.transpose() * change).squaredNorm() +
            VectorXd(p_.cones.g.transpose() * change).squaredNorm() + VectorXd(p_.d.transpose() * change).squaredNorm();
  }
  return scale > 0 ? std::sqrt(sum / scale) : 0;
}

}  // namespace lockstep::oracle
