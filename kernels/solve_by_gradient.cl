#pragma OPENCL FP_CONTRACT OFF
// Contacts and joints as one convex problem, by descent along its projected gradient
// (cpu_reference/gradient/solve_by_gradient.hpp).
#include "common.h"
#include "gradient/gradient_joints.h"
#include "gradient/gradient_pairs.h"
#include "rigid_body.h"
#include "types.h"

// Blocks of contacts of a scene that may have none.
static inline u32 gradient_blocks(global const u32* counters) {
#if FEATURE_CONTACTS
  return counters[COUNTER_BLOCKS];
#else
  return 0u;
#endif
}

// All begin from the impulses and the velocities of the warm start.
kernel void gradient_begin(const StepParams params, global const BlockBodies* block_bodies,
                           global const BlockRows* block_rows, global const ContactBlock* contact_blocks,
                           global const ImpulseBlock* impulse_blocks, global const u32* body_copy_starts,
                           global const BodyCopyBlock* body_copy_blocks, global const JointLanes* joint_lanes,
                           global const JointImpulseBlock* joint_impulses, global const u32* joint_side_starts,
                           global const BodyInfo* body_infos, global const Motion* motions,
                           global GradientRow* gradient_rows, global GradientJoints* gradient_joints,
                           global GradientBody* gradient_bodies, global Descent* descents, global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(w, params.worlds) descent_begin(descents + w);
  FOR_EACH(i, params.bodies) {
    global GradientBody* body = gradient_bodies + i;
    const Motion motion = motions[i];
    body->at = make_velocity(vec3(motion.v), vec3(motion.w));
  }
#if FEATURE_CONTACTS
  FOR_EACH(slot, gradient_blocks(counters) * PACK) {
    const u32 block = slot / PACK;
    gradient_begin_pair(slot % PACK, block_bodies + block, block_rows[block], contact_blocks, impulse_blocks,
                        body_copy_blocks + block, joint_side_starts, gradient_rows);
  }
#endif
#if FEATURE_JOINTS
  FOR_EACH(joint, params.joint_blocks * PACK) {
    const u32 block = joint / PACK;
    gradient_begin_joint(joint % PACK, params.bodies, joint_lanes + block, joint_impulses + block, body_infos,
                         body_copy_starts, joint_side_starts, gradient_joints + block);
  }
#endif
}

// All contacts and joints step from y.
kernel void gradient_step(const StepParams params, global const BlockBodies* block_bodies,
                          global const BlockRows* block_rows, global const ContactBlock* contact_blocks,
                          global const SlideBlock* slide_blocks, global const BodyCopyBlock* body_copy_blocks,
                          global const Contact* contacts, global const JointLanes* joint_lanes,
                          global const JointBlock* joint_blocks, global const JointSideSlots* joint_side_slots,
                          global const BodyInfo* body_infos, global const Motion* motions,
                          global ImpulseBlock* impulse_blocks, global JointImpulseBlock* joint_impulses,
                          global GradientRow* gradient_rows, global GradientJoints* gradient_joints,
                          global Velocity* pair_sides, global Velocity* joint_sides, global Descent* descents,
                          global const u32* counters) {
  if (SWEEP_SKIPPED(counters)) return;
#if FEATURE_CONTACTS
  FOR_EACH(item, gradient_blocks(counters) * ITEMS_PER_BLOCK) {
    const u32 block = item / ITEMS_PER_BLOCK, first = item % ITEMS_PER_BLOCK * LANES;
    gradient_step_pairs(first, block_bodies + block, block_rows[block], contact_blocks, slide_blocks,
                        body_copy_blocks + block, contacts, motions, impulse_blocks, gradient_rows, pair_sides,
                        descents);
  }
#endif
#if FEATURE_JOINTS
  FOR_EACH(item, params.joint_blocks * ITEMS_PER_BLOCK) {
    const u32 block = item / ITEMS_PER_BLOCK, first = item % ITEMS_PER_BLOCK * LANES;
    gradient_step_joints(first, params.bodies, joint_lanes + block, joint_blocks + block, joint_side_slots + block,
                         body_infos, motions, joint_impulses + block, gradient_joints + block, joint_sides, descents);
  }
#endif
}

