// Frictional contact with Coulomb's cone, in the two forms in which the field writes it down (FCLIB: Acary, Bremond,
// Koziara, Perignon, RT-0444, INRIA 2014). Each contact has a frame: normal, first tangent, second tangent.
//   global   M v = f + H r + G l,   u = H^T v + w,   G^T v + b = 0
//   local    u = W r + V l + q,     V^T r + R l + s = 0
// with   W = H^T M^-1 H,  V = H^T M^-1 G,  R = G^T M^-1 G,  q = H^T M^-1 f + w,  s = G^T M^-1 f + b.
// In both, r lies in K = { |r_t| <= mu r_n }, u^ = u + mu |u_t| n (De Saxce) in its dual cone, and r . u^ = 0.
// Impulses r, l in N s; velocities u, v in m/s; M in kg; W in 1/kg.
#pragma once

#include <Eigen/Sparse>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace lockstep::oracle {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// A square sparse matrix of 3 x 3 blocks, row by row; columns rise within a row, and each row has its diagonal block.
struct BlockMatrix {
  std::vector<std::uint32_t> first = {0};  // of each row, and the end
  std::vector<std::uint32_t> column;
  std::vector<Eigen::Matrix3d> block;
  std::vector<std::uint32_t> diagonal;  // index of each row's diagonal block

  std::uint32_t rows() const { return static_cast<std::uint32_t>(diagonal.size()); }
  const Eigen::Matrix3d& on_diagonal(std::uint32_t i) const { return block[diagonal[i]]; }

  /// Row i of the product with x.
  Eigen::Vector3d row_times(std::uint32_t i, const Eigen::VectorXd& x) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::uint32_t k = first[i]; k < first[i + 1]; ++k) sum.noalias() += block[k] * x.segment<3>(3 * column[k]);
    return sum;
  }

  /// this * x
  Eigen::VectorXd times(const Eigen::VectorXd& x) const {
    Eigen::VectorXd y(x.size());
    for (std::uint32_t i = 0; i < rows(); ++i) y.segment<3>(3 * i) = row_times(i, x);
    return y;
  }

  /// (W_ii + W_ii^T) / 2: files of others are not always symmetric to the last digit. What is missing of W_ii is left
  /// to the next solve.
  Eigen::Matrix3d symmetric_diagonal(std::uint32_t i) const {
    return 0.5 * (on_diagonal(i) + on_diagonal(i).transpose());
  }

  /// (this - this^T) / 2, without what is nothing but rounding.
  SparseMatrix skew() const;

  /// As ordinary sparse and dense matrices.
  SparseMatrix sparse() const;
  Eigen::MatrixXd dense() const;
};

/// Blocks of a square matrix whose size is a multiple of three. Entries that are exactly zero do not count.
BlockMatrix block_matrix(const SparseMatrix& matrix);

/// What joints ask: V, R, s above. Blocks of rows, each of one unit, are measured together (error.hpp).
struct Bilateral {
  SparseMatrix v, r;                 // 3n x m, m x m
  Eigen::VectorXd s;                 // m
  std::vector<std::uint32_t> first;  // of each block of rows, and the end
};

/// Where W comes from, W = H^T M^-1 H: of use where contacts have more rows than there are velocities.
struct VelocityForm {
  SparseMatrix m, h;
};

/// The local form.
struct ConeProblem {
  BlockMatrix w;
  Eigen::VectorXd q;   // 3n: the velocities without impulses, m/s
  Eigen::VectorXd mu;  // n
  std::optional<Bilateral> joints;
  std::optional<VelocityForm> velocities = {};

  std::uint32_t contacts() const { return static_cast<std::uint32_t>(mu.size()); }
};

/// The global form, in two dimensions or in three: of a contact in the plane there is one tangent.
struct GlobalConeProblem {
  std::uint32_t dimension = 3;
  SparseMatrix m, h;
  Eigen::VectorXd f, w, mu;
  SparseMatrix g;  // no columns: no joints
  Eigen::VectorXd b;
  std::vector<std::uint32_t> first;        // of each block of columns of G, and the end; empty: each is one of its own
  std::vector<std::uint32_t> bodies = {};  // the first velocity of each body and the end of the last; empty: not known
};

/// Impulses of the contacts and of the joints of a problem.
struct ConeImpulses {
  Eigen::VectorXd r, l;
};

/// The blocks of columns of G: `first`, or each of its own.
std::vector<std::uint32_t> joint_blocks(const GlobalConeProblem& problem);

/// Assembles W, and V and R where there are joints, from a sparse Cholesky factorisation of M. Throws
/// std::runtime_error where M is not positive definite.
ConeProblem local_form(const GlobalConeProblem& problem);

/// A problem in the plane as one in space: a second tangent, as mobile as the first and coupled with nothing. In it
/// r = 0 is the only solution, so that the solutions are those of the plane. W, V and q have two rows a contact.
ConeProblem embed_plane(const SparseMatrix& w, const Eigen::VectorXd& q, const Eigen::VectorXd& mu,
                        std::optional<Bilateral> joints = {});

/// The joints taken out: W - V R^-1 V^T and q - V R^-1 s. R may be singular: of redundant impulses the smallest are
/// taken, each measured by the velocity that it gives its own row, and joints that contradict each other are kept as
/// well as can be.
class JointElimination {
 public:
  explicit JointElimination(const ConeProblem& problem);

  const ConeProblem& reduced() const { return reduced_; }
  /// The impulses l of the joints that go with r.
  Eigen::VectorXd joint_impulses(const Eigen::VectorXd& r) const;
  /// A y with R y = 0 and y . s not 0, where s is not in the range of R (joints/contradiction.hpp); elsewhere nothing
  /// but rounding.
  Eigen::VectorXd beyond_joints() const;

 private:
  ConeProblem reduced_;
  SparseMatrix v_, r_;
  Eigen::VectorXd s_;
  Eigen::MatrixXd inverse_;  // of R, or its pseudo-inverse
};

/// As a problem with its contacts in another order: contact i of the result is `order[i]` of the given one.
ConeProblem reordered(const ConeProblem& problem, std::span<const std::uint32_t> order);

}  // namespace lockstep::oracle
