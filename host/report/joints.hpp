// What is measured on joints, in double (docs/reference/error_measures.md).
#pragma once

#include <Eigen/Core>

#include "host/buffers.hpp"

namespace lockstep {

/// How far joints are from their place: the largest of all.
struct JointDrift {
  double separation = 0;  // m: of the anchors along locked directions, of a distance from its limits, or of the travel
                          // of a screw from what its angle says
  double ratio = 0;       // of it, or of what a length is beyond its limits, to the size of the smaller body
                          // (cpu_reference/prepare_joints.hpp)
  double angle = 0;       // rad: of the rotation about locked directions, or of a cross from a right angle
};

/// At the poses of the step's end.
template <class real>
JointDrift joint_drift(const Buffers<real>& buffers);

/// What a joint did: in the last sub-step, or in all of the last step, of which the scene keeps the sums (feature
/// summed_impulses).
enum class ImpulsesOf { last_substep, step };

/// Of one joint: how it stands, and what it did. World frame, SI units; forces are means of the time that is asked for.
struct JointMeasures {
  double coordinate = 0, speed = 0;  // of its free coordinate, m or rad; 0 where it has none
  double drive = 0;                  // N or N m: of motor, friction, limits or spring along it
  Eigen::Vector3d force, torque;     // of the locked rows, on b at its anchor, N and N m
  JointDrift drift;
};

/// The impulses of the last sub-step are along the axes of now, with which they turn.
template <class real>
JointMeasures measure_joint(const Buffers<real>& buffers, const StepParams<real>& params, u32 joint,
                            ImpulsesOf of = ImpulsesOf::last_substep);

/// k (x - rest)^2 / 2 of the spring on the free coordinate x of a joint, J; 0 where it has none.
template <class real>
double spring_energy(const Buffers<real>& buffers, const StepParams<real>& params, u32 joint);
/// The same of the spring of a coupling.
template <class real>
double coupling_energy(const Buffers<real>& buffers, const StepParams<real>& params, u32 index);

/// The energy of motion that the armature of a joint has along its coordinate, J.
template <class real>
double armature_energy(const Buffers<real>& buffers, const StepParams<real>& params, u32 joint);

/// Whether joints neither take energy up nor give it: no motors, no dampers, none that are soft, no limits but equal
/// ones.
template <class real>
bool joints_conserve_energy(const Buffers<real>& buffers, const StepParams<real>& params);

/// Whether every joint holds two dynamic bodies.
template <class real>
bool joints_conserve_momentum(const Buffers<real>& buffers);

}  // namespace lockstep