// What all sides give each body, and how that moves it. The fourth and the eighth real of a contribution are those of
// the sums.
kernel void gradient_move(const StepParams params, global const u32* body_copy_starts,
                          global const u32* joint_side_starts, global const BodyInfo* body_infos,
                          global const Motion* motions, global const Velocity* pair_sides,
                          global const Velocity* joint_sides, global const Descent* descents,
                          global GradientBody* gradient_bodies, global const u32* counters) {
  if (SWEEP_SKIPPED(counters)) return;
  FOR_EACH(i, params.bodies) {
    const BodyInfo about = body_infos[i];
    global GradientBody* body = gradient_bodies + i;
    const DescentSums none = {(real)0, (real)0, (real)0, (real)0};
    body->sums = none;
    if (about.kind != BODY_DYNAMIC || descents[about.world].settled != 0u) continue;
    Real8 sum = (Real8)(real)0;
#if FEATURE_CONTACTS
    for (u32 k = body_copy_starts[i]; k < body_copy_starts[i + 1u]; ++k)
      sum = sum + ((global const Real8*)pair_sides)[k];
#endif
#if FEATURE_JOINTS
    for (u32 k = joint_side_starts[i]; k < joint_side_starts[i + 1u]; ++k)
      sum = sum + ((global const Real8*)joint_sides)[k];
#endif
    const Motion motion = motions[i];
    const Vec3 impulse = make3(sum.s0, sum.s1, sum.s2), moment = make3(sum.s4, sum.s5, sum.s6);
    const Vec3 dv = scale3(motion.inverse_mass, impulse), dw = apply_inverse_inertia(motion, moment);
    body->ahead = make_velocity(add3(vec3(motion.v), dv), add3(vec3(motion.w), dw));
    const DescentSums sums = {sum.s3, sum.s7, dot3(impulse, dv) + dot3(moment, dw), (real)0};
    body->sums = sums;
  }
}

// One work-group: each world judges its step.
kernel void gradient_decide(const StepParams params, global const WorldRange* world_ranges,
                            global const GradientLaw* gradient_laws, global GradientBody* gradient_bodies,
                            global Descent* descents, global u32* counters) {
  const bool is_skipped = SWEEP_SKIPPED(counters);
  const bool alone = params.worlds == 1u;  // or there are many, and each is summed by an item
  descent_sum_together(is_skipped || !alone ? 0u : params.bodies, gradient_bodies);
#if FEATURE_TOLERANCE
  barrier(CLK_GLOBAL_MEM_FENCE);
  if (!is_skipped && get_local_id(0) == 0) {
    counters[COUNTER_SWEEPS] += 1u;
    counters[COUNTER_SETTLED] = 1u;
  }
  barrier(CLK_GLOBAL_MEM_FENCE);
#endif
  for (u32 w = (u32)get_local_id(0); w < (is_skipped ? 0u : params.worlds); w += (u32)get_local_size(0)) {
    global Descent* world = descents + w;
    if (world->settled != 0u) continue;
    const u32 first = world_ranges[w].first_body, count = world_ranges[w].body_count;
    if (!alone) descent_sum_alone(count, gradient_bodies + first);
    DescentSums sums = {(real)0, (real)0, (real)0, (real)0};
    if (count > 0u) sums = gradient_bodies[first].sums;
    descent_decide(sums, gradient_laws[0].accelerated != 0u, params.tolerance, world);
#if FEATURE_TOLERANCE
    if (world->settled == 0u) atomic_and(&counters[COUNTER_SETTLED], 0u);
#endif
  }
}

// Where the step was good bodies take it, and run ahead of it.
kernel void gradient_take(const StepParams params, global const BodyInfo* body_infos, global const Descent* descents,
                          global Motion* motions, global GradientBody* gradient_bodies, global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(i, params.bodies) {
    const BodyInfo about = body_infos[i];
    if (about.kind != BODY_DYNAMIC || descents[about.world].moved == 0u) continue;
    const real beta = descents[about.world].beta;
    global GradientBody* body = gradient_bodies + i;
    for (u32 k = 0u; k < 3u; ++k) {
      const real v = body->ahead.v[k], w = body->ahead.w[k];
      motions[i].v[k] = v + beta * (v - body->at.v[k]);
      motions[i].w[k] = w + beta * (w - body->at.w[k]);
      body->at.v[k] = v;
      body->at.w[k] = w;
    }
  }
}

