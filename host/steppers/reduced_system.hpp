// The bodies and joints of a scene, at a step, as articulated bodies in reduced coordinates.
#pragma once

#include "cpu_reference/oracle/articulated/reduced_problem.hpp"
#include "host/report/contact_system.hpp"

namespace lockstep {

/// Bodies keep their indices, the null body is one that does not move, joints keep theirs. A dynamic body that a joint
/// holds is a link. Throws Error (input), naming it, for a joint that is soft on purpose.
oracle::articulated::System articulated_system(const Buffers<double>& buffers);

/// Joints that close loops, rods and locked coordinates are closures; springs and limits of acting coordinates.
oracle::articulated::Laws laws_of(const Buffers<double>& buffers, const oracle::articulated::Tree& tree);

/// After the stage integrate_velocities: links with the velocities of the sub-step's start, weights and loads; other
/// bodies with those that they have now.
oracle::articulated::StepStart step_start(const Buffers<double>& buffers, const StepParams<double>& params,
                                          const oracle::articulated::Tree& tree);

/// Contacts of the system, limits as bounds of rates (as in cpu_reference/prepare_joints.hpp, one that is reached keeps
/// its rate at 0), motors and dry friction as drives.
oracle::articulated::Demand demand_of(const ContactSystem& system, const Buffers<double>& buffers,
                                      const oracle::articulated::Laws& laws, const oracle::articulated::Step& step);

/// What a sub-step has pushed with in each joint, as the buffers have it: rows on b along the joint's axes, and the row
/// of the acting coordinate. `impulses`: of the rows of the problem.
struct JointPush {
  double locked[JOINT_ROWS] = {}, free = 0, impedance = 0;
};
std::vector<JointPush> joint_pushes(const oracle::articulated::Step& step, const oracle::articulated::Laws& laws,
                                    const oracle::articulated::Demand& demand,
                                    const oracle::articulated::ReducedProblem& problem,
                                    const Eigen::VectorXd& impulses);

}  // namespace lockstep
