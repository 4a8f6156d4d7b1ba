#pragma OPENCL FP_CONTRACT OFF
// Moves the bodies of each joint back to where it is whole (cpu_reference/close_joints.hpp states the method).
#include "articulations/close_links.h"
#include "common.h"
#include "joints/current_joint.h"
#include "joints/displace.h"
#include "joints/factor.h"
#include "joints/mobility.h"
#include "joints/revolutions.h"
#include "sleep.h"
#include "types.h"

static inline real closing_displacement_into_limits(const Joint joint, bool counted, real expected, real x) {
  if (joint.limited == (real)0 || joint.spring_compliance > (real)0) return (real)0;
  const real most = expected + (real)JOINT_CLOSING_ANGLE, least = expected - (real)JOINT_CLOSING_ANGLE;
  const real low = counted && joint.low > most ? most : joint.low;
  const real high = counted && joint.high < least ? least : joint.high;
  return x < low ? low - x : (x > high ? high - x : (real)0);
}

static inline void close_joint(const StepParams* params, const JointInfo info, const Joint joint, JointSizes sizes,
                               global const real* joint_angles, u32 index, MovedBodies to) {
  if (joint.spring > (real)0) return;
  Vec3 x_a, x_b;
  Quat q_a, q_b;
  joint_pose(info.body_a, params->bodies, to.positions, to.orientations, &x_a, &q_a);
  joint_pose(info.body_b, params->bodies, to.positions, to.orientations, &x_b, &q_b);
  const Motion a = to.motions[info.body_a], b = to.motions[info.body_b];
  CurrentJoint current = current_joint(joint, info.locked, info.free, sizes, x_a, q_a, x_b, q_b);
  count_revolutions(info, joint_angles, index, params->dt, a, b, &current);
  real k[JOINT_ROWS][JOINT_ROWS], column[JOINT_ROWS], free_mobility;
  joint_mobility(&current, info.free == FREE_ANGLE, a, b, k, column, &free_mobility);
  JointFactor factor;
  factorise(k, info.locked, &factor);

  const bool is_free = info.free != FREE_NOTHING;
  real d[JOINT_ROWS], coupling[JOINT_ROWS], response[JOINT_ROWS];
  for (u32 i = 0u; i < JOINT_ROWS; ++i) {
    const bool locked = (info.locked >> i & 1u) != 0u;
    d[i] = locked ? -current.error[i] : (real)0;
    coupling[i] = locked && is_free ? column[i] : (real)0;
    response[i] = coupling[i];
  }
  solve_factor(&factor, d);
  solve_factor(&factor, response);
  real x = current.coordinate, coupled_mobility = (real)0;
  for (u32 i = 0u; i < JOINT_ROWS; ++i) {
    x = x + coupling[i] * d[i];
    coupled_mobility = coupled_mobility + coupling[i] * response[i];
  }
  const real e = is_free ? free_mobility - coupled_mobility : (real)0;
  const bool counted = counts_revolutions(info);
  const real expected = counted ? current.expected : (real)0;
  const real d_free = e > (real)0 ? closing_displacement_into_limits(joint, counted, expected, x) / e : (real)0;
  for (u32 i = 0u; i < JOINT_ROWS; ++i) d[i] = d[i] - response[i] * d_free;

  const bool angular = info.free == FREE_ANGLE;
  Vec3 impulse =
      add3(add3(scale3(d[0], current.axes[0]), scale3(d[1], current.axes[1])), scale3(d[2], current.axes[2]));
  const real about_z = current.lead != (real)0 ? -(current.lead * d[2]) : d[5];
  Vec3 moment =
      add3(add3(scale3(d[3], current.axes[0]), scale3(d[4], current.axes[1])), scale3(about_z, current.axes[2]));
  impulse = add3(impulse, scale3(angular ? (real)0 : d_free, current.free_axis));
  moment = add3(moment, scale3(angular ? d_free : (real)0, current.free_axis));
  displace(params, info.body_a, a, x_a, q_a, scale3((real)-1, impulse),
           scale3((real)-1, add3(cross3(current.arm_a, impulse), moment)), to);
  displace(params, info.body_b, b, x_b, q_b, impulse, add3(cross3(current.arm_b, impulse), moment), to);
}

// One phase: blocks begin .. end - 1, whose joints share no movable body.
kernel void close_joint_phase(const StepParams params, const u32 begin, const u32 end,
                              global const JointLanes* joint_lanes, global const JointInfo* joint_infos,
                              global const Joint* joints, global const real* screw_leads,
                              global const real* rolling_radii, global const real* joint_angles,
                              global const BodyInfo* body_infos, global const Sleeper* sleepers, global Vec4* positions,
                              global Vec4* orientations, global Motion* motions, global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  const MovedBodies to = MOVED_BODIES;
  FOR_EACH(slot, (end - begin) * PACK) {
    const u32 index = joint_lanes[begin + slot / PACK].joint[slot % PACK];
    if (index == NONE || joint_sleeps(joint_infos[index], params.bodies, sleepers)) continue;
    close_joint(&params, joint_infos[index], joints[index], joint_sizes(screw_leads, rolling_radii, index),
                joint_angles, index, to);
  }
}

#if FEATURE_ARTICULATIONS
#define SWEEPS_OF_TAIL(params) 1u  // articulations take turns with the sweeps
#else
#define SWEEPS_OF_TAIL(params) (params).position_sweeps
#endif

