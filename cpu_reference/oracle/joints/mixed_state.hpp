// A problem of contacts, joints and bounded rows as sweeps see it (mixed.hpp): velocities, and what each row does to
// them.
#pragma once

#include <optional>

#include "cpu_reference/oracle/cone/local_cone.hpp"
#include "cpu_reference/oracle/joints/joint_solver.hpp"
#include "cpu_reference/oracle/joints/mixed.hpp"

namespace lockstep::oracle {

/// Rows that are solved together: what they see of velocities, and how velocities answer.
template <int Rows>
struct SolvedRows {
  using Impulse = Eigen::Matrix<double, Rows, 1>;
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, Rows>;

  std::vector<Eigen::Index> seen, moved;  // velocities
  Columns sees, moves;                    // of H; of M^-1 H, or what joints leave of it
  Eigen::Matrix<double, Rows, Rows> mobility;

  /// Sums of the sizes that velocity() adds up.
  Impulse size(const Eigen::VectorXd& v) const {
    Impulse u = Impulse::Zero();
    for (std::size_t k = 0; k < seen.size(); ++k) u += v[seen[k]] * sees.row(Eigen::Index(k)).cwiseAbs().transpose();
    return u;
  }
  Impulse velocity(const Eigen::VectorXd& v) const {
    Impulse u = Impulse::Zero();
    for (std::size_t k = 0; k < seen.size(); ++k) u += v[seen[k]] * sees.row(Eigen::Index(k)).transpose();
    return u;
  }
  void push(const Impulse& change, Eigen::VectorXd& v) const {
    for (std::size_t k = 0; k < moved.size(); ++k) v[moved[k]] += moves.row(Eigen::Index(k)).dot(change);
  }
};

class MixedState {
 public:
  /// The problem must outlive it. `accuracy`: of the joints, relative to what a sweep left of them.
  MixedState(const MixedProblem& problem, const JointMethod& joints, bool articulated, double accuracy,
             MixedImpulses start);

  /// All contacts and bounded rows, one by one.
  void sweep();
  /// All joints together: by what the sweep left of them.
  void close_joints();
  /// Velocities anew from the impulses, so that rounding does not add up; of articulated sweeps, which do not say what
  /// joints did, their impulses too.
  void settle();

  /// What may prove that joints contradict each other (contradiction.hpp).
  Eigen::VectorXd beyond_joints() const;

  /// Impulses, and velocities with them.
  void set(const MixedImpulses& x);

  /// That of docs/reference/error_measures.md, but that a defect counts as none which is within some roundings of the
  /// load, 7e-15 of it. However large impulses are, what they leave undone counts.
  double residual() const;
  const MixedImpulses& impulses() const { return x_; }
  const Eigen::VectorXd& velocity() const { return v_; }

 private:
  Eigen::VectorXd velocities(const MixedImpulses& x) const;
  /// The largest velocity that a row sees of the load, its terms added up without their signs: of the velocities that
  /// come in, with what weights and other forces add to them, and of all that motors and springs can push with.
  double load() const;
  template <int Rows>
  SolvedRows<Rows> solved_rows(const SparseMatrix& columns, const SparseMatrix& responses, Eigen::Index first) const;

  const MixedProblem& p_;
  const bool articulated_;
  std::vector<std::uint32_t> blocks_;         // of joints
  SparseMatrix moves_r_, moves_l_, moves_z_;  // M^-1 H, M^-1 G, M^-1 D
  Eigen::VectorXd free_;                      // M^-1 f
  std::unique_ptr<JointSolver> joints_;       // null where there are none
  std::vector<SolvedRows<3>> contacts_;
  std::vector<SolvedRows<1>> rows_;
  std::vector<LocalCone> cones_;
  std::vector<double> mobility_;  // at which the defect of each contact is measured
  double load_ = 0;               // m/s
  double scale_ = 0;              // sum of squares of velocities without impulses
  MixedImpulses x_;
  Eigen::VectorXd v_;
};

}  // namespace lockstep::oracle
