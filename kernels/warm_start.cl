#pragma OPENCL FP_CONTRACT OFF
// Gives the bodies the impulses that the contacts start from (cpu_reference/warm_start.hpp).
#include "body_copies.h"
#include "common.h"
#include "joints/couplings.h"
#include "joints/solve_joint.h"
#include "start_contacts.h"
#include "sweep_cells.h"
#include "types.h"

#if FEATURE_JOINTS
// One phase of the joints: blocks begin .. end - 1.
kernel void warm_joints(const u32 begin, const u32 end, global const JointLanes* joint_lanes,
                        global const JointBlock* joint_blocks, global const JointImpulseBlock* joint_impulses,
                        global Motion* motions, global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(item, (end - begin) * ITEMS_PER_BLOCK) {
    const u32 block = begin + item / ITEMS_PER_BLOCK;
    start_joints(item % ITEMS_PER_BLOCK * LANES, joint_lanes + block, joint_blocks + block, joint_impulses + block,
                 motions);
  }
}

// One work-group: the phases from `first_phase` on.
kernel void warm_joint_tail(const u32 first_phase, const u32 phases, global const u32* joint_phases,
                            global const JointLanes* joint_lanes, global const JointBlock* joint_blocks,
                            global const JointImpulseBlock* joint_impulses, global Motion* motions,
                            global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  start_joint_phases(first_phase, phases, joint_phases, joint_lanes, joint_blocks, joint_impulses, motions, counters);
}
#endif

#if FEATURE_COUPLINGS
// One work-group: all couplings.
kernel void warm_couplings(const u32 coupling_phase_count, global const u32* coupling_phases,
                           global const CouplingInfo* coupling_infos, global const CoupledJoint* coupled_joints,
                           global const real* coupling_ratios, global const CouplingImpulse* coupling_impulses,
                           global const JointBlock* joint_blocks, global Motion* motions, global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  start_couplings(coupling_phase_count, coupling_phases, coupling_infos, coupled_joints, coupling_ratios,
                  coupling_impulses, joint_blocks, motions, counters);
}
#endif

// One colour.
kernel void warm_color(const u32 color, global const u32* color_starts, global const BlockBodies* block_bodies,
                       global const BlockRows* block_rows, global const ContactBlock* contact_blocks,
                       global const ImpulseBlock* impulse_blocks,
                       global const AngularFrictionBlock* angular_friction_blocks,
                       global const AngularFrictionImpulse* angular_friction_impulses,
                       global const PatchBlock* patch_blocks, global const PatchImpulse* patch_impulses,
                       global Motion* motions, global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  const StartStream stream = START_STREAM;
  const u32 begin = color_starts[color], items = (color_starts[color + 1u] - begin) * ITEMS_PER_BLOCK;
  FOR_EACH(item, items) start_item(begin, item, &stream);
}

#if FEATURE_PARTITIONS
// As sweep_cell_phase of kernels/sweep_cells.h.
static inline void start_cell_phase(CellPhase phase, u32 group, u32 groups, global const u32* cell_blocks,
                                    const StartStream* s) {
  u32 base = phase.begin + group * CELL_TEAMS;
  do {
    const CellTeam team = cell_team(base, phase, cell_blocks);
    u32 round = 0u;
    do {
      for (u32 item = team.member; item < cell_team_items(team, round); item += team.members)
        start_item(team.first + round, item, s);
      CELL_TEAM_BARRIER;
    } while (++round < team.rounds);
    base += groups * CELL_TEAMS;
  } while (base < phase.end);
}

// One phase of the cells.
kernel void warm_cells(const StepParams params, const u32 phase, global const u32* cell_blocks,
                       global const u32* color_starts, global const BlockBodies* block_bodies,
                       global const BlockRows* block_rows, global const ContactBlock* contact_blocks,
                       global const ImpulseBlock* impulse_blocks,
                       global const AngularFrictionBlock* angular_friction_blocks,
                       global const AngularFrictionImpulse* angular_friction_impulses,
                       global const PatchBlock* patch_blocks, global const PatchImpulse* patch_impulses,
                       global Motion* motions, global const u32* counters) {
  const StartStream stream = START_STREAM;
  start_cell_phase(cell_phase(phase, &params, color_starts, counters), (u32)get_group_id(0), (u32)get_num_groups(0),
                   cell_blocks, &stream);
}
#endif

