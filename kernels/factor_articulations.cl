#pragma OPENCL FP_CONTRACT OFF
// Factors of the equations of articulations (cpu_reference/factor_articulations.hpp).
#include "articulations/closures.h"
#include "common.h"
#include "sleep.h"
#include "types.h"

static inline Vec3 link_vector(global const real (*field)[PACK], u32 at) {
  return make3(field[0][at], field[1][at], field[2][at]);
}

// The joint of a link, as prepare_joints wrote it: the rows that the articulation solves.
static inline u32 write_link_joint(LinkInfo link, JointInfo info, global const JointBlock* block,
                                   global LinkFactor* f) {
  const u32 at = link.slot % PACK;
  const real sign = link.is_b != 0u ? (real)1 : (real)-1;
  const bool driven = block->motor_impulse[at] != (real)0, fixed = block->slowest[at] == block->fastest[at] && !driven;
  bool impedance = false;
#if FEATURE_JOINT_IMPEDANCES
  impedance = !fixed && block->impedance_compliance[at] > (real)0;
#endif
  const u32 rows = info.locked | (info.free != FREE_NOTHING && (fixed || impedance) ? 1u << JOINT_ROWS : 0u);
  Vec3 axes[3];
  for (u32 i = 0u; i < 3u; ++i) axes[i] = link_vector(block->axes + 3u * i, at);
  set_link_joint(link, info.free == FREE_ANGLE, axes, link_vector(block->arm_a, at), link_vector(block->arm_b, at),
                 link_vector(block->free_axis, at), block->lead[at], f);
  f->impedance = impedance ? (real)1 : (real)0;
  f->spring_compliance = impedance ? block->impedance_compliance[at] : block->spring_compliance[at];
  for (u32 i = 0u; i < JOINT_ROWS; ++i) f->error[i] = sign * (block->bias[i][at] + block->velocity_product[i][at]);
  f->error[JOINT_ROWS] = -(sign * (impedance ? block->impedance_speed[at] : block->slowest[at]));
  return rows;
}

static inline void clear_factor(global LinkFactor* f) {
  global real* values = (global real*)f;
  for (u32 i = 0u; i < sizeof(LinkFactor) / sizeof(real); ++i) values[i] = (real)0;
}

static inline void clear_motion(global LinkMotion* m) {
  global real* values = (global real*)m;
  for (u32 i = 0u; i < sizeof(LinkMotion) / sizeof(real); ++i) values[i] = (real)0;
}

#if FEATURE_CLOSURES
static inline void write_closures(ClosureSet loops, bool asleep, const Closures* s, global const JointInfo* joint_infos,
                                  global const JointBlock* joint_blocks) {
  const u32 id = (u32)get_local_id(0), size = (u32)get_local_size(0);
  for (u32 k = loops.first + id; k < loops.first + loops.count; k += size) {
    global LinkFactor* f = s->factors + k;
    clear_factor(f);
    if (asleep) continue;
    const LinkInfo link = as_link(s->closures[k], joint_infos);
    mark_rows(write_link_joint(link, joint_infos[link.joint], joint_blocks + link.slot / PACK, f), f);
  }
  const u32 begin = loops.first * LINK_ROWS, end = begin + loops.count * LINK_ROWS;
  for (u32 row = begin + id; row < end; row += size) {
    s->wanted[row] = (real)0;
    for (u32 i = 0u; i < CLOSURE_STRIDE; ++i) s->matrix[CLOSURE_ENTRY(row, i)] = (real)0;
  }
  barrier(CLK_GLOBAL_MEM_FENCE);
}
#endif

// A work-group has an articulation for itself, and every n-th behind it.
kernel void factor_articulations(const u32 articulation_count, global const Articulation* articulations,
                                 global const LinkInfo* links, global const u32* link_levels,
                                 global const JointInfo* joint_infos, global const JointBlock* joint_blocks,
                                 global const Sleeper* sleepers, global const Motion* motions,
                                 global LinkFactor* link_factors, global LinkMotion* link_motions,
                                 global const ClosureSet* closure_sets, global const ClosureInfo* closures,
                                 global LinkFactor* closure_factors, global real* closure_matrix,
                                 global real* closure_wanted, global LinkMotion* closure_columns,
                                 global const u32* counters) {
#if FEATURE_CLOSURES
  const Closures all = CLOSURES;
#endif
  u32 tree = (u32)get_group_id(0);
  do {
    const bool is_there = tree < articulation_count && !STEP_ABORTED(counters);
    const bool asleep = is_there && is_asleep(sleepers, articulations[tree].root);
    const u32 first = is_there ? articulations[tree].first_level : 0u;
    const u32 levels = is_there ? articulations[tree].level_count : 0u;
    u32 step = 0u;
    do {  // from the leaves to the root
      const LinkRange at = links_up(first, levels, step, link_levels);
      for (u32 i = at.begin + (u32)get_local_id(0); i < at.end; i += (u32)get_local_size(0)) {
        const LinkInfo link = links[i];
        global LinkFactor* f = link_factors + i;
        clear_factor(f);
        clear_motion(link_motions + i);
        if (asleep) continue;
        u32 rows = 0u;  // one that floats has none
        if (link.joint != NONE)
          rows = write_link_joint(link, joint_infos[link.joint], joint_blocks + link.slot / PACK, f);
        factorise_link(link, rows, motions[link.body], link_factors, f);
      }
      barrier(CLK_GLOBAL_MEM_FENCE);
    } while (++step < levels);
#if FEATURE_CLOSURES
    const ClosureSet loops = closures_of(tree, is_there, &all);
    write_closures(loops, asleep, &all, joint_infos, joint_blocks);
    const LinkTree all_links = LINK_TREE(first, levels);
    factor_closures(asleep ? no_closures() : loops, &all, &all_links, closure_columns);
#endif
    tree += (u32)get_num_groups(0);
  } while (tree < articulation_count);
}