// Impulses and bodies at r, which the last step that was good led to.
kernel void gradient_finish(const StepParams params, global const BlockBodies* block_bodies,
                            global const BlockRows* block_rows, global const Contact* contacts,
                            global const JointLanes* joint_lanes, global const BodyInfo* body_infos,
                            global const GradientRow* gradient_rows, global const GradientJoints* gradient_joints,
                            global const GradientBody* gradient_bodies, global const Descent* descents,
                            global ImpulseBlock* impulse_blocks, global JointImpulseBlock* joint_impulses,
                            global Motion* motions, global u32* counters) {
  if (STEP_ABORTED(counters)) return;
#if FEATURE_TOLERANCE
  if (get_global_id(0) == 0) {
    counters[COUNTER_UNSOLVED] += counters[COUNTER_SETTLED] != 0u ? 0u : 1u;
    counters[COUNTER_SETTLED] = 0u;
  }
#endif
#if FEATURE_CONTACTS
  FOR_EACH(item, gradient_blocks(counters) * ITEMS_PER_BLOCK) {
    const u32 block = item / ITEMS_PER_BLOCK, first = item % ITEMS_PER_BLOCK * LANES;
    gradient_finish_pairs(first, block_bodies + block, block_rows[block], contacts, gradient_rows, descents,
                          impulse_blocks);
  }
#endif
#if FEATURE_JOINTS
  FOR_EACH(item, params.joint_blocks * ITEMS_PER_BLOCK) {
    const u32 block = item / ITEMS_PER_BLOCK, first = item % ITEMS_PER_BLOCK * LANES;
    gradient_finish_joints(first, params.bodies, joint_lanes + block, body_infos, gradient_joints + block, descents,
                           joint_impulses + block);
  }
#endif
  FOR_EACH(i, params.bodies) {
    if (body_infos[i].kind != BODY_DYNAMIC) continue;
    for (u32 k = 0u; k < 3u; ++k) {
      motions[i].v[k] = gradient_bodies[i].at.v[k];
      motions[i].w[k] = gradient_bodies[i].at.w[k];
    }
  }
}

// One work-group: all of it.
kernel void solve_gradient_group(const StepParams params, global const BlockBodies* block_bodies,
                                 global const BlockRows* block_rows, global const ContactBlock* contact_blocks,
                                 global const SlideBlock* slide_blocks, global const u32* body_copy_starts,
                                 global const BodyCopyBlock* body_copy_blocks, global const Contact* contacts,
                                 global const JointLanes* joint_lanes, global const JointBlock* joint_blocks,
                                 global const JointSideSlots* joint_side_slots, global const u32* joint_side_starts,
                                 global const BodyInfo* body_infos, global const WorldRange* world_ranges,
                                 global const GradientLaw* gradient_laws, global ImpulseBlock* impulse_blocks,
                                 global JointImpulseBlock* joint_impulses, global Motion* motions,
                                 global GradientRow* gradient_rows, global GradientJoints* gradient_joints,
                                 global GradientBody* gradient_bodies, global Velocity* pair_sides,
                                 global Velocity* joint_sides, global Descent* descents, global u32* counters) {
  gradient_begin(params, block_bodies, block_rows, contact_blocks, impulse_blocks, body_copy_starts, body_copy_blocks,
                 joint_lanes, joint_impulses, joint_side_starts, body_infos, motions, gradient_rows, gradient_joints,
                 gradient_bodies, descents, counters);
  barrier(CLK_GLOBAL_MEM_FENCE);
  u32 iteration = 0u;
  do {
    gradient_step(params, block_bodies, block_rows, contact_blocks, slide_blocks, body_copy_blocks, contacts,
                  joint_lanes, joint_blocks, joint_side_slots, body_infos, motions, impulse_blocks, joint_impulses,
                  gradient_rows, gradient_joints, pair_sides, joint_sides, descents, counters);
    barrier(CLK_GLOBAL_MEM_FENCE);
    gradient_move(params, body_copy_starts, joint_side_starts, body_infos, motions, pair_sides, joint_sides, descents,
                  gradient_bodies, counters);
    barrier(CLK_GLOBAL_MEM_FENCE);
    gradient_decide(params, world_ranges, gradient_laws, gradient_bodies, descents, counters);
    barrier(CLK_GLOBAL_MEM_FENCE);
    gradient_take(params, body_infos, descents, motions, gradient_bodies, counters);
    barrier(CLK_GLOBAL_MEM_FENCE);
#if FEATURE_TOLERANCE
    const bool settled = SWEEP_SKIPPED(counters);
    barrier(CLK_GLOBAL_MEM_FENCE);
    if (settled) break;
#endif
  } while (++iteration < params.iterations);
  gradient_finish(params, block_bodies, block_rows, contacts, joint_lanes, body_infos, gradient_rows, gradient_joints,
                  gradient_bodies, descents, impulse_blocks, joint_impulses, motions, counters);
}
