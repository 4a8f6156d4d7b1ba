#include "host/steppers/bounded_cones.hpp"

#include <algorithm>

#include "cpu_reference/oracle/articulated/reduced_cones.hpp"
#include "cpu_reference/oracle/joints/contradiction.hpp"

namespace lockstep {

namespace {

using Eigen::Index;
using Eigen::VectorXd;
using oracle::SparseMatrix;
using oracle::articulated::ReducedProblem;
using Triplets = std::vector<Eigen::Triplet<double>>;

constexpr int most_attempts = 5;
constexpr double unbounded = 1e-6 * double(JOINT_UNBOUNDED);  // of a row in m/s, whatever its size

// A row that is not of a contact: sign * d^T v + offset is the velocity that its law is about.
struct LawRow {
  std::size_t law = 0;
  double sign = 1, offset = 0, compliance = 0;
};

// The laws of a problem as bounds, drives and bilateral rows that give way, all of them columns of H and G.
class LawRows {
 public:
  explicit LawRows(const oracle::MixedProblem& problem) : laws_(problem.laws) {
    for (std::size_t k = 0; k < laws_.size(); ++k) {
      const oracle::BoundedLaw& law = laws_[k];
      if (law.spring_compliance > 0) {
        springs_.push_back({k, 1, -law.slowest, law.spring_compliance});
      } else {
        if (law.slowest > -unbounded) bounds_.push_back({k, 1, -law.slowest, law.bound_compliance});
        if (law.fastest < unbounded) bounds_.push_back({k, -1, law.fastest, law.bound_compliance});
      }
      if (law.max_impulse > 0) drives_.push_back({k, 1, -law.speed, 0});
    }
    extend(problem);
  }

  const oracle::GlobalConeProblem& global() const { return global_; }
  Index contacts() const { return contacts_; }

  /// Of the local problem without its joints.
  ReducedProblem reduced(const oracle::ConeProblem& free) const {
    ReducedProblem p;
    p.friction = free.mu.head(contacts_);
    for (const LawRow& row : bounds_) p.bound_of.push_back(row.law);
    p.max_impulse.resize(Index(drives_.size()));
    p.unheld.resize(Index(drives_.size()));
    for (std::size_t d = 0; d < drives_.size(); ++d) {
      p.max_impulse[Index(d)] = laws_[drives_[d].law].max_impulse;
      p.unheld[Index(d)] = laws_[drives_[d].law].mobility;
    }
    const Index size = 3 * contacts_ + Index(bounds_.size() + drives_.size());
    Triplets triplets;
    const SparseMatrix w = free.w.sparse();
    for (int k = 0; k < w.outerSize(); ++k) {
      for (SparseMatrix::InnerIterator entry(w, k); entry; ++entry) {
        const Index row = row_of(entry.row()), column = row_of(entry.col());
        if (row >= 0 && column >= 0) triplets.emplace_back(int(row), int(column), entry.value());
      }
    }
    p.w.resize(size, size);
    p.w.setFromTriplets(triplets.begin(), triplets.end());
    p.q.resize(size);
    for (Index i = 0; i < free.q.size(); ++i) {
      if (const Index row = row_of(i); row >= 0) p.q[row] = free.q[i];
    }
    return p;
  }

  /// Impulses of the reduced problem, in the order of the local one.
  VectorXd in_threes(const VectorXd& impulses) const {
    VectorXd r = VectorXd::Zero(global_.h.cols());
    for (Index i = 0; i < r.size(); ++i) {
      if (const Index row = row_of(i); row >= 0) r[i] = impulses[row];
    }
    return r;
  }

  /// What impulses of contacts and laws are as those of the reduced problem, to start from.
  VectorXd start(const oracle::MixedImpulses& impulses) const {
    VectorXd r = VectorXd::Zero(3 * contacts_ + Index(bounds_.size() + drives_.size()));
    r.head(impulses.r.size()) = impulses.r;
    for (std::size_t k = 0; k < bounds_.size(); ++k)
      r[3 * contacts_ + Index(k)] = std::max(0.0, bounds_[k].sign * impulses.z[Index(bounds_[k].law)]);
    return r;
  }

  oracle::MixedImpulses impulses(const VectorXd& r, const VectorXd& l) const {
    const Index joints = l.size() - Index(springs_.size());
    oracle::MixedImpulses all = {r.head(3 * contacts_), l.head(joints), VectorXd::Zero(Index(laws_.size()))};
    Index next = 3 * contacts_;
    for (const std::vector<LawRow>* rows : {&bounds_, &drives_})
      for (const LawRow& row : *rows) all.z[Index(row.law)] += row.sign * r[next++];
    for (std::size_t k = 0; k < springs_.size(); ++k) all.z[Index(springs_[k].law)] += l[joints + Index(k)];
    return all;
  }

 private:
  // The row of the reduced problem: laws have the first of three; -1 of the others.
  Index row_of(Index of_three) const {
    if (of_three < 3 * contacts_) return of_three;
    const Index beyond = of_three - 3 * contacts_;
    return beyond % 3 == 0 ? 3 * contacts_ + beyond / 3 : -1;
  }

