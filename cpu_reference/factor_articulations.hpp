// Factors of the equations of articulations, from what prepare_joints wrote of their joints. The free row of a joint is
// one of them where it is locked too, or a spring acts on it, and no motor besides: a motor and limits that are apart
// push as far as they need to, which is for sweeps (cpu_reference/joints/solve_joint.hpp). The impedance of a joint is
// a row whatever acts beside it. Joints that close loops come behind the links. Where bodies sleep all of it is zero.
#pragma once

#include "cpu_reference/articulations/closures.hpp"
#include "cpu_reference/joints/solve_joint.hpp"
#include "cpu_reference/sleep.hpp"

namespace lockstep::reference {

/// The joint of a link, as the link feels it. Returns the rows that its articulation solves.
template <class real>
u32 write_link_joint(const Buffers<real>& b, const LinkInfo& link, LinkFactor<real>& f) {
  const JointBlock<real>& block = b.joint_blocks[link.slot / PACK];
  const u32 lane = link.slot % PACK;
  const JointInfo& info = b.joint_infos[link.joint];
  const real sign = link.is_b != 0 ? real(1) : real(-1);
  const bool driven = block.motor_impulse[lane] != 0, fixed = block.slowest[lane] == block.fastest[lane] && !driven;
  const bool impedance = !fixed && has_impedance(block, lane);
  const u32 rows = info.locked | (info.free != FREE_NOTHING && (fixed || impedance) ? 1u << JOINT_ROWS : 0u);
  const Vec3<real> axes[] = {joint_vector(block.axes, lane), joint_vector(block.axes + 3, lane),
                             joint_vector(block.axes + 6, lane)};
  set_link_joint(link, info.free == FREE_ANGLE, axes, joint_vector(block.arm_a, lane), joint_vector(block.arm_b, lane),
                 joint_vector(block.free_axis, lane), block.lead[lane], f);
  f.impedance = impedance ? real(1) : real(0);
  f.spring_compliance = impedance ? block.impedance_compliance[lane] : block.spring_compliance[lane];
  for (u32 i = 0; i < JOINT_ROWS; ++i) f.error[i] = sign * (block.bias[i][lane] + block.velocity_product[i][lane]);
  f.error[JOINT_ROWS] = -(sign * (impedance ? block.impedance_speed[lane] : block.slowest[lane]));
  return rows;
}

template <class real>
void factor_articulations(Buffers<real>& b, const StepParams<real>&) {
  if (step_aborted(b.counters)) return;
  std::vector<LinkMotion<real>> columns = room_for_columns(b);
  for (u32 t = 0; t < b.articulations.size(); ++t) {
    const Articulation& tree = b.articulations[t];
    const bool asleep = is_asleep(b, tree.root);
    for_each_link_up(b, tree, [&](u32 i, const LinkInfo& link) {
      LinkFactor<real>& f = b.link_factors[i];
      f = {};
      b.link_motions[i] = {};
      if (asleep) return;
      const u32 rows = link.joint == NONE ? 0 : write_link_joint(b, link, f);  // one that floats has none
      factorise_link(b, link, rows, f);
    });
    const ClosureSet loops = closures_of(b, t);
    clear_closures(b, loops);
    if (asleep) continue;
    for_each_closure(b, loops, [&](u32 k, const ClosureInfo& closure) {
      const LinkInfo link = as_link(b, closure);
      mark_rows(write_link_joint(b, link, b.closure_factors[k]), b.closure_factors[k]);
    });
    factor_closures(b, tree, loops, columns);
  }
}

}  // namespace lockstep::reference
