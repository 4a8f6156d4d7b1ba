// Motors and limits of joints whose articulation solves the locked rows. cpu_reference/articulations/free_rows.hpp is
// the twin and states the method.
#ifndef LOCKSTEP_ARTICULATION_FREE_ROWS_H
#define LOCKSTEP_ARTICULATION_FREE_ROWS_H

#include "articulations/tree_passes.h"

#define MOST_FREE_ROWS 16u

// What is read of links, their joints and bodies.
typedef struct FreeRows {
  global const LinkInfo* links;
  global const u32* link_levels;
  global const LinkFactor* factors;
  global const JointInfo* joint_infos;
  global const JointImpulseBlock* joint_impulses;
  global const Motion* motions;
} FreeRows;

// Of the parameters of a kernel.
#define FREE_ROWS \
  { links, link_levels, link_factors, joint_infos, joint_impulses, motions }

static inline bool is_to_push(u32 index, const FreeRows* s, global const JointBlock* joint_blocks) {
  const LinkInfo link = s->links[index];
  if (link.joint == NONE) return false;
  global const JointBlock* block = joint_blocks + link.slot / PACK;
  const u32 at = link.slot % PACK;
  const JointInfo info = s->joint_infos[link.joint];
  const real slowest = block->slowest[at], fastest = block->fastest[at];
  if (info.free == FREE_NOTHING || slowest == fastest) return false;
#if FEATURE_JOINT_IMPEDANCES
  if (block->impedance_compliance[at] > (real)0) return false;
#endif
  if (block->motor_impulse[at] > (real)0 || s->joint_impulses[link.slot / PACK].free[at] != (real)0) return true;
  global const LinkFactor* f = s->factors + index;
  const Motion body = s->motions[link.body], other = s->motions[link.is_b != 0u ? info.body_a : info.body_b];
  real rows[LINK_ROWS];
  link_rows(f,
            sub_twist(twist_at(global_vec3(f->arm), make_twist(vec3(body.v), vec3(body.w))),
                      twist_at(global_vec3(f->parent_arm), make_twist(vec3(other.v), vec3(other.w)))),
            rows);
  const real along = link.is_b != 0u ? rows[JOINT_ROWS] : -rows[JOINT_ROWS];
  return along < slowest || along > fastest;
}

// How many of the links below one, and of itself, are to push; a link keeps it until the tree is solved.
static inline void count_free_rows(u32 index, const FreeRows* s, global const JointBlock* joint_blocks,
                                   global LinkMotion* link_motions) {
  const LinkInfo link = s->links[index];
  real count = is_to_push(index, s, joint_blocks) ? (real)1 : (real)0;
  for (u32 child = link.first_child; child < link.first_child + link.child_count; ++child)
    count = count + link_motions[child].force[0];
  link_motions[index].force[0] = count;
}

// A group: what a unit of the free row of a link moves it by, for one of its work-items.
static inline real mobility_in_tree(u32 index, u32 first, u32 levels, const FreeRows* s,
                                    global LinkMotion* link_motions) {
  const LinkInfo pushed = s->links[index];
  global const LinkFactor* f = s->factors + index;
  const Twist effort = row_effort(f, JOINT_ROWS);
  real nothing[LINK_ROWS], d[LINK_ROWS];
  for (u32 i = 0u; i < LINK_ROWS; ++i) nothing[i] = (real)0;
  u32 step = 0u;
  do {
    const LinkRange at = links_up(first, levels, step, s->link_levels);
    for (u32 i = at.begin + (u32)get_local_id(0); i < at.end; i += (u32)get_local_size(0)) {
      Twist push = no_twist();
      if (i == index) push = effort_about(global_vec3(f->arm), effort);
      if (i == pushed.parent) push = sub_twist(no_twist(), effort_about(global_vec3(f->parent_arm), effort));
      backward_pass(i, s->links[i], nothing, push, s->factors, link_motions);
    }
    barrier(CLK_GLOBAL_MEM_FENCE);
  } while (++step < levels);
  step = 0u;
  do {
    const LinkRange at = links_down(first, levels, step, s->link_levels);
    for (u32 i = at.begin + (u32)get_local_id(0); i < at.end; i += (u32)get_local_size(0))
      forward_pass(i, s->links[i], s->factors, link_motions, d);
    barrier(CLK_GLOBAL_MEM_FENCE);
  } while (++step < levels);
  if (get_local_id(0) != 0) return (real)0;
  const Twist parent = pushed.parent != NONE ? read_twist(link_motions[pushed.parent].change) : no_twist();
  link_rows(f,
            sub_twist(twist_at(global_vec3(f->arm), read_twist(link_motions[index].change)),
                      twist_at(global_vec3(f->parent_arm), parent)),
            d);
  return d[JOINT_ROWS];
}

// A group, behind a barrier; one is behind it. All its work-items find the same links to push.
static inline void write_free_rows(u32 first, u32 levels, const FreeRows* s, global LinkMotion* link_motions,
                                   global JointBlock* joint_blocks) {
  const u32 begin = s->link_levels[first], end = s->link_levels[first + levels];
  real count = (real)0;
  if (levels > 0u)
    for (u32 i = begin; i < s->link_levels[first + 1u]; ++i) count = count + link_motions[i].force[0];
  barrier(CLK_GLOBAL_MEM_FENCE);
  if (count > (real)MOST_FREE_ROWS) count = (real)0;
  for (u32 i = begin; count > (real)0 && i < end; ++i) {
    if (!is_to_push(i, s, joint_blocks)) continue;
    const real mobility = count * mobility_in_tree(i, first, levels, s, link_motions);
    if (get_local_id(0) == 0) {
      global JointBlock* block = joint_blocks + s->links[i].slot / PACK;
      const u32 at = s->links[i].slot % PACK;
      if (mobility > (real)0 && !(mobility > block->free_mobility[at] - block->coupled_mobility[at])) {
        block->free_mobility[at] = mobility;
        block->coupled_mobility[at] = (real)0;
      }
    }
    barrier(CLK_GLOBAL_MEM_FENCE);
  }
}

#endif
