// What a joint is measured from after a step, wherever it was computed.
#pragma once

#include "host/backends/backend.hpp"
#include "host/report/joints.hpp"

namespace lockstep {

template <class real>
struct JointSource {
  const Buffers<real>& buffers;  // what measure_joint() reads
  ImpulsesOf impulses;
};

/// Of the step where the scene keeps the sums; of the last sub-step where it does not, of a joint that sleeps, and of
/// all where the backend has not stepped: what lives on is known of them alone.
template <class real>
JointSource<real> joint_source(Backend<real>& backend, u32 joint, bool has_stepped);

}  // namespace lockstep
