#include "host/steppers/joint_source.hpp"

#include "host/sleepers.hpp"

namespace lockstep {

template <class real>
JointSource<real> joint_source(Backend<real>& backend, u32 joint, bool has_stepped) {
  const Features features = backend.features();
  const bool sums = has_stepped && has(features, Feature::summed_joints);
  std::vector<Buffer> wanted = {Buffer::positions,   Buffer::orientations,  Buffer::motions,
                                Buffer::joint_infos, Buffer::joints,        Buffer::screw_leads,
                                Buffer::joint_lanes, Buffer::rolling_radii, Buffer::joint_impulses};
  if (has(features, Feature::joint_angles)) wanted.push_back(Buffer::joint_angles);
  if (sums) wanted.push_back(Buffer::joint_sums);
  if (has(features, Feature::sleeping)) wanted.push_back(Buffer::sleepers);
  const Buffers<real>& b = backend.download(wanted);
  const auto sleeps = [&](u32 body) { return body < b.sleepers.size() && is_asleep(b.sleepers[body]); };
  const JointInfo& info = b.joint_infos[joint];
  const bool rests = sleeps(info.body_a) || sleeps(info.body_b);
  return {b, sums && !rests ? ImpulsesOf::step : ImpulsesOf::last_substep};
}

template JointSource<float> joint_source(Backend<float>&, u32, bool);
template JointSource<double> joint_source(Backend<double>&, u32, bool);

}  // namespace lockstep
