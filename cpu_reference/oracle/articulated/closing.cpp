#include "cpu_reference/oracle/articulated/closing.hpp"

#include <algorithm>
#include <cmath>

namespace lockstep::oracle::articulated {

namespace {

constexpr double closed = 1e-13;  // m, rad
constexpr int most_iterations = 20;
constexpr double farthest = 1;  // rad, that closing takes an angle from where it is expected

// Where closing takes an acting coordinate that is to be `wanted`.
double closing_target(const Joint& joint, double wanted, double expected) {
  return counts_revolutions(joint.type) ? std::clamp(wanted, expected - farthest, expected + farthest) : wanted;
}

}  // namespace

double ErrorRows::largest() const {
  double most = 0;
  for (const double e : errors) most = std::max(most, std::abs(e));
  return most;
}

ErrorRows closure_rows(const std::vector<Closure>& closures, const Tree& tree, const std::vector<double>& expected,
                       const Configuration& at) {
  ErrorRows all;
  for (const Closure& closure : closures) {
    const Joint& joint = tree.system().joints[closure.joint];
    const JointGeometry s = joint_geometry(joint, at);
    if (closure.locked) {
      const std::vector<Row> rows = rows_of(joint, at);
      all.rows.insert(all.rows.end(), rows.begin(), rows.end());
      const LockedRows locked = locked_rows(joint, s);
      for (int k = 0; k < 6; ++k) {
        if ((locked.mask >> k & 1) != 0) all.errors.push_back(locked.error[k]);
      }
    }
    if (closure.fixed) {
      all.rows.push_back(acting_row(joint, at));
      const double angle = expected[closure.joint];
      all.errors.push_back(acting_coordinate(joint, s, angle) - closing_target(joint, closure.at, angle));
    }
  }
  return all;
}

ErrorRows with_limits(ErrorRows all, const std::vector<Limit>& limits, const Tree& tree,
                      const std::vector<double>& expected, const Configuration& at) {
  for (const Limit& limit : limits) {
    const Joint& joint = tree.system().joints[limit.joint];
    const double angle = expected[limit.joint], x = acting_coordinate(joint, joint_geometry(joint, at), angle);
    const double inside = std::clamp(x, limit.low, limit.high);
    if (x == inside) continue;
    all.rows.push_back(acting_row(joint, at));
    all.errors.push_back(x - closing_target(joint, inside, angle));
  }
  return all;
}

double close_loops(const Tree& tree, const std::vector<Closure>& closures, const std::vector<Limit>* limits,
                   const std::vector<double>& expected, Configuration& configuration) {
  if (closures.empty() && (limits == nullptr || limits->empty())) return 0;
  const std::vector<Vector6> still(configuration.poses.size(), Vector6::Zero());
  const VectorXd none = VectorXd::Zero(tree.freedoms());
  for (int iteration = 0;; ++iteration) {
    ErrorRows off = closure_rows(closures, tree, expected, configuration);
    if (limits != nullptr) off = with_limits(std::move(off), *limits, tree, expected, configuration);
    const double open = off.largest();
    if (open <= closed || iteration == most_iterations) return open;
    const Kinematics at(tree, configuration, still, none);
    const ArticulatedInertia inertia(at);
    const std::vector<LoneBody> lone(configuration.poses.size());
    const Mobility mobility(inertia, lone);
    const SparseMatrix j = jacobian(off.rows, configuration.poses.size());
    const BilateralRows rows(j * mobility.responses(off.rows), mobility.unheld(off.rows));
    const VectorXd impulses = rows.response(Eigen::Map<const VectorXd>(off.errors.data(), Index(off.errors.size())));
    std::vector<Vector6> wrenches = still, twists = still;
    add_impulses(off.rows, impulses, wrenches);
    VectorXd displacement = none;
    mobility.push(wrenches, twists, displacement);
    configuration = moved(tree, configuration, displacement, still, 1);
  }
}

}  // namespace lockstep::oracle::articulated
