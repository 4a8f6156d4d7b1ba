// Contacts and joints as sub-blocks of one problem, each solved by what suits it (survey 4.2.2 and 4.3, "hierarchical
// solvers"). In a sweep
//   each contact in turn gets the impulse that solves its own problem, exactly, as in cone/nsgs.cpp,
//   each bounded row in turn the impulse that its law asks for,
//   and all joints together the impulses l that keep them: R dl = -(G^T v + b), by a method of joint_solver.hpp.
// Velocities v are carried along, so that neither W nor W - V R^-1 V^T is ever formed: a sweep costs what contacts and
// joints there are, however long the chains are that they hold together.
#pragma once

#include <memory>

#include "cpu_reference/oracle/cone_problem.hpp"
#include "cpu_reference/oracle/solve.hpp"

namespace lockstep::oracle {

/// What the impulse of one row has to do with its velocity u: it drives u towards `speed` as far as `max_impulse`
/// allows (a motor; dry friction, speed 0), and keeps it between `slowest` and `fastest` (limits). Of a spring both are
/// the velocity at which it would not push.
struct BoundedLaw {
  double speed = 0, max_impulse = 0;  // m/s; N s
  double slowest = 0, fastest = 0;    // m/s
  double bound_compliance = 0;        // by how much a bound gives way, 1/kg; 0: it is hard
  double spring_compliance = 0;       // of a spring, 1/kg; 0: there is none
  double mobility = 0;                // at which its defect is measured, 1/kg; > 0

  /// The velocity that the row gets where it would have q without its own impulse, each unit of which adds e to it.
  double velocity(double q, double e) const;
};

/// The global form (in space) with bounded rows beside contacts and joints: M v = f + H r + G l + D z, u = D^T v.
struct MixedProblem {
  GlobalConeProblem cones;
  SparseMatrix d;  // no columns: there are none
  std::vector<BoundedLaw> laws;
};

struct MixedImpulses {
  Eigen::VectorXd r, l, z;  // of contacts, joints and bounded rows, N s
};

struct MixedSolver {
  std::string_view name, description;
  std::string_view joints;  // of joint_methods()
  bool articulated;         // whether a contact feels all that hangs on its bodies
};

/// Of `mixed_articulated` each contact and bounded row is solved as mobile as joints let it be, and what it does moves
/// all bodies of its mechanism at once. Sweeps are those of `nsgs` on W - V R^-1 V^T then, which is not formed; each
/// row has to remember what it does to every body that hangs on it.
std::span<const MixedSolver> mixed_solvers();

/// Null where there is none of this name.
const MixedSolver* find_mixed_solver(std::string_view name);

class MixedState;

/// Sweeps over one problem, that can be taken up again once its f, b, w or laws have changed.
class MixedSweeps {
 public:
  /// The problem must outlive it. Starts from the impulses given (those that are empty: zero). Throws
  /// std::runtime_error where M is not positive definite or the problem is in the plane.
  MixedSweeps(const MixedProblem& problem, const MixedSolver& solver, MixedImpulses start);
  ~MixedSweeps();

  /// Goes on to the residual of docs/reference/error_measures.md, and stands at the best that it saw. Velocities are
  /// measured against those that the problem had at the start.
  SolveReport run(const SolveLimits& limits);

  const MixedImpulses& impulses() const;
  Eigen::VectorXd joint_rates() const;  // G^T v
  Eigen::VectorXd row_rates() const;    // D^T v

 private:
  const MixedProblem& problem_;
  const MixedSolver& solver_;
  std::unique_ptr<MixedState> state_;
};

/// From the impulses given to the best that sweeps find. Throws what MixedSweeps does.
SolveReport solve_mixed(const MixedProblem& problem, const MixedSolver& solver, const SolveLimits& limits,
                        MixedImpulses& impulses);

}  // namespace lockstep::oracle
