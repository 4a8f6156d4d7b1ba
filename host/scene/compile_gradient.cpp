#include "host/scene/compile_gradient.hpp"

#include <algorithm>

namespace lockstep {

template <class real>
void compile_gradient(bool accelerated, InitialState<real>& state) {
  Buffers<real>& b = state.buffers;
  b.gradient_laws = {{accelerated ? 1u : 0u}};
  const auto moves = [&](u32 body) { return body < b.body_infos.size() && b.body_infos[body].kind == BODY_DYNAMIC; };
  b.joint_side_starts.assign(b.body_infos.size() + 1, 0);
  for (const JointInfo& joint : b.joint_infos) {
    for (const u32 body : {joint.body_a, joint.body_b})
      if (moves(body)) ++b.joint_side_starts[body + 1];
  }
  for (std::size_t i = 1; i < b.joint_side_starts.size(); ++i) b.joint_side_starts[i] += b.joint_side_starts[i - 1];

  struct JointSlots {
    u32 a, b;
  };
  std::vector<u32> next(b.joint_side_starts.begin(), b.joint_side_starts.end());
  std::vector<JointSlots> joint_slots;  // of each joint
  for (const JointInfo& joint : b.joint_infos) {
    const u32 slot_a = moves(joint.body_a) ? next[joint.body_a]++ : NONE;
    const u32 slot_b = moves(joint.body_b) ? next[joint.body_b]++ : NONE;
    joint_slots.push_back({slot_a, slot_b});
  }
  b.joint_side_slots.clear();
  for (const JointLanes& lanes : b.joint_lanes) {
    JointSideSlots& slots = b.joint_side_slots.emplace_back();
    for (u32 lane = 0; lane < PACK; ++lane) {
      const u32 joint = lanes.joint[lane];
      slots.slot_a[lane] = joint != NONE ? joint_slots[joint].a : NONE;
      slots.slot_b[lane] = joint != NONE ? joint_slots[joint].b : NONE;
    }
  }
}

template void compile_gradient<float>(bool, InitialState<float>&);
template void compile_gradient<double>(bool, InitialState<double>&);

}  // namespace lockstep
