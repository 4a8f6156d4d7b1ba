// A step of LANES pairs in contact along the projected gradient. cpu_reference/gradient/gradient_pairs.hpp is the twin.
#ifndef LOCKSTEP_GRADIENT_PAIRS_H
#define LOCKSTEP_GRADIENT_PAIRS_H

#include "gradient/descent.h"
#include "solve_contact.h"

// The nearest point of the cone.
static inline LaneCone lane_project_on_cone(LaneCone r, lane friction) {
  const lane tangent = sqrt(r.tangent_1 * r.tangent_1 + r.tangent_2 * r.tangent_2);
  const lane_mask inside = (r.normal >= (lane)0) & (tangent <= friction * r.normal);
  const lane_mask polar = friction * tangent <= -r.normal;
  const lane normal = (r.normal + friction * tangent) / ((lane)1 + friction * friction);
  const lane share = tangent > (lane)0 ? friction * normal / tangent : (lane)0;
  const LaneCone on_cone = lane_make_cone(normal, share * r.tangent_1, share * r.tangent_2);
  const LaneCone none = lane_make_cone((lane)0, (lane)0, (lane)0);
  return lane_select_cone(inside, r, lane_select_cone(polar, none, on_cone));
}

// How many times more sides a body has with its joints than its pairs in contact alone; 1 where it cannot move.
static inline real joined_share(u32 body, real pairs, global const u32* joint_side_starts) {
#if FEATURE_JOINTS
  if (!(pairs > (real)0)) return (real)1;
  return (real)1 + (real)(joint_side_starts[body + 1u] - joint_side_starts[body]) / pairs;
#else
  return (real)1;
#endif
}

static inline real larger_real(real a, real b) { return a > b ? a : b; }

static inline real contact_metric(global const ContactBlock* block, u32 at, u32 count, real share) {
  const real n1 = fabs(block->w_n1[at]), n2 = fabs(block->w_n2[at]), t12 = fabs(block->w_12[at]);
  const real row_n = block->w_nn[at] + n1 + n2, row_1 = n1 + block->w_11[at] + t12, row_2 = n2 + t12 + block->w_22[at];
  return share * ((real)count * larger_real(row_n, larger_real(row_1, row_2)));
}

// Lane `at` of a block begins from the impulses that it has. One that has no contact in a row stays at zero.
static inline void gradient_begin_pair(u32 at, global const BlockBodies* bodies, BlockRows rows,
                                       global const ContactBlock* contact_blocks,
                                       global const ImpulseBlock* impulse_blocks, global const BodyCopyBlock* copies,
                                       global const u32* joint_side_starts, global GradientRow* gradient_rows) {
  const u32 count = bodies->count[at];
  const real share = larger_real(joined_share(bodies->body_a[at], copies->copies_a[at], joint_side_starts),
                                 joined_share(bodies->body_b[at], copies->copies_b[at], joint_side_starts));
  for (u32 k = 0u; k < rows.count; ++k) {
    global GradientRow* row = gradient_rows + rows.first + k;
    global const ImpulseBlock* r = impulse_blocks + rows.first + k;
    row->metric[at] = k < count ? contact_metric(contact_blocks + rows.first + k, at, count, share) : (real)1;
    row->next.normal[at] = row->y.normal[at] = r->normal[at];
    row->next.tangent_1[at] = row->y.tangent_1[at] = r->tangent_1[at];
    row->next.tangent_2[at] = row->y.tangent_2[at] = r->tangent_2[at];
  }
}

static inline void lane_store_impulse(LaneCone r, global ImpulseBlock* block, u32 first) {
  LANE_STORE(r.normal, block->normal + first);
  LANE_STORE(r.tangent_1, block->tangent_1 + first);
  LANE_STORE(r.tangent_2, block->tangent_2 + first);
}

