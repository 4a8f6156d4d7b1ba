#pragma OPENCL FP_CONTRACT OFF
// Moves the bodies of contacts that overlap apart (cpu_reference/separate_contacts.hpp states the method).
#include "common.h"
#include "joints/displace.h"
#include "lane_current_contact.h"
#include "lane_tolerances.h"
#include "sweep_contacts.h"
#include "types.h"

#define SEPARATION_PASSES 2u

// All that a pair reads and writes.
typedef struct SeparationStream {
  global const BlockBodies* bodies;
  global const BlockRows* rows;
  global const PointBlock* points;
  global const ContactBlock* contacts;
  global const Motion* motions;
  global Vec4* positions;
  global Vec4* orientations;
  global u32* counters;
} SeparationStream;

// Of the parameters of a kernel, which are called as the buffers are.
#define SEPARATION_STREAM \
  { block_bodies, block_rows, point_blocks, contact_blocks, motions, positions, orientations, counters }

// The bodies as displacements are solved on them: v and w are how far they move, m and rad.
static inline LaneBody separate_at_rest(LaneBody body) {
  body.v = body.w = lane_make3((lane)0, (lane)0, (lane)0);
  return body;
}

// How far points are to move apart, m; less than 0: how far they may come closer.
static inline lane separate_wanted(const StepParams* p, lane gap, lane inner_radius, lane bounding_radius) {
  const lane depth = -gap - lane_pair_slop(p, inner_radius, bounding_radius);
  const lane most = lane_pair_correction_limit(p, bounding_radius) * (lane)p->dt;
  const lane share = (lane)p->separation * depth;
  return depth > (lane)0 ? (share < most ? share : most) : depth;
}

// What of it is left to do for points that overlap and part at this speed, m/s.
static inline lane separate_beyond_parting(const StepParams* p, lane wanted, lane speed) {
  return ((wanted > (lane)0) & (speed > (lane)0)) ? wanted - (lane)p->dt * speed : wanted;
}

// Moves the bodies of the lanes in `moved` that can move.
static inline void separate_store(lane_mask moved, global const u32* bodies, const LanePose* pose, const LaneBody* by,
                                  const SeparationStream* s) {
  const LaneQuat q = lane_correct_orientation(pose->orientation, by->w);
  const Lane3 x = lane_add3(pose->position, by->v);
  const u32 movable = LANE_BITS(moved & (by->inverse_mass > (lane)0));
  const LaneQuad moved_x = {x.x, x.y, x.z, x.x}, moved_q = {q.x, q.y, q.z, q.w};
  real xs[4 * LANES], qs[4 * LANES];
  lane_keep_quad(moved_x, xs);
  lane_keep_quad(moved_q, qs);
  for (u32 k = 0u; k < LANES; ++k) {
    if ((movable >> k & 1u) == 0u) continue;
    const Real4 new_x = lane_kept_quad(xs, k), new_q = lane_kept_quad(qs, k);
    store_displaced(bodies[k], make3(new_x.s0, new_x.s1, new_x.s2), make4(new_q.s0, new_q.s1, new_q.s2, new_q.s3),
                    s->positions, s->orientations, s->counters);
  }
}

