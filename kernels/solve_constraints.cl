#pragma OPENCL FP_CONTRACT OFF
// Sweeps of blocked Gauss-Seidel over the colours, before them over cells, or of Jacobi's method over all pairs at once
// (cpu_reference/solve_constraints.hpp).
#include "articulations/solve_links.h"
#include "body_copies.h"
#include "common.h"
#include "joints/couplings.h"
#include "joints/solve_joint.h"
#include "sweep_cells.h"
#include "sweep_contacts.h"
#include "types.h"

#if FEATURE_JOINTS
// One phase of the joints: blocks begin .. end - 1.
kernel void solve_joints(const u32 begin, const u32 end, global const JointLanes* joint_lanes,
                         global const JointBlock* joint_blocks, global JointImpulseBlock* joint_impulses,
                         global Motion* motions, global u32* counters) {
  if (SWEEP_SKIPPED(counters)) return;
  sweep_joint_phase(PURPOSE_SOLVE, begin, end, joint_lanes, joint_blocks, joint_impulses, motions, counters);
}

// One work-group: the phases from `first_phase` on.
kernel void solve_joint_tail(const u32 first_phase, const u32 phases, global const u32* joint_phases,
                             global const JointLanes* joint_lanes, global const JointBlock* joint_blocks,
                             global JointImpulseBlock* joint_impulses, global Motion* motions, global u32* counters) {
  if (SWEEP_SKIPPED(counters)) return;
  sweep_joints(PURPOSE_SOLVE, first_phase, phases, joint_phases, joint_lanes, joint_blocks, joint_impulses, motions,
               counters);
}
#endif

#if FEATURE_COUPLINGS
// One work-group: all couplings.
kernel void solve_couplings(const u32 coupling_phase_count, global const u32* coupling_phases,
                            global const CouplingInfo* coupling_infos, global const CoupledJoint* coupled_joints,
                            global const real* coupling_ratios, global const CouplingRow* coupling_rows,
                            global CouplingImpulse* coupling_impulses, global const JointBlock* joint_blocks,
                            global JointImpulseBlock* joint_impulses, global Motion* motions, global u32* counters) {
  if (SWEEP_SKIPPED(counters)) return;
  const Couplings couplings = COUPLINGS;
  sweep_couplings(PURPOSE_SOLVE, coupling_phase_count, &couplings);
}
#endif

#if FEATURE_ARTICULATIONS
// A work-group an articulation.
kernel void solve_articulations(const u32 articulation_count, global const Articulation* articulations,
                                global const LinkInfo* links, global const u32* link_levels,
                                global const LinkFactor* link_factors, global const JointInfo* joint_infos,
                                global const Sleeper* sleepers, global LinkMotion* link_motions,
                                global const ClosureSet* closure_sets, global const ClosureInfo* closures,
                                global const LinkFactor* closure_factors, global const real* closure_matrix,
                                global real* closure_wanted, global JointImpulseBlock* joint_impulses,
                                global Motion* motions, global u32* counters) {
  const Articulations all = ARTICULATIONS;
  solve_articulation_groups(articulation_count, &all);
}
#endif

// One colour of a sweep.
kernel void solve_color(const u32 color, global const u32* color_starts, global const BlockBodies* block_bodies,
                        global const BlockRows* block_rows, global const ContactBlock* contact_blocks,
                        global const SoftnessBlock* softness_blocks, global const SlideBlock* slide_blocks,
                        global const AngularFrictionBlock* angular_friction_blocks,
                        global const EllipseBlock* ellipse_blocks, global NormalCoupling* normal_couplings,
                        global const PatchBlock* patch_blocks, global ImpulseBlock* impulse_blocks,
                        global AngularFrictionImpulse* angular_friction_impulses, global PatchImpulse* patch_impulses,
                        global Motion* motions, global u32* counters) {
  if (SWEEP_SKIPPED(counters)) return;
  const ContactStream stream = CONTACT_STREAM;
  sweep_color(PURPOSE_SOLVE, color, color_starts, &stream);
}

#if FEATURE_PARTITIONS
// One phase of the cells.
kernel void solve_cells(const StepParams params, const u32 phase, global const u32* cell_blocks,
                        global const u32* color_starts, global const BlockBodies* block_bodies,
                        global const BlockRows* block_rows, global const ContactBlock* contact_blocks,
                        global const SoftnessBlock* softness_blocks, global const SlideBlock* slide_blocks,
                        global const AngularFrictionBlock* angular_friction_blocks,
                        global const EllipseBlock* ellipse_blocks, global NormalCoupling* normal_couplings,
                        global const PatchBlock* patch_blocks, global ImpulseBlock* impulse_blocks,
                        global AngularFrictionImpulse* angular_friction_impulses, global PatchImpulse* patch_impulses,
                        global Motion* motions, global u32* counters) {
  const ContactStream stream = CONTACT_STREAM;
  sweep_cell_phase(PURPOSE_SOLVE, cell_phase(phase, &params, color_starts, counters), (u32)get_group_id(0),
                   (u32)get_num_groups(0), cell_blocks, &stream);
}
#endif

