// What contacts, bounds and drives ask of a step, once trees and bilateral rows hold by themselves: impulses r with
//   u = W r + q,   W = J M^-1 J^T in reduced coordinates
//   contacts   r in Coulomb's cone or a pyramid, u_n >= 0 in q's terms (the bias is in q)
//   bounds     0 <= r  _|_  u >= 0, of an acting coordinate's rate against its slowest or its fastest
//   drives     |r| <= max_impulse, r against u: motors and dry friction of an acting coordinate
#pragma once

#include "cpu_reference/oracle/articulated/step.hpp"
#include "cpu_reference/oracle/models/multibody.hpp"

namespace lockstep::oracle::articulated {

/// Of the rate of a joint's acting coordinate, m/s or rad/s; infinite: none.
struct RateBound {
  std::size_t joint = 0;
  double slowest = 0, fastest = 0;
};

struct Drive {
  std::size_t joint = 0;
  double speed = 0;        // wanted, m/s or rad/s; 0 of dry friction
  double max_impulse = 0;  // largest impulse, N s or N m s
};

struct Demand {
  std::vector<models::Contact> contacts;
  std::vector<RateBound> bounds;
  std::vector<Drive> drives;
};

/// Rows: of each contact its normal and tangents (models::tangents), body a against b; of each bound that is finite
/// one, its rate less the slowest or the fastest less its rate; of each drive one, its rate less its speed.
struct ReducedProblem {
  std::vector<Row> rows;
  VectorXd friction;                  // mu of each contact
  std::vector<std::size_t> bound_of;  // Demand::bounds, of each row of a bound
  VectorXd max_impulse;               // of each drive
  VectorXd unheld;                    // mobility of each drive without joints
  SparseMatrix w;
  VectorXd q;
  MatrixXd coupling;  // velocities of the step's bilateral rows for unit impulses

  Index contacts() const { return friction.size(); }
  Index bounds() const { return Index(bound_of.size()); }
  Index drives() const { return max_impulse.size(); }
  Index first_bound() const { return 3 * contacts(); }
  Index first_drive() const { return first_bound() + bounds(); }
  Index size() const { return q.size(); }
};

ReducedProblem reduced_problem(const Step& step, const Demand& demand);

/// Rows and constants alone, without what the rows answer to each other: w and coupling are empty, q as the step is
/// without impulses.
ReducedProblem reduced_rows(const Step& step, const Demand& demand);

/// Gives the step impulses of the problem's rows, and of its bilateral rows what answers them.
void push(Step& step, const ReducedProblem& problem, const VectorXd& impulses);

}  // namespace lockstep::oracle::articulated
