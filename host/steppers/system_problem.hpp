// The constraint system of a step as a frictional contact problem in its global form.
#pragma once

#include "cpu_reference/oracle/joints/mixed.hpp"
#include "host/report/contact_system.hpp"

namespace lockstep {

struct SystemProblem {
  oracle::GlobalConeProblem problem;
  oracle::ConeImpulses impulses;  // what the solver of the step found
};

/// Velocities are those of bodies that can move: of the centre of mass in the world frame, and about the principal axes
/// that they can turn about; velocities that nothing changes go into w and b. Of a joint the linear and the angular
/// locked rows are a block each, angular velocities times the radius of gyration, so that all of them are in m/s; a
/// soft row moves against a velocity of its own, whose mass is its compliance. Throws Error (input), naming it, for a
/// joint with a motor, friction, limits or a spring, which FCLIB has no row for. Contacts that form friction patches
/// become cones with the impulses that were spread over them.
SystemProblem problem_of(const ContactSystem& system, const std::string& where);

/// The same with all that a joint can have: motors, friction and limits become bounded rows; springs, and limits that
/// are equal, locked ones, unless a motor or friction acts beside them; impedances locked ones that give way.
struct WholeSystemProblem {
  oracle::MixedProblem problem;
  oracle::MixedImpulses impulses;

  static constexpr u32 IMPEDANCE_ROW = JOINT_ROWS + 1;

  /// Where a column of G or D comes from, and the velocity in m/s that stands for a unit of the row's.
  struct Row {
    u32 joint = 0;  // into ContactSystem::joints
    u32 row = 0;    // JOINT_ROWS: the free one; IMPEDANCE_ROW
    double size = 0;
  };
  std::vector<Row> locked, bounded;  // of G, of D
};
WholeSystemProblem whole_problem_of(const ContactSystem& system);

/// Impulses of a problem_of() this system as the system has them: of its contacts in the world frame, N s, and of the
/// rows of its joints, N s and N m s.
struct SystemImpulses {
  std::vector<Eigen::Vector3d> contacts;
  std::vector<Rows> joints;
  std::vector<double> free = {};        // of their free rows; empty: as they were
  std::vector<double> impedances = {};  // beside these; empty: as they were
};
SystemImpulses impulses_of(const ContactSystem& system, const oracle::ConeImpulses& impulses);
/// Of a whole_problem_of() this system, with those of free rows.
SystemImpulses impulses_of(const ContactSystem& system, const oracle::MixedImpulses& impulses);

/// Gives the contacts and joints of a system these impulses, and its bodies the velocities that they have with them
/// instead of those before.
void set_impulses(ContactSystem& system, const SystemImpulses& impulses);

}  // namespace lockstep
