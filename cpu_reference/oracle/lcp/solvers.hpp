// All solvers of linear complementarity problems, one file each. docs/theory/lcp.md says which one when.
#pragma once

#include <span>
#include <string_view>

#include "cpu_reference/oracle/lcp/lcp.hpp"

namespace lockstep::oracle::lcp {

// Direct methods. `infeasible` only where they show that there is no solution; `stalled` where the matrix is out of
// their reach.

/// All index sets, one after another: any matrix, up to 20 unknowns (`limit` beyond). `infeasible`: none has a
/// solution.
SolveReport enumeration(const Lcp& problem, const SolveLimits& limits, VectorXd& z);

/// Lemke's complementary pivoting: copositive-plus matrices, which friction pyramids make; P and positive semidefinite
/// ones among them. `infeasible` by the ray in which a path ended.
SolveReport lemke(const Lcp& problem, const SolveLimits& limits, VectorXd& z);

/// Keller's principal pivoting: symmetric positive semidefinite matrices. `infeasible` by the ray that nothing blocks.
SolveReport keller(const Lcp& problem, const SolveLimits& limits, VectorXd& z);

/// Baraff's incremental pivoting: P matrices, and symmetric positive semidefinite ones. `infeasible` by the ray that
/// nothing blocks.
SolveReport baraff(const Lcp& problem, const SolveLimits& limits, VectorXd& z);

/// Murty's least-index principal pivoting: P matrices. A check on the others: it may take 2^n pivots.
SolveReport murty(const Lcp& problem, const SolveLimits& limits, VectorXd& z);

// Iterations. `stalled` where the method cannot act on the matrix.

SolveReport projected_jacobi(const Lcp& problem, const SolveLimits& limits, VectorXd& z);
SolveReport damped_jacobi(const Lcp& problem, const SolveLimits& limits, VectorXd& z);
SolveReport pgs(const Lcp& problem, const SolveLimits& limits, VectorXd& z);
SolveReport psor(const Lcp& problem, const SolveLimits& limits, VectorXd& z);
SolveReport pgs_sm(const Lcp& problem, const SolveLimits& limits, VectorXd& z);
SolveReport nncg(const Lcp& problem, const SolveLimits& limits, VectorXd& z);
SolveReport fischer_newton(const Lcp& problem, const SolveLimits& limits, VectorXd& z);

// The same in a box. Baraff's method freezes the bounds of friction, solves, and freezes them anew; Newton's takes rows
// that are free or bounded below by 0.

SolveReport baraff(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z);
SolveReport projected_jacobi(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z);
SolveReport damped_jacobi(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z);
SolveReport pgs(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z);
SolveReport psor(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z);
SolveReport pgs_sm(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z);
SolveReport nncg(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z);
SolveReport fischer_newton(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z);

struct NamedSolver {
  std::string_view name;
  Solver solve;
  bool direct;
};
struct NamedBoxedSolver {
  std::string_view name;
  BoxedSolver solve;
  bool direct;
};

std::span<const NamedSolver> solvers();
std::span<const NamedBoxedSolver> boxed_solvers();

}  // namespace lockstep::oracle::lcp
