#pragma OPENCL FP_CONTRACT OFF
// Sweeps that take back what soft contacts gave to push overlap apart (cpu_reference/relax_constraints.hpp).
#include "common.h"
#include "joints/couplings.h"
#include "joints/solve_joint.h"
#include "sweep_contacts.h"
#include "types.h"

#if FEATURE_JOINTS
// One phase of the joints: blocks begin .. end - 1.
kernel void relax_joints(const u32 begin, const u32 end, global const JointLanes* joint_lanes,
                         global const JointBlock* joint_blocks, global JointImpulseBlock* joint_impulses,
                         global Motion* motions, global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  sweep_joint_phase(PURPOSE_RELAX, begin, end, joint_lanes, joint_blocks, joint_impulses, motions, counters);
}

// One work-group: the phases from `first_phase` on.
kernel void relax_joint_tail(const u32 first_phase, const u32 phases, global const u32* joint_phases,
                             global const JointLanes* joint_lanes, global const JointBlock* joint_blocks,
                             global JointImpulseBlock* joint_impulses, global Motion* motions, global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  sweep_joints(PURPOSE_RELAX, first_phase, phases, joint_phases, joint_lanes, joint_blocks, joint_impulses, motions,
               counters);
}
#endif

#if FEATURE_COUPLINGS
// One work-group: all couplings.
kernel void relax_couplings(const u32 coupling_phase_count, global const u32* coupling_phases,
                            global const CouplingInfo* coupling_infos, global const CoupledJoint* coupled_joints,
                            global const real* coupling_ratios, global const CouplingRow* coupling_rows,
                            global CouplingImpulse* coupling_impulses, global const JointBlock* joint_blocks,
                            global JointImpulseBlock* joint_impulses, global Motion* motions, global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  const Couplings couplings = COUPLINGS;
  sweep_couplings(PURPOSE_RELAX, coupling_phase_count, &couplings);
}
#endif

// One colour.
kernel void relax_color(const u32 color, global const u32* color_starts, global const BlockBodies* block_bodies,
                        global const BlockRows* block_rows, global const ContactBlock* contact_blocks,
                        global const SoftnessBlock* softness_blocks, global const SlideBlock* slide_blocks,
                        global const AngularFrictionBlock* angular_friction_blocks,
                        global const EllipseBlock* ellipse_blocks, global NormalCoupling* normal_couplings,
                        global const PatchBlock* patch_blocks, global ImpulseBlock* impulse_blocks,
                        global AngularFrictionImpulse* angular_friction_impulses, global PatchImpulse* patch_impulses,
                        global Motion* motions, global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  const ContactStream stream = CONTACT_STREAM;
  sweep_color(PURPOSE_RELAX, color, color_starts, &stream);
}

// One work-group: `sweeps` sweeps over the joints' first phases, couplings and the contacts' phases from `first_phase`
// on.
kernel void relax_tail(const u32 first_phase, const u32 joint_phase_count, const u32 coupling_phase_count,
                       const u32 sweeps, global const u32* color_starts, global const u32* joint_phases,
                       global const JointLanes* joint_lanes, global const JointBlock* joint_blocks,
                       global JointImpulseBlock* joint_impulses, global const u32* coupling_phases,
                       global const CouplingInfo* coupling_infos, global const CoupledJoint* coupled_joints,
                       global const real* coupling_ratios, global const CouplingRow* coupling_rows,
                       global CouplingImpulse* coupling_impulses, global const BlockBodies* block_bodies,
                       global const BlockRows* block_rows, global const ContactBlock* contact_blocks,
                       global const SoftnessBlock* softness_blocks, global const SlideBlock* slide_blocks,
                       global const AngularFrictionBlock* angular_friction_blocks,
                       global const EllipseBlock* ellipse_blocks, global NormalCoupling* normal_couplings,
                       global const PatchBlock* patch_blocks, global ImpulseBlock* impulse_blocks,
                       global AngularFrictionImpulse* angular_friction_impulses, global PatchImpulse* patch_impulses,
                       global Motion* motions, global u32* counters) {
  const ContactStream stream = CONTACT_STREAM;
  const u32 joint_phases_here = STEP_ABORTED(counters) ? 0u : joint_phase_count;
#if FEATURE_COUPLINGS
  const Couplings couplings = COUPLINGS;
  const u32 coupling_phases_here = STEP_ABORTED(counters) ? 0u : coupling_phase_count;
#endif
  u32 sweep = 0u;
  do {
#if FEATURE_JOINTS
    sweep_joints(PURPOSE_RELAX, 0u, joint_phases_here, joint_phases, joint_lanes, joint_blocks, joint_impulses, motions,
                 counters);
#endif
#if FEATURE_COUPLINGS
    sweep_couplings(PURPOSE_RELAX, coupling_phases_here, &couplings);
#endif
    sweep_tail(PURPOSE_RELAX, first_phase, color_starts, &stream, counters);
  } while (++sweep < sweeps);
}