// One work-group: the joints' first phases, couplings and the contacts' phases from `first_phase` on.
kernel void warm_tail(const StepParams params, const u32 first_phase, const u32 joint_phase_count,
                      const u32 coupling_phase_count, global const u32* color_starts, global const u32* cell_blocks,
                      global const BlockBodies* block_bodies, global const BlockRows* block_rows,
                      global const ContactBlock* contact_blocks, global const ImpulseBlock* impulse_blocks,
                      global const AngularFrictionBlock* angular_friction_blocks,
                      global const AngularFrictionImpulse* angular_friction_impulses,
                      global const PatchBlock* patch_blocks, global const PatchImpulse* patch_impulses,
                      global const u32* joint_phases, global const JointLanes* joint_lanes,
                      global const JointBlock* joint_blocks, global const JointImpulseBlock* joint_impulses,
                      global const u32* coupling_phases, global const CouplingInfo* coupling_infos,
                      global const CoupledJoint* coupled_joints, global const real* coupling_ratios,
                      global const CouplingImpulse* coupling_impulses, global Motion* motions,
                      global const u32* counters) {
  const StartStream stream = START_STREAM;
#if FEATURE_JOINTS
  start_joint_phases(0u, STEP_ABORTED(counters) ? 0u : joint_phase_count, joint_phases, joint_lanes, joint_blocks,
                     joint_impulses, motions, counters);
#endif
#if FEATURE_COUPLINGS
  start_couplings(STEP_ABORTED(counters) ? 0u : coupling_phase_count, coupling_phases, coupling_infos, coupled_joints,
                  coupling_ratios, coupling_impulses, joint_blocks, motions, counters);
#endif
#if FEATURE_PARTITIONS
  u32 phase = min(first_phase, CELL_PHASES + counters[COUNTER_COLORS]);
  do {
    start_cell_phase(cell_phase(phase, &params, color_starts, counters), 0u, 1u, cell_blocks, &stream);
    barrier(CLK_GLOBAL_MEM_FENCE);
  } while (++phase < cell_phases(counters));
#else
  const u32 phases = contact_phases(counters);
  u32 phase = min(first_phase, counters[COUNTER_COLORS]);
  do {
    // scenes of joints alone have no colours, nor where they start
    const bool is_there = phase < phases;
    const u32 begin = is_there ? phase_begin(phase, color_starts, counters) : 0u;
    const u32 items = is_there ? (phase_end(phase, color_starts, counters) - begin) * ITEMS_PER_BLOCK : 0u;
    FOR_EACH_OF_TEAM(item, 0u, items)
    start_item(begin, item, &stream);
    TEAM_BARRIER(counters);
  } while (++phase < phases);
#endif
}

#if FEATURE_JACOBI
// All pairs at once, on copies of their bodies; average_body_copies follows.
kernel void warm_body_copies(global const BlockBodies* block_bodies, global const BlockRows* block_rows,
                             global const ContactBlock* contact_blocks, global const ImpulseBlock* impulse_blocks,
                             global const AngularFrictionBlock* angular_friction_blocks,
                             global const AngularFrictionImpulse* angular_friction_impulses,
                             global const PatchBlock* patch_blocks, global const PatchImpulse* patch_impulses,
                             global const BodyCopyBlock* body_copy_blocks, global Velocity* body_copies,
                             global const Motion* motions, global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(item, counters[COUNTER_BLOCKS] * ITEMS_PER_BLOCK) {
    const u32 block = item / ITEMS_PER_BLOCK, first = item % ITEMS_PER_BLOCK * LANES;
    global const BlockBodies* bodies = block_bodies + block;
    global const BodyCopyBlock* copies = body_copy_blocks + block;
    LaneBody a = body_copy_load(motions, bodies->body_a + first, copies->copies_a + first);
    LaneBody b = body_copy_load(motions, bodies->body_b + first, copies->copies_b + first);
    start_lanes(block, first, block_bodies, block_rows, contact_blocks, impulse_blocks, angular_friction_blocks,
                angular_friction_impulses, patch_blocks, patch_impulses, &a, &b);
    body_copy_store(a, body_copies, copies->slot_a + first);
    body_copy_store(b, body_copies, copies->slot_b + first);
  }
}
#endif