// The pairs in lanes first .. first + LANES - 1 of a block.
static inline void separate_pairs(const StepParams* params, u32 block, u32 first, const SeparationStream* s) {
  global const BlockBodies* bodies = s->bodies + block;
  const BlockRows rows = s->rows[block];
  if (bodies->count[first] == 0u) return;  // padding alone
  const lane_u32 count = LANE_LOAD_U32(bodies->count + first);
  const LanePose pose_a = lane_load_poses(bodies->body_a + first, params->bodies, s->positions, s->orientations);
  const LanePose pose_b = lane_load_poses(bodies->body_b + first, params->bodies, s->positions, s->orientations);
  lane wanted[MANIFOLD_POINTS], d[MANIFOLD_POINTS];
  lane_mask overlaps = (lane)0 > (lane)0;
  for (u32 k = 0u; k < rows.count; ++k) {
    global const PointBlock* points = s->points + rows.first + k;
    LaneCurrentContact current;
    lane_current_contact(first, points, &pose_a, &pose_b, &current);
    wanted[k] = separate_wanted(params, current.gap, LANE_LOAD(points->inner_radius + first),
                                LANE_LOAD(points->bounding_radius + first));
    d[k] = (lane)0;
    overlaps = overlaps | (LANE_MASK(count > (lane_u32)k) & (wanted[k] > (lane)0));
  }
  if (!LANE_ANY(overlaps)) return;
  const lane_mask general = lane_general(bodies, first);
  LaneBody a = lane_load_bodies(s->motions, bodies->body_a + first);
  LaneBody b = lane_load_bodies(s->motions, bodies->body_b + first);
  overlaps = (lane)0 > (lane)0;
  for (u32 k = 0u; k < rows.count; ++k) {
    global const ContactBlock* row = s->contacts + rows.first + k;
    const Lane3 u = lane_velocity_at(LANE_ARM_A(row, first), LANE_ARM_B(row, first), &a, &b);
    wanted[k] = separate_beyond_parting(params, wanted[k], lane_dot3(LANE_NORMAL(row, first), u));
    overlaps = overlaps | (LANE_MASK(count > (lane_u32)k) & (wanted[k] > (lane)0));
  }
  if (!LANE_ANY(overlaps)) return;
  a = separate_at_rest(a);
  b = separate_at_rest(b);
  for (u32 pass = 0u; pass < SEPARATION_PASSES; ++pass) {
    for (u32 k = 0u; k < rows.count; ++k) {
      global const ContactBlock* row = s->contacts + rows.first + k;
      const lane_mask there = LANE_MASK(count > (lane_u32)k);
      const Lane3 normal = LANE_NORMAL(row, first), arm_a = LANE_ARM_A(row, first), arm_b = LANE_ARM_B(row, first);
      const lane moved = lane_dot3(normal, lane_velocity_at(arm_a, arm_b, &a, &b));
      const lane next = d[k] + (wanted[k] - moved) / LANE_LOAD(row->w_nn + first),
                 kept = next > (lane)0 ? next : (lane)0;
      LaneBody next_a = a, next_b = b;
      lane_push_at(arm_a, arm_b, general, lane_scale3(kept - d[k], normal), &next_a, &next_b);
      lane_select_body(there, next_a, &a);
      lane_select_body(there, next_b, &b);
      d[k] = kept;
    }
  }
  separate_store(overlaps, bodies->body_a + first, &pose_a, &a, s);
  separate_store(overlaps, bodies->body_b + first, &pose_b, &b, s);
}

// One colour.
kernel void separate_color(const StepParams params, const u32 color, global const u32* color_starts,
                           global const BlockBodies* block_bodies, global const BlockRows* block_rows,
                           global const PointBlock* point_blocks, global const ContactBlock* contact_blocks,
                           global const Motion* motions, global Vec4* positions, global Vec4* orientations,
                           global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  const SeparationStream stream = SEPARATION_STREAM;
  const u32 begin = color_starts[color], items = (color_starts[color + 1u] - begin) * ITEMS_PER_BLOCK;
  FOR_EACH(item, items)
  separate_pairs(&params, begin + item / ITEMS_PER_BLOCK, item % ITEMS_PER_BLOCK * LANES, &stream);
}

// One work-group: `sweeps` sweeps over the phases from `first_phase` on.
kernel void separate_tail(const StepParams params, const u32 first_phase, const u32 sweeps,
                          global const u32* color_starts, global const BlockBodies* block_bodies,
                          global const BlockRows* block_rows, global const PointBlock* point_blocks,
                          global const ContactBlock* contact_blocks, global const Motion* motions,
                          global Vec4* positions, global Vec4* orientations, global u32* counters) {
  const SeparationStream stream = SEPARATION_STREAM;
  const u32 phases = contact_phases(counters);
  u32 sweep = 0u;
  do {
    u32 phase = min(first_phase, counters[COUNTER_COLORS]);
    do {
      const bool is_there = phase < phases;
      const u32 begin = is_there ? phase_begin(phase, color_starts, counters) : 0u;
      const u32 items = is_there ? (phase_end(phase, color_starts, counters) - begin) * ITEMS_PER_BLOCK : 0u;
      FOR_EACH_OF_TEAM(item, 0u, items)
      separate_pairs(&params, begin + item / ITEMS_PER_BLOCK, item % ITEMS_PER_BLOCK * LANES, &stream);
      TEAM_BARRIER(counters);
    } while (++phase < phases);
  } while (++sweep < sweeps);
}
