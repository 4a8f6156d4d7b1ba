// One sub-step of articulated bodies in reduced coordinates. With q the coordinates, r their rates, h the sub-step and
// the integrator's theta as in the stages (0 explicit, 1 semi-implicit, 1/2 trapezoidal):
//   r' = r + h a + M^-1 J^T p,    q' = q + h ((1 - theta) r + theta r')
// where a are the accelerations by the articulated-body algorithm. They are taken at q + 2 theta (1 - theta) h r_mean
// (the start, or the middle of a trapezoidal step) and, as far as they depend on rates, at the mean (r + r + h a) / 2,
// by fixed point: of second order and symmetric in time at theta 1/2, where what swings keeps its energy. p are
// impulses of contacts, bounds and drives, found by somebody else (reduced_problem.hpp).
//
// Joints of trees hold by themselves. Rows G of joints that close loops, of rods and locked coordinates, and springs
// are solved with the accelerations: G r' = 0, of a trapezoidal step G (r + r') = 0; a spring of rate and yield as in
// cpu_reference/prepare_joints.hpp. Then loops are closed in the coordinates, by Newton's method along M^-1 G^T, and
// the rates are brought back to G r' = 0 where the bodies are by then (post-stabilisation; Cline and Pai 2003). At
// theta 1 what closing moved is a velocity too: that is the step of RATTLE (Andersen 1983).
#pragma once

#include <memory>

#include "cpu_reference/oracle/articulated/rows.hpp"

namespace lockstep::oracle::articulated {

/// Of a joint that closes a loop the locked rows; or its acting coordinate, which is to be `at`; or both.
struct Closure {
  std::size_t joint = 0;
  bool locked = true, fixed = false;
  double at = 0;
};

/// u + rate (x - rest) + yield r = 0 of the acting coordinate x and its rate u.
struct Spring {
  std::size_t joint = 0;
  double rate = 0, rest = 0, yield = 0;
};

/// low <= x <= high of the acting coordinate.
struct Limit {
  std::size_t joint = 0;
  double low = 0, high = 0;
};

struct Laws {
  std::vector<Closure> closures;
  std::vector<Spring> springs;
  std::vector<Limit> limits;
};

struct StepStart {
  std::vector<Pose> poses;
  std::vector<Vector6> twists;    // of all bodies; of those that are no links what they have without impulses
  std::vector<Vector6> wrenches;  // on links: weights and loads, N and N m
  std::vector<LoneBody> lone;     // of bodies that are no links
  double dt = 0, theta = 1;
  bool gyroscopic = true;  // whether w x I w acts
};

class Step {
 public:
  /// Moves the rates without impulses from outside. Tree and laws are kept by reference.
  Step(const Tree& tree, const Laws& laws, StepStart start);
  Step(const Step&) = delete;

  const Tree& tree() const { return tree_; }
  const StepStart& given() const { return start_; }

  /// Where rows are to be taken, and the twists there, of all bodies, with the rates as they now are.
  const Configuration& at() const { return *at_; }
  const Kinematics& kinematics() const { return *kinematics_; }
  const std::vector<Vector6>& twists() const { return twists_; }
  /// At the start: what limits are held against.
  const Configuration& from() const { return from_; }

  Mobility mobility() const { return {*inertia_, start_.lone}; }
  /// The rows of closures and springs, and their own answer.
  const std::vector<Row>& bilateral_rows() const { return bilateral_rows_; }
  const BilateralRows& bilateral() const { return bilateral_; }

  /// Impulses of rows and of the bilateral rows that answer them. Bodies that are no links get theirs too.
  void push(const std::vector<Row>& rows, const VectorXd& impulses, const VectorXd& bilateral_impulses);

  /// Of closures and springs, as they stand in the rows, N s and N m s.
  const VectorXd& bilateral_impulses() const { return bilateral_impulses_; }
  /// What the joint to the parent has done to each link, about its centre of mass.
  LinkVectors carried() const;

  struct End {
    std::vector<Pose> poses;  // of links; others as given
    std::vector<Vector6> twists;
    double open = 0;  // largest error of a closure that is left, m or rad
  };
  /// `poses`: of all bodies; those that do not move by themselves are where the step ends.
  End finish(const std::vector<Pose>& poses);

 private:
  void accelerate(const VectorXd& change);

  const Tree& tree_;
  const Laws& laws_;
  StepStart start_;
  Configuration from_;
  VectorXd old_rates_, rates_;
  std::unique_ptr<Configuration> at_;
  std::unique_ptr<Kinematics> kinematics_;
  std::unique_ptr<ArticulatedInertia> inertia_;
  std::vector<Vector6> impulses_, twists_;  // of each body in the step, but for bilateral rows in the first
  LinkVectors products_;                    // times dt
  std::vector<Row> bilateral_rows_;
  BilateralRows bilateral_;
  VectorXd bilateral_impulses_;
};

/// Twists of all bodies at these rates; those of no links are kept.
std::vector<Vector6> twists_at(const Kinematics& at, const VectorXd& rates, std::vector<Vector6> twists);

/// Rates brought to where the rows' velocities are zero, with least change of energy.
VectorXd held_rates(const Kinematics& at, const std::vector<Row>& rows, const VectorXd& rates,
                    const std::vector<Vector6>& twists);

}  // namespace lockstep::oracle::articulated
