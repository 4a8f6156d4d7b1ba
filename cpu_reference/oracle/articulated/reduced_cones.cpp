#include "cpu_reference/oracle/articulated/reduced_cones.hpp"

#include <cmath>

namespace lockstep::oracle::articulated {

namespace {

constexpr int changes_at_once = 20, most_changes = 200;
constexpr double immobile = 1e-9;  // of what a bound is mobile by without drives, where these hold it

// Rows of bounds stand alone in the problem, as the first of three in that of cones.
Index cone_row(const ReducedProblem& p, Index row) {
  return row < p.first_bound() ? row : p.first_bound() + 3 * (row - p.first_bound());
}

ConeProblem cones_of(const ReducedProblem& p, const SparseMatrix& w, const VectorXd& q) {
  const Index cones = p.contacts() + p.bounds(), rows = p.first_drive();
  std::vector<Eigen::Triplet<double>> triplets;
  for (int k = 0; k < rows; ++k) {
    for (SparseMatrix::InnerIterator entry(w, k); entry; ++entry) {
      if (entry.row() < rows) triplets.emplace_back(int(cone_row(p, entry.row())), int(cone_row(p, k)), entry.value());
    }
  }
  for (Index i = p.first_bound(); i < rows; ++i) {
    const double own = w.coeff(i, i), mobile = own > 0 ? own : 1;
    for (Index t = 1; t < 3; ++t) triplets.emplace_back(int(cone_row(p, i) + t), int(cone_row(p, i) + t), mobile);
  }
  SparseMatrix spread(3 * cones, 3 * cones);
  spread.setFromTriplets(triplets.begin(), triplets.end());
  ConeProblem problem;
  problem.w = block_matrix(spread);
  problem.q = VectorXd::Zero(3 * cones);
  for (Index i = 0; i < rows; ++i) problem.q[cone_row(p, i)] = q[i];
  problem.mu = VectorXd::Zero(cones);
  problem.mu.head(p.contacts()) = p.friction;
  return problem;
}

// Drives: 0 holds, 1 and -1 push with all they have.
using States = std::vector<int>;

struct ActiveDrives {
  std::vector<Index> rows;  // of drives that hold
  MatrixXd coupling;        // of all rows with them
  BilateralRows own;
  VectorXd pushed;  // impulses of the others
};

ActiveDrives active_drives(const ReducedProblem& p, const States& states) {
  ActiveDrives active;
  active.pushed = VectorXd::Zero(p.size());
  for (Index d = 0; d < p.drives(); ++d) {
    if (states[std::size_t(d)] == 0) active.rows.push_back(p.first_drive() + d);
    active.pushed[p.first_drive() + d] = states[std::size_t(d)] * p.max_impulse[d];
  }
  active.coupling.resize(p.size(), Index(active.rows.size()));
  for (std::size_t k = 0; k < active.rows.size(); ++k) active.coupling.col(Index(k)) = p.w.col(active.rows[k]);
  VectorXd unheld(Index(active.rows.size()));
  for (std::size_t k = 0; k < active.rows.size(); ++k) unheld[Index(k)] = p.unheld[active.rows[k] - p.first_drive()];
  active.own = BilateralRows(active.coupling(active.rows, Eigen::all), unheld);
  return active;
}

// The velocity of a drive that is none, in its own row.
double rounding_of(const ReducedProblem& p, Index drive) {
  const Index row = p.first_drive() + drive;
  return 1e-12 * (std::abs(p.q[row]) + p.max_impulse[drive] * p.w.coeff(row, row));
}

// Whether drives that hold leave a bound on its wrong side, at a velocity `q` that no impulse changes: as a motor does
// that presses on a limit. Of these the one that is coupled most with the bound pushes against it instead.
bool yield_to_bound(const ReducedProblem& p, const SparseMatrix& w, const VectorXd& q, const ActiveDrives& active,
                    States& states) {
  if (active.rows.empty()) return false;
  for (Index i = p.first_bound(); i < p.first_drive(); ++i) {
    if (w.coeff(i, i) > immobile * p.w.coeff(i, i)) continue;
    Index most = 0;
    active.coupling.row(i).cwiseAbs().maxCoeff(&most);
    const Index drive = active.rows[std::size_t(most)] - p.first_drive();
    if (!(q[i] < -rounding_of(p, drive))) continue;
    states[std::size_t(drive)] = active.coupling(i, most) > 0 ? -1 : 1;
    return true;
  }
  return false;
}

// Whether a drive is to change over, and to what. One that holds and yet moves is held elsewhere by another.
bool next_state(double impulse, double velocity, double max_impulse, double rounding, int& state) {
  const int before = state;
  if (state == 0 && std::abs(impulse) > max_impulse * (1 + 1e-12))
    state = impulse > 0 ? 1 : -1;
  else if (state == 0 && std::abs(velocity) > rounding)
    state = velocity > 0 ? -1 : 1;
  else if (state != 0 && state * velocity > rounding)
    state = 0;
  return state != before;
}

}  // namespace

ConeProblem cone_problem(const ReducedProblem& p, const VectorXd& r) {
  return cones_of(p, p.w, p.q + p.w.rightCols(p.drives()) * r.tail(p.drives()));
}

VectorXd cone_impulses(const ReducedProblem& p, const VectorXd& r) {
  VectorXd of_cones = VectorXd::Zero(3 * (p.contacts() + p.bounds()));
  for (Index i = 0; i < p.first_drive(); ++i) of_cones[cone_row(p, i)] = r[i];
  return of_cones;
}

SolveReport solve_reduced_cones(const ConeSolver& solver, const ReducedProblem& p, const SolveLimits& limits,
                                VectorXd& r) {
  const Index cones = p.contacts() + p.bounds(), rows = p.first_drive();
  SolveReport sum;
  sum.stop = Stop::solved;
  VectorXd of_cones = r.size() == p.size() ? cone_impulses(p, r) : VectorXd(VectorXd::Zero(3 * cones));
  States states(std::size_t(p.drives()), 0);
  for (int change = 0; change < most_changes; ++change) {
    const ActiveDrives active = active_drives(p, states);
    VectorXd q = p.q + p.w * active.pushed;
    SparseMatrix w = p.w;
    if (!active.rows.empty()) {
      q += active.coupling * active.own.response(VectorXd(q(active.rows)));
      w += SparseMatrix(
          MatrixXd(active.coupling * active.own.response(MatrixXd(active.coupling.transpose()))).sparseView());
    }
    if (yield_to_bound(p, w, q, active, states)) continue;
    if (cones > 0) {
      const SolveReport inner = solver.solve(cones_of(p, w, q), limits, of_cones);
      sum.iterations += inner.iterations;
      sum.seconds += inner.seconds;
      sum.residual = inner.residual;
      sum.stop = inner.stop;
    }
    r = active.pushed;
    for (Index i = 0; i < rows; ++i) r[i] = of_cones[cone_row(p, i)];
    const VectorXd unheld = p.w * r + p.q;
    if (!active.rows.empty()) r(active.rows) = active.own.response(VectorXd(unheld(active.rows)));

    const VectorXd u = p.w * r + p.q;
    bool changed = false;
    for (Index d = 0; d < p.drives() && !(changed && change > changes_at_once); ++d) {
      const Index row = rows + d;
      changed |= next_state(r[row], u[row], p.max_impulse[d], rounding_of(p, d), states[std::size_t(d)]);
    }
    if (!changed) return sum;
  }
  sum.stop = Stop::stalled;
  sum.residual = 1;
  return sum;
}

}  // namespace lockstep::oracle::articulated