// One work-group: `sweeps` sweeps over articulations, the joints' first phases, couplings and the contacts' phases from
// `first_phase` on.
// `whole`: 1 where nothing else belongs to these sweeps.
kernel void solve_tail(
    const StepParams params, const u32 first_phase, const u32 joint_phase_count, const u32 coupling_phase_count,
    const u32 sweeps, const u32 whole, const u32 articulation_count, global const Articulation* articulations,
    global const LinkInfo* links, global const u32* link_levels, global const LinkFactor* link_factors,
    global LinkMotion* link_motions, global const ClosureSet* closure_sets, global const ClosureInfo* closures,
    global const LinkFactor* closure_factors, global const real* closure_matrix, global real* closure_wanted,
    global const JointInfo* joint_infos, global const Sleeper* sleepers, global const u32* color_starts,
    global const u32* cell_blocks, global const u32* joint_phases, global const JointLanes* joint_lanes,
    global const JointBlock* joint_blocks, global JointImpulseBlock* joint_impulses, global const u32* coupling_phases,
    global const CouplingInfo* coupling_infos, global const CoupledJoint* coupled_joints,
    global const real* coupling_ratios, global const CouplingRow* coupling_rows,
    global CouplingImpulse* coupling_impulses, global const BlockBodies* block_bodies,
    global const BlockRows* block_rows, global const ContactBlock* contact_blocks,
    global const SoftnessBlock* softness_blocks, global const SlideBlock* slide_blocks,
    global const AngularFrictionBlock* angular_friction_blocks, global const EllipseBlock* ellipse_blocks,
    global NormalCoupling* normal_couplings, global const PatchBlock* patch_blocks, global ImpulseBlock* impulse_blocks,
    global AngularFrictionImpulse* angular_friction_impulses, global PatchImpulse* patch_impulses,
    global Motion* motions, global u32* counters) {
  const ContactStream stream = CONTACT_STREAM;
  const u32 joint_phases_here = SWEEP_SKIPPED(counters) ? 0u : joint_phase_count;
#if FEATURE_ARTICULATIONS
  const Articulations all = ARTICULATIONS;
#endif
#if FEATURE_COUPLINGS
  const Couplings couplings = COUPLINGS;
  const u32 coupling_phases_here = SWEEP_SKIPPED(counters) ? 0u : coupling_phase_count;
#endif
  u32 sweep = 0u;
  do {
#if FEATURE_ARTICULATIONS
    solve_articulation_groups(articulation_count, &all);
#if TEAM_IS_GRID
    TEAM_BARRIER(counters);
#endif
#endif
#if FEATURE_JOINTS
    sweep_joints(PURPOSE_SOLVE, 0u, joint_phases_here, joint_phases, joint_lanes, joint_blocks, joint_impulses, motions,
                 counters);
#endif
#if FEATURE_COUPLINGS
    sweep_couplings(PURPOSE_SOLVE, coupling_phases_here, &couplings);
#endif
#if FEATURE_PARTITIONS
    sweep_cell_tail(PURPOSE_SOLVE, first_phase, &params, color_starts, cell_blocks, &stream, counters);
#else
    sweep_tail(PURPOSE_SOLVE, first_phase, color_starts, &stream, counters);
#endif
#if FEATURE_TOLERANCE
    if (whole != 0u && group_has_settled(params.tolerance, sweep + 1u >= sweeps, counters)) break;
#endif
  } while (++sweep < sweeps);
}

#if FEATURE_TOLERANCE
// Behind a sweep of several launches: counts it, and tells those that follow in the sub-step whether they are needed.
kernel void end_sweep(const StepParams params, const u32 is_last, global u32* counters) {
  if (STEP_ABORTED(counters) || get_global_id(0) != 0) return;
  const bool did_nothing = counters[COUNTER_SETTLED] != 0u;
  const bool settled = did_nothing || sweep_has_settled(params.tolerance, counters);
  counters[COUNTER_SWEEPS] += did_nothing ? 0u : 1u;
  counters[COUNTER_SWEEP_CHANGE] = 0u;
  counters[COUNTER_UNSOLVED] += settled || is_last == 0u ? 0u : 1u;
  counters[COUNTER_SETTLED] = settled && is_last == 0u ? 1u : 0u;
}
#endif

