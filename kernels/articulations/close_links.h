// Closes the joints of articulations by the poses of their bodies. cpu_reference/articulations/close_links.hpp is the
// twin.
#ifndef LOCKSTEP_ARTICULATION_CLOSE_LINKS_H
#define LOCKSTEP_ARTICULATION_CLOSE_LINKS_H

#include "articulations/solve_links.h"
#include "joints/current_joint.h"
#include "joints/displace.h"
#include "joints/revolutions.h"

// The joint of a link at the present poses: the rows that are closed.
static inline u32 write_current_link_joint(LinkInfo link, JointInfo info, const Joint joint, CurrentJoint current,
                                           global LinkFactor* f) {
  const bool rod = info.free != FREE_NOTHING && joint.limited != (real)0 && joint.low == joint.high &&
                   !(joint.spring_compliance > (real)0);
  const real sign = link.is_b != 0u ? (real)1 : (real)-1;
  set_link_joint(link, info.free == FREE_ANGLE, current.axes, current.arm_a, current.arm_b, current.free_axis,
                 current.lead, f);
  f->spring_compliance = (real)0;
  for (u32 i = 0u; i < JOINT_ROWS; ++i) f->error[i] = (info.locked >> i & 1u) != 0u ? sign * current.error[i] : (real)0;
  f->error[JOINT_ROWS] = rod ? sign * (current.coordinate - joint.low) : (real)0;
  return info.locked | (rod ? 1u << JOINT_ROWS : 0u);
}

// All that is measured anew.
typedef struct CurrentJoints {
  u32 bodies;
  real dt;
  global const JointInfo* infos;
  global const Joint* joints;
  global const real* screw_leads;
  global const real* rolling_radii;
  global const real* joint_angles;
  global const Motion* motions;
  global const Vec4* positions;
  global const Vec4* orientations;
} CurrentJoints;

// Of the parameters of a kernel.
#define CURRENT_JOINTS                                                                                           \
  {                                                                                                              \
    params.bodies, params.dt, joint_infos, joints, screw_leads, rolling_radii, joint_angles, motions, positions, \
        orientations                                                                                             \
  }

static inline u32 write_current_joint(LinkInfo link, const CurrentJoints* s, global LinkFactor* f) {
  const JointInfo info = s->infos[link.joint];
  Vec3 x_a, x_b;
  Quat q_a, q_b;
  joint_pose(info.body_a, s->bodies, s->positions, s->orientations, &x_a, &q_a);
  joint_pose(info.body_b, s->bodies, s->positions, s->orientations, &x_b, &q_b);
  CurrentJoint current = current_joint(s->joints[link.joint], info.locked, info.free,
                                       joint_sizes(s->screw_leads, s->rolling_radii, link.joint), x_a, q_a, x_b, q_b);
  count_revolutions(info, s->joint_angles, link.joint, s->dt, s->motions[info.body_a], s->motions[info.body_b],
                    &current);
  return write_current_link_joint(link, info, s->joints[link.joint], current, f);
}

static inline void factor_current_link(u32 index, const CurrentJoints* s, global const LinkInfo* links,
                                       global const Motion* motions, global LinkFactor* link_factors) {
  const LinkInfo link = links[index];
  global LinkFactor* f = link_factors + index;
  // one that floats has no rows, since it was factorised first
  const u32 rows = link.joint == NONE ? 0u : write_current_joint(link, s, f);
  factorise_link(link, rows, motions[link.body], link_factors, f);
}

static inline void backward_pass_of_errors(u32 index, global const LinkInfo* links,
                                           global const LinkFactor* link_factors, global LinkMotion* link_motions) {
  real off[LINK_ROWS];
  for (u32 i = 0u; i < LINK_ROWS; ++i) off[i] = link_factors[index].error[i];
  backward_pass(index, links[index], off, link_factors, link_motions);
}

#if FEATURE_CLOSURES
// A group: the closures of a tree whose links have their factors.
static inline void factor_current_closures(ClosureSet loops, const Closures* all, const CurrentJoints* s,
                                           const LinkTree* tree, global LinkMotion* closure_columns) {
  for (u32 k = loops.first + (u32)get_local_id(0); k < loops.first + loops.count; k += (u32)get_local_size(0))
    mark_rows(write_current_joint(as_link(all->closures[k], s->infos), s, all->factors + k), all->factors + k);
  barrier(CLK_GLOBAL_MEM_FENCE);
  factor_closures(loops, all, tree, closure_columns);
}

// A group: what they push with, once the tree has answered what is off in it.
static inline void solve_current_loops(ClosureSet loops, const Closures* all, global LinkMotion* link_motions) {
  for (u32 k = loops.first + (u32)get_local_id(0); k < loops.first + loops.count; k += (u32)get_local_size(0)) {
    real off[LINK_ROWS];
    for (u32 i = 0u; i < LINK_ROWS; ++i) off[i] = all->factors[k].error[i];
    want_closed(k, off, all, link_motions);
  }
  barrier(CLK_GLOBAL_MEM_FENCE);
  solve_closures(loops, all, link_motions);
}
#endif

#endif
