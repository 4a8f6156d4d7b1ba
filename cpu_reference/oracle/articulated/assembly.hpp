// Featherstone's divide-and-conquer algorithm (A divide-and-conquer articulated-body algorithm for parallel O(log n)
// calculation of rigid-body dynamics, 1999). An assembly of links is known by its handles, the links that something
// outside of it may push:
//   A = Phi F + b
// with the twists A of the handles, the wrenches F on them, the articulated inverse inertia Phi and what the handles do
// unpushed, b. A single link has Phi = M^-1. Two assemblies are joined at a joint with locked rows G, G A = g: with
// K = Phi G^T and W = G Phi G^T,
//   Phi := Phi - K W^-1 K^T,   b := b - K W^-1 (G b - g)
// and handles that nothing needs any more are dropped. Trees are cut in halves as equal as their joints allow, so that
// a chain of n links is joined in about log2 n rounds of pairs.
#pragma once

#include "cpu_reference/oracle/articulated/reduced_problem.hpp"

namespace lockstep::oracle::articulated {

struct Assembly {
  std::vector<std::size_t> handles;  // bodies
  MatrixXd inverse_inertia;          // Phi, 6 rows and columns a handle
  VectorXd free;                     // b
  int rounds = 0;                    // of joins that wait for each other

  /// The handle of a body; there has to be one.
  Index first_row(std::size_t body) const;
};

/// The assembly of tree `number` with these links as handles. `wrench` and `product` as ArticulatedInertia::solve takes
/// them (product empty: zero).
Assembly assembled(const Kinematics& at, std::size_t number, const LinkVectors& wrench, const LinkVectors& product,
                   const std::vector<std::size_t>& handles);

/// All trees, and bodies that are no links, side by side: the bodies of `handles` that move, each once, in order.
/// `free` are the twists of the step as it is.
Assembly assembled(const Step& step, std::vector<std::size_t> handles);

/// Rows over the handles of an assembly, a column for each of their numbers. Bodies that do not move have none.
MatrixXd rows_on(const Assembly& assembly, const std::vector<Row>& rows);

/// reduced_problem() by divide and conquer: handles are the bodies that rows push, and `more`. The step's bilateral
/// rows are taken out of the assembly too.
struct AssembledProblem {
  ReducedProblem problem;
  Assembly assembly;
  MatrixXd rows;       // of the problem, on the handles
  MatrixXd responses;  // twists of the handles for unit impulses
};
AssembledProblem assembled_problem(const Step& step, const Demand& demand, const std::vector<std::size_t>& more = {});

}  // namespace lockstep::oracle::articulated
