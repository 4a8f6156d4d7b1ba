// What is measured on joints, in double (docs/error_measures.md).
#pragma once

#include "host/buffers.hpp"

namespace lockstep {

/// How far joints are from their place: the largest of all.
struct JointDrift {
  double separation = 0;  // m: of the anchors along locked directions, or of a distance from its limits
  double angle = 0;       // rad: of the turn about locked directions
};

/// At the poses of the step's end.
template <class real>
JointDrift joint_drift(const Buffers<real>& buffers);

/// k (x - rest)^2 / 2 of the spring on the free coordinate x of a joint, J; 0 where it has none.
template <class real>
double spring_energy(const Buffers<real>& buffers, const StepParams<real>& params, u32 joint);

/// Whether joints neither take energy up nor give it: no motors, no dampers, none that are soft, no limits but equal
/// ones.
template <class real>
bool joints_conserve_energy(const Buffers<real>& buffers, const StepParams<real>& params);

/// Whether every joint holds two dynamic bodies.
template <class real>
bool joints_conserve_momentum(const Buffers<real>& buffers);

}  // namespace lockstep
