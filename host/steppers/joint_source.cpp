#include "host/steppers/joint_source.hpp"

#include "host/sleepers.hpp"

namespace lockstep {

namespace {

template <class real>
const Buffers<real>& download_joints(Backend<real>& backend, bool sums) {
  const Features features = backend.features();
  std::vector<Buffer> wanted = {Buffer::positions,   Buffer::orientations,  Buffer::motions,
                                Buffer::joint_infos, Buffer::joints,        Buffer::screw_leads,
                                Buffer::joint_lanes, Buffer::rolling_radii, Buffer::joint_impulses};
  if (has(features, Feature::joint_angles)) wanted.push_back(Buffer::joint_angles);
  if (sums) wanted.push_back(Buffer::joint_sums);
  if (has(features, Feature::sleeping)) wanted.push_back(Buffer::sleepers);
  return backend.download(wanted);
}

}  // namespace

template <class real>
JointSources<real>::JointSources(Backend<real>& backend, bool has_stepped)
    : buffers_(download_joints(backend, has_stepped && has(backend.features(), Feature::summed_joints))),
      sums_(has_stepped && has(backend.features(), Feature::summed_joints)) {}

template <class real>
JointSource<real> JointSources<real>::of(u32 joint) const {
  const auto sleeps = [this](u32 body) {
    return body < buffers_.sleepers.size() && is_asleep(buffers_.sleepers[body]);
  };
  const JointInfo& info = buffers_.joint_infos[joint];
  const bool rests = sleeps(info.body_a) || sleeps(info.body_b);
  return {buffers_, sums_ && !rests ? ImpulsesOf::step : ImpulsesOf::last_substep};
}

template class JointSources<float>;
template class JointSources<double>;

}  // namespace lockstep