  // What gives way moves against a velocity of its own, whose mass is its compliance.
  void extend(const oracle::MixedProblem& problem) {
    oracle::GlobalConeProblem whole = problem.cones;
    contacts_ = whole.mu.size();
    const Index rows = Index(bounds_.size() + drives_.size());
    Index velocities = whole.m.rows(), column = whole.h.cols(), joint = whole.g.cols();
    Triplets m = entries(whole.m), h = entries(whole.h), g = entries(whole.g);
    const auto add = [&](Triplets& matrix, Index at, const LawRow& row) {
      for (SparseMatrix::InnerIterator entry(problem.d, int(row.law)); entry; ++entry)
        matrix.emplace_back(int(entry.row()), int(at), row.sign * entry.value());
      if (row.compliance == 0) return;
      matrix.emplace_back(int(velocities), int(at), 1.0);
      m.emplace_back(int(velocities), int(velocities), 1 / row.compliance);
      ++velocities;
    };
    whole.w.conservativeResize(column + 3 * rows);
    whole.w.tail(3 * rows).setZero();
    for (const std::vector<LawRow>* of : {&bounds_, &drives_}) {
      for (const LawRow& row : *of) {
        whole.w[column] = row.offset;
        add(h, column, row);
        column += 3;
      }
    }
    whole.b.conservativeResize(joint + Index(springs_.size()));
    if (!whole.first.empty() || !springs_.empty()) whole.first = joint_blocks(problem.cones);
    for (const LawRow& row : springs_) {
      whole.b[joint] = row.offset;
      add(g, joint, row);
      whole.first.push_back(static_cast<std::uint32_t>(++joint));
    }
    whole.mu.conservativeResize(contacts_ + rows);
    whole.mu.tail(rows).setZero();
    const Index before = whole.f.size();
    whole.f.conservativeResize(velocities);
    whole.f.tail(velocities - before).setZero();
    whole.m = matrix(velocities, velocities, m);
    whole.h = matrix(velocities, column, h);
    whole.g = matrix(velocities, joint, g);
    global_ = std::move(whole);
  }

  static Triplets entries(const SparseMatrix& of) {
    Triplets triplets;
    for (int k = 0; k < of.outerSize(); ++k)
      for (SparseMatrix::InnerIterator entry(of, k); entry; ++entry)
        triplets.emplace_back(int(entry.row()), int(entry.col()), entry.value());
    return triplets;
  }
  static SparseMatrix matrix(Index rows, Index columns, const Triplets& triplets) {
    SparseMatrix result(rows, columns);
    result.setFromTriplets(triplets.begin(), triplets.end());
    return result;
  }

  const std::vector<oracle::BoundedLaw>& laws_;
  std::vector<LawRow> bounds_, drives_, springs_;
  Index contacts_ = 0;
  oracle::GlobalConeProblem global_;
};

}  // namespace

// Without its joints a contact is less mobile, and U another velocity: what is missing of the residual of the system is
// asked for in that of the reduced problem.
oracle::SolveReport solve_bounded_cones(const oracle::ConeSolver& solver, const WholeSystemProblem& whole,
                                        ContactSystem& system, const oracle::SolveLimits& limits) {
  const LawRows rows(whole.problem);
  const oracle::ConeProblem local = oracle::local_form(rows.global());
  const oracle::JointElimination elimination(local);
  const ReducedProblem problem = rows.reduced(elimination.reduced());
  VectorXd r = rows.start(whole.impulses);
  const oracle::MixedSolver& measure = *oracle::find_mixed_solver("mixed_ldlt");  // that makes no sweep
  oracle::MixedImpulses impulses;
  oracle::SolveReport sum;
  oracle::SolveLimits left = limits;
  for (int attempt = 0; attempt < most_attempts; ++attempt) {
    const oracle::SolveReport solved = solve_reduced_cones(solver, problem, left, r);
    sum.stop = solved.stop;
    sum.iterations += solved.iterations;
    sum.seconds += solved.seconds;
    const VectorXd l = elimination.joint_impulses(rows.in_threes(r));
    impulses = rows.impulses(r, l);
    sum.residual = oracle::solve_mixed(whole.problem, measure, {limits.tolerance, 0, left.seconds}, impulses).residual;
    if (solved.stop != oracle::Stop::solved || sum.residual <= limits.tolerance) break;
    sum.stop = oracle::Stop::stalled;
    left.tolerance *= std::min(0.5, 0.5 * limits.tolerance / sum.residual);
    left.iterations -= std::min(left.iterations, solved.iterations);
    left.seconds -= solved.seconds;
  }
  if (sum.residual <= limits.tolerance) sum.stop = oracle::Stop::solved;
  if (sum.stop == oracle::Stop::stalled && oracle::proves_contradiction(rows.global(), elimination.beyond_joints()))
    sum.stop = oracle::Stop::infeasible;
  set_impulses(system, impulses_of(system, impulses));
  return sum;
}

}  // namespace lockstep
