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

/// Of all joints, downloaded once.
template <class real>
class JointSources {
 public:
  JointSources(Backend<real>& backend, bool has_stepped);

  u32 count() const { return static_cast<u32>(buffers_.joint_infos.size()); }

  /// Of the step where the scene keeps the sums; of the last sub-step where it does not, of a joint that sleeps, and of
  /// all where the backend has not stepped: what lives on is known of them alone.
  JointSource<real> of(u32 joint) const;

 private:
  const Buffers<real>& buffers_;
  bool sums_;
};

}  // namespace lockstep
