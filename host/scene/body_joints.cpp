#include "host/scene/body_joints.hpp"

namespace lockstep {

template <class real>
void list_body_joints(Buffers<real>& b) {
  std::vector<u32> slots(b.joint_infos.size(), 0);
  for (u32 block = 0; block < b.joint_lanes.size(); ++block) {
    for (u32 lane = 0; lane < PACK; ++lane) {
      const u32 joint = b.joint_lanes[block].joint[lane];
      if (joint != NONE) slots[joint] = PACK * block + lane;
    }
  }
  std::vector<std::vector<BodyJoint>> of_bodies(b.body_infos.size());
  for (u32 joint = 0; joint < b.joint_infos.size(); ++joint) {
    for (const u32 body : {b.joint_infos[joint].body_a, b.joint_infos[joint].body_b})
      if (body < of_bodies.size() && b.body_infos[body].kind == BODY_DYNAMIC)
        of_bodies[body].push_back({joint, slots[joint]});
  }
  b.body_joint_starts = {0};
  b.body_joints.clear();
  for (const std::vector<BodyJoint>& of_body : of_bodies) {
    b.body_joints.insert(b.body_joints.end(), of_body.begin(), of_body.end());
    b.body_joint_starts.push_back(static_cast<u32>(b.body_joints.size()));
  }
}

template <class real>
void list_planar_joints(Buffers<real>& b) {
  const auto is = [&](BodyKind kind, u32 body) {
    return body < b.body_infos.size() ? b.body_infos[body].kind == kind : kind == BODY_STATIC;
  };
  std::vector<bool> taken(b.body_infos.size(), false);
  b.planar_joints.clear();
  for (u32 joint = 0; joint < b.joint_infos.size(); ++joint) {
    const JointInfo& info = b.joint_infos[joint];
    const u32 body = is(BODY_DYNAMIC, info.body_b) ? info.body_b : info.body_a;
    const u32 other = body == info.body_b ? info.body_a : info.body_b;
    const bool is_rigid = info.kind == JOINT_PLANAR && b.joints[joint].spring == 0;
    if (!is_rigid || !is(BODY_DYNAMIC, body) || !is(BODY_STATIC, other) || taken[body]) continue;
    taken[body] = true;
    b.planar_joints.push_back(joint);
  }
}

template void list_body_joints(Buffers<float>&);
template void list_body_joints(Buffers<double>&);
template void list_planar_joints(Buffers<float>&);
template void list_planar_joints(Buffers<double>&);

}  // namespace lockstep
