// One sub-step of articulated bodies in reduced coordinates. With q the coordinates, r their rates, J of V = J r and h
// the sub-step, all of it where the step is half done, P the projection V -> r by the articulated-body algorithm (of
// all rates those whose twists are nearest to V, weighed by the inertia) and the integrator's theta as in the stages:
//   r_0 = P V,   dr = P M^-1 (h F + J_c^T p),   q' = q + h (r_0 + theta dr),   V' = 2 J r_0 - V + J dr
// That is: the mean twist obeys the joints where the step is half done, so that what they carry does no work, and the
// energy changes by the work of F and p alone. At the end twists are projected once more, on what the joints allow
// there, which takes energy of sixth order in h and never gives any. Second order at theta 1/2; at theta 1 a kick and
// a drift. V holds v in the world's axes and w in those of the body, which turn with it, F the moment -w x I w of the
// mean w: as in cpu_reference/gyroscopic.hpp at the midpoint. Half way depends on the end, by fixed point. p are
// impulses of contacts, bounds and drives, found by somebody else (reduced_problem.hpp) where the step is half done
// without them.
//
// Joints of trees hold by themselves. Rows G of joints that close loops, of rods and of locked coordinates are held by
// r_0 and dr each, G r = 0; a spring is solved with dr, its rate and compliance as in cpu_reference/prepare_joints.hpp.
// At the end loops are closed in the coordinates, by Newton's method along M^-1 G^T, and the twists projected on G r =
// 0 where the bodies are by then (post-stabilisation; Cline and Pai 2003).
//
// Weights work along straight lines, h J_m r, and bodies of a long step go along arcs. Where that gives a tree that
// hangs from what stands more than a thousandth of its energy of motion in a step, its rates are scaled to give it
// back; such a step turns a joint by a quarter of a radian and more.
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

/// u + rate (x - rest) + compliance r = 0 of the acting coordinate x at the start and its rate u, at theta 1/2 the mean
/// one; a damper then takes the velocity that cpu_reference/prepare_joints.hpp gives it.
struct Spring {
  std::size_t joint = 0;
  double rate = 0, rest = 0, compliance = 0;
};

/// Inertia along the acting coordinate: an impulse -inertia times what its rate changes by from start to end.
struct Armature {
  std::size_t joint = 0;
  double inertia = 0;
};

/// low <= x <= high of the acting coordinate.
struct Limit {
  std::size_t joint = 0;
  double low = 0, high = 0;
};

struct Laws {
  std::vector<Closure> closures;
  std::vector<Spring> springs;
  std::vector<Armature> armatures;
  std::vector<Limit> limits;
};

struct StepStart {
  std::vector<Pose> poses;
  std::vector<Vector6> twists;    // of all bodies; of those that are no links what they have without impulses
  std::vector<Vector6> wrenches;  // on links: weights and loads, N and N m
  std::vector<LoneBody> lone;     // of bodies that are no links
  double dt = 0, theta = 1;
  bool gyroscopic = true;           // whether w x I w acts
  std::vector<double> angles = {};  // acting coordinates of joints that count revolutions, to half a one; none: all 0
};

class Step {
 public:
  /// Half the step, without impulses from outside. Tree and laws are kept by reference.
  Step(const Tree& tree, const Laws& laws, StepStart start);
  Step(const Step&) = delete;

  const Tree& tree() const { return tree_; }
  const StepStart& given() const { return start_; }

  /// Where the step is half done: where rows are to be taken; and V', of all bodies, as it now is.
  const Configuration& at() const { return *at_; }
  const Kinematics& kinematics() const { return *kinematics_; }
  const std::vector<Vector6>& twists() const { return twists_; }
  /// At the start: what limits are held against.
  const Configuration& from() const { return from_; }
  double coordinate_from(std::size_t joint) const;

  Mobility mobility() const { return {*inertia_, start_.lone}; }
  /// The rows of closures, springs and armatures, and their own answer.
  const std::vector<Row>& bilateral_rows() const { return bilateral_rows_; }
  const BilateralRows& bilateral() const { return bilateral_; }

  /// Impulses of rows and of the bilateral rows that answer them. Bodies that are no links get theirs too.
  void push(const std::vector<Row>& rows, const VectorXd& impulses, const VectorXd& bilateral_impulses);

  /// Of closures, springs and armatures, as they stand in the rows, N s and N m s.
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
  /// Everything but the end, where the mean rates are `mean_rates` and those of the gyroscopic moment `half`.
  void go(const VectorXd& mean_rates, const VectorXd& half);
  VectorXd mean() const { return rates_ + start_.theta * change_; }
  /// V' where the step ends, on what the joints of trees allow there.
  std::vector<Vector6> twists_at_end(const Configuration& to) const;
  /// The energy of motion of the armatures of a tree, by twists of its bodies, J.
  double armature_energy(std::size_t number, const Configuration& to, const std::vector<Vector6>& twists) const;
  /// The acting coordinates of all joints at the end, without what closes loops.
  std::vector<double> expected_end() const;
  /// What F did not do on the way that the links of a tree went, and did to their twists, J.
  double given_by_bends(std::size_t number, const Configuration& to) const;

  const Tree& tree_;
  const Laws& laws_;
  StepStart start_;
  std::vector<double> angles_;  // acting coordinates at the start, to half a revolution
  Configuration from_;
  VectorXd rates_, change_;  // r_0 and dr
  std::unique_ptr<Configuration> at_;
  std::unique_ptr<Kinematics> kinematics_;
  std::unique_ptr<ArticulatedInertia> inertia_;
  std::vector<Vector6> impulses_;             // on each body: h F and what rows push with, twice those that hold r_0
  std::vector<Vector6> old_twists_, twists_;  // V and V', of all bodies
  std::vector<Row> bilateral_rows_;
  BilateralRows bilateral_;
  VectorXd bilateral_impulses_;
};

/// Twists of all bodies at these rates; those of no links are kept.
std::vector<Vector6> twists_at(const Kinematics& at, const VectorXd& rates, std::vector<Vector6> twists);

/// Rates brought to where the rows' velocities are zero, with the least change of twists, weighed by the inertia.
VectorXd constrained_rates(const Kinematics& at, const std::vector<Row>& rows, const VectorXd& rates,
                           const std::vector<Vector6>& twists);

}  // namespace lockstep::oracle::articulated