// The steps of a row of contacts, first those that the last judgement granted, then those from y to next.
static inline void gradient_step_row(u32 first, lane_mask there, LaneDescent world, global const ContactBlock* block,
                                     global const SlideBlock* slides, global ImpulseBlock* impulses,
                                     global GradientRow* row, const LaneBody* a, const LaneBody* b, LaneStep* out) {
  const LaneContact c = lane_contact(block, first);
  const LaneCone old = lane_impulse(impulses, first), old_y = lane_impulse(&row->y, first);
  const LaneCone reached = lane_impulse(&row->next, first);
  const LaneCone r = lane_select_cone(world.moved, reached, old);
  const LaneCone y =
      lane_make_cone(lane_ahead(world.moved, world.beta, reached.normal, old.normal, old_y.normal),
                     lane_ahead(world.moved, world.beta, reached.tangent_1, old.tangent_1, old_y.tangent_1),
                     lane_ahead(world.moved, world.beta, reached.tangent_2, old.tangent_2, old_y.tangent_2));
  const lane friction = LANE_LOAD(block->friction + first), metric = LANE_LOAD(row->metric + first);

  const LaneCone u = lane_biased_velocity(c, LANE_LOAD(block->bias + first), slides, first, a, b);
  const lane s = world.step / metric;
  const LaneCone down =
      lane_make_cone(y.normal - s * u.normal, y.tangent_1 - s * u.tangent_1, y.tangent_2 - s * u.tangent_2);
  const LaneCone projected = lane_project_on_cone(down, friction);
  const LaneCone next = lane_select_cone(there, lane_select_cone(world.settled, reached, projected), y);
  lane_store_impulse(r, impulses, first);
  lane_store_impulse(y, &row->y, first);
  lane_store_impulse(next, &row->next, first);

  const LaneCone d = lane_make_cone(next.normal - y.normal, next.tangent_1 - y.tangent_1, next.tangent_2 - y.tangent_2);
  const Lane3 impulse = lane_add3(lane_add3(lane_scale3(d.normal, c.normal), lane_scale3(d.tangent_1, c.tangent_1)),
                                  lane_scale3(d.tangent_2, c.tangent_2));
  const lane squared = d.normal * d.normal + d.tangent_1 * d.tangent_1 + d.tangent_2 * d.tangent_2;
  const lane along = d.normal * (next.normal - r.normal) + d.tangent_1 * (next.tangent_1 - r.tangent_1) +
                     d.tangent_2 * (next.tangent_2 - r.tangent_2);
  out->impulse_a = lane_add3(out->impulse_a, impulse);
  out->moment_a = lane_add3(out->moment_a, lane_cross3(c.arm_a, impulse));
  out->impulse_b = lane_sub3(out->impulse_b, impulse);
  out->moment_b = lane_sub3(out->moment_b, lane_cross3(c.arm_b, impulse));
  out->length = out->length + metric * squared;
  out->uphill = out->uphill - metric * along;
#if FEATURE_TOLERANCE
  out->change = lane_larger(metric / world.step * (metric / world.step) * squared, out->change);
#endif
}

// The worlds of the pairs in lanes first .. first + LANES - 1 of a block; padding counts as of the first.
static inline void worlds_of_pairs(u32 first, global const BlockBodies* bodies, global const Contact* contacts,
                                   u32* worlds) {
  for (u32 k = 0u; k < LANES; ++k) {
    const u32 contact = bodies->contact[first + k];
    worlds[k] = contact != NONE ? contacts[contact].world : 0u;
  }
}

static inline void gradient_step_pairs(u32 first, global const BlockBodies* bodies, BlockRows rows,
                                       global const ContactBlock* contact_blocks, global const SlideBlock* slide_blocks,
                                       global const BodyCopyBlock* copies, global const Contact* contacts,
                                       global const Motion* motions, global ImpulseBlock* impulse_blocks,
                                       global GradientRow* gradient_rows, global Velocity* pair_sides,
                                       global Descent* descents) {
  u32 worlds[LANES];
  worlds_of_pairs(first, bodies, contacts, worlds);
  const LaneDescent world = lane_descents(worlds, descents);
  const LaneBody a = lane_load_bodies(motions, bodies->body_a + first);
  const LaneBody b = lane_load_bodies(motions, bodies->body_b + first);
  const lane_u32 count = LANE_LOAD_U32(bodies->count + first);
  const Lane3 nothing = lane_make3((lane)0, (lane)0, (lane)0);
  LaneStep lane_step;
  lane_step.impulse_a = lane_step.moment_a = lane_step.impulse_b = lane_step.moment_b = nothing;
  lane_step.length = lane_step.uphill = lane_step.change = (lane)0;
  for (u32 k = 0u; k < rows.count; ++k) {
    gradient_step_row(first, LANE_MASK(count > (lane_u32)k), world, contact_blocks + rows.first + k,
                      slide_blocks + rows.first + k, impulse_blocks + rows.first + k, gradient_rows + rows.first + k,
                      &a, &b, &lane_step);
  }
#if FEATURE_TOLERANCE
  descent_note(world.settled ? (lane)0 : lane_step.change, worlds, descents);
#endif
  lane_store_contributions(lane_step, pair_sides, copies->slot_a + first, copies->slot_b + first);
}

// The impulses that the last good step led to.
static inline void gradient_finish_pairs(u32 first, global const BlockBodies* bodies, BlockRows rows,
                                         global const Contact* contacts, global const GradientRow* gradient_rows,
                                         global const Descent* descents, global ImpulseBlock* impulse_blocks) {
  u32 worlds[LANES], moved[LANES];
  worlds_of_pairs(first, bodies, contacts, worlds);
  for (u32 k = 0u; k < LANES; ++k) moved[k] = descents[worlds[k]].moved;
  const lane_mask takes = LANE_MASK(LANE_LOAD_U32(moved) != (lane_u32)0u);
  for (u32 k = 0u; k < rows.count; ++k) {
    global ImpulseBlock* impulses = impulse_blocks + rows.first + k;
    const LaneCone next = lane_impulse(&gradient_rows[rows.first + k].next, first);
    lane_store_impulse(lane_select_cone(takes, next, lane_impulse(impulses, first)), impulses, first);
  }
}

#endif