#if FEATURE_JACOBI
static inline void solve_item(u32 item, const ContactStream* s, global const BodyCopyBlock* body_copy_blocks,
                              global Velocity* body_copies) {
  const u32 block = item / ITEMS_PER_BLOCK, first = item % ITEMS_PER_BLOCK * LANES;
  global const BlockBodies* bodies = s->bodies + block;
  global const BodyCopyBlock* copies = body_copy_blocks + block;
  LaneBody a = body_copy_load(s->motions, bodies->body_a + first, copies->copies_a + first);
  LaneBody b = body_copy_load(s->motions, bodies->body_b + first, copies->copies_b + first);
  solve_pair_lanes(PURPOSE_SOLVE, block, first, s, &a, &b);
  body_copy_store(a, body_copies, copies->slot_a + first);
  body_copy_store(b, body_copies, copies->slot_b + first);
}

// A sweep over all pairs; average_body_copies follows.
kernel void solve_body_copies(global const BodyCopyBlock* body_copy_blocks, global Velocity* body_copies,
                              global const BlockBodies* block_bodies, global const BlockRows* block_rows,
                              global const ContactBlock* contact_blocks, global const SoftnessBlock* softness_blocks,
                              global const SlideBlock* slide_blocks,
                              global const AngularFrictionBlock* angular_friction_blocks,
                              global const EllipseBlock* ellipse_blocks, global NormalCoupling* normal_couplings,
                              global const PatchBlock* patch_blocks, global ImpulseBlock* impulse_blocks,
                              global AngularFrictionImpulse* angular_friction_impulses,
                              global PatchImpulse* patch_impulses, global Motion* motions, global u32* counters) {
  if (SWEEP_SKIPPED(counters)) return;
  const ContactStream stream = CONTACT_STREAM;
  FOR_EACH(item, counters[COUNTER_BLOCKS] * ITEMS_PER_BLOCK) solve_item(item, &stream, body_copy_blocks, body_copies);
}

// One work-group: `sweeps` sweeps over the joints' first phases, couplings and all pairs.
kernel void solve_body_copies_group(const StepParams params, const u32 bodies, const u32 joint_phase_count,
                                    const u32 coupling_phase_count, const u32 sweeps,
                                    global const BodyCopyBlock* body_copy_blocks, global const u32* body_copy_starts,
                                    global const u32* joint_phases, global const JointLanes* joint_lanes,
                                    global const JointBlock* joint_blocks, global JointImpulseBlock* joint_impulses,
                                    global const u32* coupling_phases, global const CouplingInfo* coupling_infos,
                                    global const CoupledJoint* coupled_joints, global const real* coupling_ratios,
                                    global const CouplingRow* coupling_rows, global CouplingImpulse* coupling_impulses,
                                    global Velocity* body_copies, global const BlockBodies* block_bodies,
                                    global const BlockRows* block_rows, global const ContactBlock* contact_blocks,
                                    global const SoftnessBlock* softness_blocks, global const SlideBlock* slide_blocks,
                                    global const AngularFrictionBlock* angular_friction_blocks,
                                    global const EllipseBlock* ellipse_blocks, global NormalCoupling* normal_couplings,
                                    global const PatchBlock* patch_blocks, global ImpulseBlock* impulse_blocks,
                                    global AngularFrictionImpulse* angular_friction_impulses,
                                    global PatchImpulse* patch_impulses, global Motion* motions, global u32* counters) {
  const ContactStream stream = CONTACT_STREAM;
  const bool is_aborted = STEP_ABORTED(counters);
  const u32 items = is_aborted ? 0u : counters[COUNTER_BLOCKS] * ITEMS_PER_BLOCK, whole = is_aborted ? 0u : bodies;
  const u32 joint_phases_here = is_aborted ? 0u : joint_phase_count;
#if FEATURE_COUPLINGS
  const Couplings couplings = COUPLINGS;
  const u32 coupling_phases_here = is_aborted ? 0u : coupling_phase_count;
#endif
  u32 sweep = 0u;
  do {
#if FEATURE_JOINTS
    sweep_joints(PURPOSE_SOLVE, 0u, joint_phases_here, joint_phases, joint_lanes, joint_blocks, joint_impulses, motions,
                 counters);
#endif
#if FEATURE_COUPLINGS
    sweep_couplings(PURPOSE_SOLVE, coupling_phases_here, &couplings);
#endif
    FOR_EACH_OF_TEAM(item, 0u, items)
    solve_item(item, &stream, body_copy_blocks, body_copies);
    TEAM_BARRIER(counters);
    FOR_EACH_OF_TEAM(i, 0u, whole)
    body_copy_mean(i, body_copy_starts, body_copies, motions);
    TEAM_BARRIER(counters);
#if FEATURE_TOLERANCE
    if (group_has_settled(params.tolerance, sweep + 1u >= sweeps, counters)) break;
#endif
  } while (++sweep < sweeps);
}
#endif