// One work-group: the phases from `first_phase` on; where those are all, every sweep.
kernel void close_joint_tail(const StepParams params, const u32 first_phase, const u32 phases,
                             global const u32* joint_phases, global const JointLanes* joint_lanes,
                             global const JointInfo* joint_infos, global const Joint* joints,
                             global const real* screw_leads, global const real* rolling_radii,
                             global const real* joint_angles, global const BodyInfo* body_infos,
                             global const Sleeper* sleepers, global Vec4* positions, global Vec4* orientations,
                             global Motion* motions, global u32* counters) {
  const MovedBodies to = MOVED_BODIES;
  const u32 sweeps = first_phase == 0u ? SWEEPS_OF_TAIL(params) : 1u, count = phases - first_phase;
  const u32 runs = STEP_ABORTED(counters) ? 0u : sweeps * count;
  u32 run = 0u;
  do {
    const u32 phase = first_phase + run % count;
    const u32 begin = joint_phases[phase], end = run < runs ? joint_phases[phase + 1u] : begin;
    FOR_EACH_OF_TEAM(slot, 0u, (end - begin) * PACK) {
      const u32 index = joint_lanes[begin + slot / PACK].joint[slot % PACK];
      if (index == NONE || joint_sleeps(joint_infos[index], params.bodies, sleepers)) continue;
      close_joint(&params, joint_infos[index], joints[index], joint_sizes(screw_leads, rolling_radii, index),
                  joint_angles, index, to);
    }
    TEAM_BARRIER(counters);
  } while (++run < runs);
}

#if FEATURE_ARTICULATIONS
// A work-group has an articulation for itself, and every n-th behind it: `sweeps` steps of Newton's method.
kernel void close_articulations(
    const StepParams params, const u32 articulation_count, const u32 sweeps, global const Articulation* articulations,
    global const LinkInfo* links, global const u32* link_levels, global const JointInfo* joint_infos,
    global const Joint* joints, global const real* screw_leads, global const real* rolling_radii,
    global const real* joint_angles, global const BodyInfo* body_infos, global const Sleeper* sleepers,
    global LinkFactor* link_factors, global LinkMotion* link_motions, global const ClosureSet* closure_sets,
    global const ClosureInfo* closures, global LinkFactor* closure_factors, global real* closure_matrix,
    global real* closure_wanted, global LinkMotion* closure_columns, global u32* articulation_angles,
    global Vec4* positions, global Vec4* orientations, global Motion* motions, global u32* counters) {
  const MovedBodies to = MOVED_BODIES;
  const CurrentJoints current = CURRENT_JOINTS;
  const Closures all = CLOSURES;
  u32 tree = (u32)get_group_id(0);
  do {
    const bool is_there =
        tree < articulation_count && !STEP_ABORTED(counters) && !is_asleep(sleepers, articulations[tree].root);
    const u32 first = is_there ? articulations[tree].first_level : 0u;
    const u32 levels = is_there ? articulations[tree].level_count : 0u;
    const u32 begin = link_levels[first], end = link_levels[first + levels];
    const ClosureSet loops = closures_of(tree, is_there, &all);
    u32 sweep = 0u;
    do {
      if (is_there && get_local_id(0) == 0) articulation_angles[tree] = 0u;
      u32 step = 0u;
      do {  // from the leaves to the root
        const LinkRange at = links_up(first, levels, step, link_levels);
        for (u32 i = at.begin + (u32)get_local_id(0); i < at.end; i += (u32)get_local_size(0))
          factor_current_link(i, &current, links, motions, link_factors);
        barrier(CLK_GLOBAL_MEM_FENCE);
      } while (++step < levels);
#if FEATURE_CLOSURES
      const LinkTree all_links = LINK_TREE(first, levels);
      factor_current_closures(loops, &all, &current, &all_links, closure_columns);
#endif
      clear_pushes(loops, &all, link_motions);
      const u32 passes = loops.count > 0u ? 2u : 1u;
      u32 pass = 0u;
      do {
        step = 0u;
        do {
          const LinkRange at = links_up(first, levels, step, link_levels);
          for (u32 i = at.begin + (u32)get_local_id(0); i < at.end; i += (u32)get_local_size(0))
            backward_pass_of_errors(i, links, link_factors, link_motions);
          barrier(CLK_GLOBAL_MEM_FENCE);
        } while (++step < levels);
        step = 0u;
        do {
          const LinkRange at = links_down(first, levels, step, link_levels);
          for (u32 i = at.begin + (u32)get_local_id(0); i < at.end; i += (u32)get_local_size(0)) {
            real d[LINK_ROWS];
            forward_pass(i, links[i], link_factors, link_motions, d);
          }
          barrier(CLK_GLOBAL_MEM_FENCE);
        } while (++step < levels);
#if FEATURE_CLOSURES
        solve_current_loops(pass + 1u == passes ? no_closures() : loops, &all, link_motions);
#endif
      } while (++pass < passes);
      for (u32 i = begin + (u32)get_local_id(0); i < end; i += (u32)get_local_size(0)) {
        const float angle = (float)length3(read_twist(link_motions[i].change).angular);
        atomic_max(&articulation_angles[tree], as_uint(angle));
      }
      barrier(CLK_GLOBAL_MEM_FENCE);
      const real most = (real)0.1, largest = is_there ? (real)as_float(articulation_angles[tree]) : (real)0;
      const real share = largest > most ? most / largest : (real)1;
      for (u32 i = begin + (u32)get_local_id(0); i < end; i += (u32)get_local_size(0)) {
        const u32 body = links[i].body;
        const Twist push = push_on_link(i, links[i], link_factors, link_motions);
        displace(&params, body, motions[body], vec3_of(positions[body]), quat(orientations[body]),
                 scale3(share, push.linear), scale3(share, push.angular), to);
      }
      barrier(CLK_GLOBAL_MEM_FENCE);
    } while (++sweep < sweeps);
    tree += (u32)get_num_groups(0);
  } while (tree < articulation_count);
}
#endif
