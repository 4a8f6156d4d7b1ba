#pragma OPENCL FP_CONTRACT OFF
// Writes the packed constraint stream of a sub-step, LANES pairs at a time (cpu_reference/prepare_contacts.hpp states
// the law, cpu_reference/current_contact.hpp the contact at the current poses).
#include "body_copies.h"
#include "common.h"
#include "cone.h"
#include "foresee_contact.h"
#include "impact.h"
#include "lane_current_contact.h"
#include "lane_tolerances.h"
#include "measure.h"
#include "prepare_angular_friction.h"
#include "prepare_blow.h"
#include "prepare_patch.h"
#include "solve_contact.h"
#include "solve_normals.h"
#include "types.h"

// One side of the pairs: all of the body, and its velocity at the start of the sub-step.
typedef struct PrepareBody {
  LanePose pose;
  LaneBody motion;
  Lane3 old_v, old_w;
} PrepareBody;

// Padding lanes read the null body's motion, and the pose of the last body.
static inline void prepare_load(global const u32* bodies, u32 body_count, global const Vec4* positions,
                                global const Vec4* orientations, global const Motion* motions,
                                global const Velocity* previous_velocities, PrepareBody* body) {
  u32 indices[LANES];
  for (u32 k = 0u; k < LANES; ++k) indices[k] = min(bodies[k], body_count - 1u);
  const LaneLines old = lane_gather_lines((global const Real8*)previous_velocities, 1u, indices);
  body->pose = lane_load_poses(bodies, body_count, positions, orientations);
  body->motion = lane_load_bodies(motions, bodies);
  body->old_v = lane_make3(old.c0, old.c1, old.c2);
  body->old_w = lane_make3(old.c4, old.c5, old.c6);
}

// What of an overlap is taken back: what is beyond the slop, at a speed up to the limit.
typedef struct LaneCorrection {
  lane slop, limit;
} LaneCorrection;

static inline LaneCorrection prepare_correction(const StepParams* p, lane inner_radius, lane bounding_radius, lane w_nn,
                                                lane load) {
  LaneCorrection correction;
  correction.slop = lane_pair_slop(p, inner_radius, bounding_radius);
  correction.limit = lane_pair_correction_limit(p, bounding_radius) + (lane)p->softness * w_nn * load;
  return correction;
}

// What a contact asks of its normal velocity at the end of the sub-step: u_n + bias + softness r_n >= 0. The softness
// is told in parts of w_nn.
static inline lane prepare_bias(const StepParams* p, LaneCorrection correction, lane gap, lane u_old, lane u_free,
                                lane restitution, lane* softness) {
  const lane old_share = (lane)((real)1 - p->theta), dt = (lane)p->dt;
  const lane_mask open = gap > (lane)0;
  lane closing;
  if (p->theta > (real)0)
    closing = (gap / dt + old_share * u_old) / (lane)p->theta;
  else
    closing = gap / dt + u_old;
  closing = closing > (lane)0 ? closing : (lane)0;
  const lane depth = -gap - correction.slop;
  const lane speed = (lane)p->correction * (depth > (lane)0 ? depth : (lane)0) / dt;
  const lane push_out = -(speed < correction.limit ? speed : correction.limit);

  const lane gap_free = gap + dt * (old_share * u_old + (lane)p->theta * u_free);
  const lane_mask may_bounce =
      (restitution > (lane)0) & (u_old < (lane)-p->restitution_threshold) & (gap_free < (lane)0);
  const lane bounce = restitution * u_old;
  const lane least = open ? (lane)0 : push_out;
  const lane_mask bounces = may_bounce & (bounce < least);
  *softness = open | bounces ? (lane)0 : (lane)p->softness;
  const lane bias = bounces ? bounce : (may_bounce ? least : (open ? closing : push_out));
  if (p->softness > (real)0) return bias;
  const lane closing_again = restitution * u_old;
  const lane_mask may_close =
      (restitution > (lane)0) & (u_old > (lane)p->restitution_threshold) & (u_old > -bias) & (closing_again > bias);
  return may_close ? closing_again : bias;
}

// The velocities of a against b at the ends of the arms.
static inline Lane3 prepare_velocity(Lane3 v_a, Lane3 w_a, Lane3 arm_a, Lane3 v_b, Lane3 w_b, Lane3 arm_b) {
  return lane_sub3(lane_add3(v_a, lane_cross3(w_a, arm_a)), lane_add3(v_b, lane_cross3(w_b, arm_b)));
}

// The part of a movable body's arm along the normal: a central contact has no other, up to rounding.
static inline Lane3 prepare_central_arm(lane_mask general, lane inverse_mass, Lane3 normal, Lane3 arm) {
  const Lane3 along = lane_scale3(lane_dot3(normal, arm), normal);
  const Lane3 central = lane_select3(inverse_mass > (lane)0, along, arm);
  return lane_select3(general, arm, central);
}

// The impulses to start from, of the last step or sub-step, in the rotated tangent frames.
static inline LaneCone prepare_impulse(u32 substep, u32 first, Lane3 t1, Lane3 t2, global const StartBlock* starts,
                                       global const ContactBlock* block, global const ImpulseBlock* impulses) {
  lane normal;
  Lane3 tangent;
  if (substep == 0u) {
    normal = LANE_LOAD(starts->normal + first);
    tangent = lane_load_xyz(starts->tangent_x + first, starts->tangent_y + first, starts->tangent_z + first);
  } else {
    Lane3 old_t1, old_t2;
    lane_tangents(LANE_NORMAL(block, first), &old_t1, &old_t2);
    const LaneCone old = lane_impulse(impulses, first);
    normal = old.normal;
    tangent = lane_add3(lane_scale3(old.tangent_1, old_t1), lane_scale3(old.tangent_2, old_t2));
  }
  normal = normal > (lane)0 ? normal : (lane)0;
  return lane_make_cone(normal, lane_dot3(tangent, t1), lane_dot3(tangent, t2));
}

static inline void prepare_delassus(lane_mask general, Lane3 n, Lane3 t1, Lane3 t2, Lane3 arm_a, Lane3 arm_b,
                                    const LaneBody* a, const LaneBody* b, LaneDelassus* w) {
  const lane inverse_mass = a->inverse_mass + b->inverse_mass;
  w->nn = inverse_mass;
  w->t11 = inverse_mass + lane_dot3(arm_a, arm_a) * a->xx + lane_dot3(arm_b, arm_b) * b->xx;
  w->t22 = w->t11;
  w->n1 = w->n2 = w->t12 = (lane)0;
#if FEATURE_PATCHES
  // the rest is the patch's
  const Lane3 n_a = lane_cross3(arm_a, n), n_b = lane_cross3(arm_b, n);
  const lane share =
      lane_dot3(n_a, lane_apply_inverse_inertia(*a, n_a)) + lane_dot3(n_b, lane_apply_inverse_inertia(*b, n_b));
  w->nn = general ? inverse_mass + share : w->nn;
  w->t11 = w->t22 = (lane)0;
#elif FEATURE_GENERAL_CONTACTS
  const Lane3 n_a = lane_cross3(arm_a, n), t1_a = lane_cross3(arm_a, t1), t2_a = lane_cross3(arm_a, t2);
  const Lane3 n_b = lane_cross3(arm_b, n), t1_b = lane_cross3(arm_b, t1), t2_b = lane_cross3(arm_b, t2);
  const Lane3 response_n_a = lane_apply_inverse_inertia(*a, n_a), response_n_b = lane_apply_inverse_inertia(*b, n_b);
  const Lane3 response_1_a = lane_apply_inverse_inertia(*a, t1_a), response_1_b = lane_apply_inverse_inertia(*b, t1_b);
  const Lane3 response_2_a = lane_apply_inverse_inertia(*a, t2_a), response_2_b = lane_apply_inverse_inertia(*b, t2_b);
  w->nn = general ? inverse_mass + (lane_dot3(n_a, response_n_a) + lane_dot3(n_b, response_n_b)) : w->nn;
  w->t11 = general ? inverse_mass + (lane_dot3(t1_a, response_1_a) + lane_dot3(t1_b, response_1_b)) : w->t11;
  w->t22 = general ? inverse_mass + (lane_dot3(t2_a, response_2_a) + lane_dot3(t2_b, response_2_b)) : w->t22;
  w->n1 = general ? lane_dot3(n_a, response_1_a) + lane_dot3(n_b, response_1_b) : w->n1;
  w->n2 = general ? lane_dot3(n_a, response_2_a) + lane_dot3(n_b, response_2_b) : w->n2;
  w->t12 = general ? lane_dot3(t1_a, response_2_a) + lane_dot3(t1_b, response_2_b) : w->t12;
#endif
}

#if FEATURE_IMPACT_LAWS
// The laws of impact of the lanes that are hit: what they ask of their velocities, and the friction of their cones.
static inline void prepare_impacts(const StepParams* p, u32 first, lane_mask there, LaneCorrection correction, lane gap,
                                   lane u_old, LaneCone free, const LaneDelassus* w, lane restitution,
                                   global const ImpactBlock* impacts, lane* bias, lane* softness, LaneTarget* target) {
  const lane_u32 law = LANE_LOAD_U32(impacts->law + first);
  const lane gap_free = gap + (lane)p->dt * ((lane)((real)1 - p->theta) * u_old + (lane)p->theta * free.normal);
  const lane_mask hit = there & LANE_MASK(law != (lane_u32)IMPACT_NEWTON) & (gap_free < (lane)0) &
                        (u_old < (lane)-p->restitution_threshold) & (free.normal < (lane)0) &
                        !(free.normal < (lane)2 * u_old);
  if (!LANE_ANY(hit)) return;
  const lane share = u_old > free.normal ? u_old / free.normal : (lane)1;
  LaneImpactMaterial material;
  material.by_work = LANE_MASK(law == (lane_u32)IMPACT_STRONGE);
  material.combines = LANE_MASK(law == (lane_u32)IMPACT_CHATTERJEE_RUINA);
  material.friction = target->friction;
  material.restitution = share * restitution;
  material.tangential_restitution = LANE_LOAD(impacts->tangential_restitution + first);
  const LaneOutcome outcome = lane_impact(hit, free, w, &material);
  const LaneTarget impact_target = lane_target(&outcome, w, target->friction);
  lane own_softness;
  const lane rests = prepare_bias(p, correction, gap, u_old, free.normal, (lane)0, &own_softness);
  const lane least = gap > (lane)0 ? (lane)0 : rests;
  const lane_mask bounces = impact_target.bias.normal < least;
  *bias = hit ? (bounces ? impact_target.bias.normal : least) : *bias;
  *softness = hit ? (bounces ? (lane)0 : own_softness) : *softness;
  target->bias.tangent_1 = hit ? impact_target.bias.tangent_1 : target->bias.tangent_1;
  target->bias.tangent_2 = hit ? impact_target.bias.tangent_2 : target->bias.tangent_2;
  target->friction = hit ? impact_target.friction : target->friction;
}
#endif

// How deep contacts are, and how deep over the inner radius of the smaller shape.
typedef struct LaneOverlap {
  lane depth, ratio;
} LaneOverlap;

static inline void note_overlap(lane_mask there, lane gap, lane inner_radius, LaneOverlap* overlap) {
  const lane depth = there ? -gap : (lane)0;
  const lane ratio = inner_radius > (lane)0 ? depth / inner_radius : (lane)0;
  overlap->depth = depth > overlap->depth ? depth : overlap->depth;
  overlap->ratio = ratio > overlap->ratio ? ratio : overlap->ratio;
}

// What rotates by itself carries its contacts.
static inline lane_mask prepare_carried(const PrepareBody* a, const PrepareBody* b) {
  return lane_rotates_by_itself(&a->motion) | lane_rotates_by_itself(&b->motion);
}

static inline LaneForeseenSide prepare_side(const PrepareBody* body) {
  const LaneForeseenSide side = {body->pose, body->old_v, body->old_w, lane_make3((lane)0, (lane)0, (lane)0)};
  return side;
}

#if FEATURE_SEPARATED_CONTACTS
// The contacts at the end of the sub-step, where they are foreseen.
typedef struct PrepareForesight {
  lane_mask is_there;
  LaneCurrentContact end;
} PrepareForesight;

// Moves normals and arms to where the contacts act.
static inline PrepareForesight prepare_foresight(const StepParams* p, u32 first, lane_mask there,
                                                 global const PointBlock* points, global const RimBlock* rims,
                                                 LaneForeseenSide a, LaneForeseenSide b, LaneCurrentContact* current) {
  PrepareForesight foreseen;
  foreseen.is_there = there & LANE_MASK(LANE_LOAD_U32(points->frame + first) != (lane_u32)NORMAL_OF_IMPACT);
  if (p->theta == (real)1) foreseen.is_there = foreseen.is_there & !(current->gap > (lane)0);  // they have no other use
  if (!LANE_ANY(foreseen.is_there)) return foreseen;
#if FEATURE_CYLINDERS
  lane_set_rim_axes(first, rims, &a, &b);
#endif
  const Lane3 normal = current->normal;
  lane_contact_after(first, points, &a, &b, normal, (lane)p->dt, (lane)p->dt, &foreseen.end);
  if (p->theta < (real)1) {
    LaneCurrentContact middle;
    lane_contact_after(first, points, &a, &b, normal, (lane)p->dt, (lane)(((real)1 - p->theta) * p->dt), &middle);
    current->normal = lane_select3(foreseen.is_there, middle.normal, current->normal);
    current->arm_a = lane_select3(foreseen.is_there, middle.arm_a, current->arm_a);
    current->arm_b = lane_select3(foreseen.is_there, middle.arm_b, current->arm_b);
  }
  return foreseen;
}

// Their normal velocities there, by the velocities after the forces.
static inline lane prepare_foreseen_velocity(lane_mask general, const LaneCurrentContact* c, const LaneBody* a,
                                             const LaneBody* b) {
  const Lane3 arm_a = prepare_central_arm(general, a->inverse_mass, c->normal, c->arm_a);
  const Lane3 arm_b = prepare_central_arm(general, b->inverse_mass, c->normal, c->arm_b);
  return lane_dot3(c->normal, lane_velocity_at(arm_a, arm_b, a, b));
}
#endif

// What prepare_row tells of a row to a blow on its pairs (prepare_blow.h), where the scene has such.
#if FEATURE_COUPLED_NORMALS
typedef LaneBlowPoint PrepareBlow;
#else
typedef u32 PrepareBlow;
#endif

// The laws of a row of contacts, in the lanes where there are any.
static inline void prepare_row(const StepParams* params, u32 first, lane_mask there, lane_mask general,
                               const PrepareBody* a, const PrepareBody* b, global const PointBlock* points,
                               global const RimBlock* rims, global const StartBlock* starts,
                               global const ImpactBlock* impacts,
                               global const AngularFrictionPointBlock* angular_friction_points,
                               global const StaticFrictionBlock* static_friction,
                               global const AnisotropyBlock* anisotropy, global ContactBlock* block,
                               global SoftnessBlock* softness_block, global SlideBlock* slides,
                               global AngularFrictionBlock* angular, global ImpulseBlock* impulses,
                               global AngularFrictionImpulse* angular_impulses, global EllipseBlock* ellipses,
                               LaneOverlap* overlap, PrepareBlow* blow) {
  LaneCurrentContact current;
  lane_current_contact(first, points, &a->pose, &b->pose, &current);
  const lane_mask carried = prepare_carried(a, b);
  const LaneForeseenSide side_a = prepare_side(a), side_b = prepare_side(b);
  lane_predict_arms(params, first, points, carried, &side_a, &side_b, &current);
#if FEATURE_SEPARATED_CONTACTS
  const PrepareForesight foreseen =
      prepare_foresight(params, first, there & !carried, points, rims, side_a, side_b, &current);
#endif
  const lane inner_radius = LANE_LOAD(points->inner_radius + first);
  note_overlap(there, current.gap, inner_radius, overlap);
  const Lane3 n = current.normal;
  Lane3 t1, t2;
  lane_tangents(n, &t1, &t2);
  const Lane3 arm_a = prepare_central_arm(general, a->motion.inverse_mass, n, current.arm_a);
  const Lane3 arm_b = prepare_central_arm(general, b->motion.inverse_mass, n, current.arm_b);
  const lane restitution = LANE_LOAD(points->restitution + first);
  lane friction = LANE_LOAD(points->friction + first);
  lane u_old = (lane)0, u_free = (lane)0;  // of no weight where theta is 1 and nothing bounces
#if FEATURE_IMPACT_LAWS || FEATURE_STATIC_FRICTION || FEATURE_SEPARATED_CONTACTS
  const bool counts = true;
#else
  const bool counts = params->theta < (real)1 || LANE_ANY(restitution > (lane)0);
#endif
  Lane3 free = lane_make3((lane)0, (lane)0, (lane)0);
  if (counts) {
    const Lane3 old = prepare_velocity(a->old_v, a->old_w, arm_a, b->old_v, b->old_w, arm_b);
    u_old = lane_dot3(n, old);
#if FEATURE_STATIC_FRICTION
    const lane old_1 = lane_dot3(t1, old), old_2 = lane_dot3(t2, old);
    const lane_mask slid = sqrt(old_1 * old_1 + old_2 * old_2) > LANE_LOAD(static_friction->speed + first);
    friction = slid ? friction : LANE_LOAD(static_friction->friction + first);
#endif
    free = prepare_velocity(a->motion.v, a->motion.w, arm_a, b->motion.v, b->motion.w, arm_b);
    u_free = lane_dot3(n, free);
  }
  LaneDelassus w;
  prepare_delassus(general, n, t1, t2, arm_a, arm_b, &a->motion, &b->motion, &w);
  LaneCone r = prepare_impulse(params->substep, first, t1, t2, starts, block, impulses);
#if FEATURE_ANGULAR_FRICTION
  const LaneContact contact = {n, t1, t2, arm_a, arm_b};
  const Lane3 moment = start_moment(params->substep, first, angular_friction_points, block, angular, angular_impulses);
  LaneEllipse ellipse = {(lane)1, (lane)0, (lane)1, (lane)0};
#if FEATURE_ELLIPTIC_FRICTION
  ellipse = prepare_ellipse(first, there, contact, a->pose.orientation, b->pose.orientation, anisotropy, ellipses);
#endif
  const LaneTorsion start =
      prepare_angular_friction(first, there, general, contact, &a->motion, &b->motion, w.nn, r, moment, friction,
                               &ellipse, angular_friction_points, angular, angular_impulses);
  r = lane_make_cone(start.normal, start.tangent_1, start.tangent_2);
#else
  r = lane_clamp_to_cone(r, friction);
#endif
  const LaneCorrection correction =
      prepare_correction(params, inner_radius, LANE_LOAD(points->bounding_radius + first), w.nn, r.normal);
  lane softness;
  lane bias = prepare_bias(params, correction, current.gap, u_old, u_free, restitution, &softness);
#if FEATURE_SEPARATED_CONTACTS
  const lane_mask may_bounce = (restitution > (lane)0) & (fabs(u_old) > (lane)params->restitution_threshold);
  const lane_mask biased = foreseen.is_there & !(current.gap > (lane)0) & !may_bounce;
  if (LANE_ANY(biased)) {
    const lane u_foreseen = prepare_foreseen_velocity(general, &foreseen.end, &a->motion, &b->motion);
    const lane share = (lane)(params->theta < (real)1 ? (real)1 : (real)0.5);
    bias = biased ? bias + share * (u_foreseen - u_free) : bias;
  }
#endif
#if FEATURE_COUPLED_NORMALS
  blow->restitution = restitution;
  blow->is_hit = (lane)0 > (lane)0;
  if (LANE_ANY(restitution > (lane)0)) {
    const lane gap_free =
        current.gap + (lane)params->dt * ((lane)((real)1 - params->theta) * u_old + (lane)params->theta * u_free);
    blow->is_hit = (restitution > (lane)0) & (u_old < (lane)-params->restitution_threshold) & (gap_free < (lane)0);
    blow->gap = current.gap;
    blow->u_old = u_old;
    blow->rest_bias = prepare_bias(params, correction, current.gap, u_old, u_free, (lane)0, &blow->rest_softness);
  }
#endif
#if FEATURE_IMPACT_LAWS
  LaneTarget target;
  target.bias = lane_make_cone((lane)0, (lane)0, (lane)0);
  target.friction = friction;
  prepare_impacts(params, first, there, correction, current.gap, u_old,
                  lane_make_cone(u_free, lane_dot3(free, t1), lane_dot3(free, t2)), &w, restitution, impacts, &bias,
                  &softness, &target);
  lane_store_where(there, target.bias.tangent_1, slides->bias_1 + first);
  lane_store_where(there, target.bias.tangent_2, slides->bias_2 + first);
  lane_store_where(there, target.friction, block->friction + first);
#else
  lane_store_where(there, friction, block->friction + first);
#endif

  lane_store_where(there, n.x, block->normal_x + first);
  lane_store_where(there, n.y, block->normal_y + first);
  lane_store_where(there, n.z, block->normal_z + first);
  lane_store_where(there, arm_a.x, block->arm_a_x + first);
  lane_store_where(there, arm_a.y, block->arm_a_y + first);
  lane_store_where(there, arm_a.z, block->arm_a_z + first);
  lane_store_where(there, arm_b.x, block->arm_b_x + first);
  lane_store_where(there, arm_b.y, block->arm_b_y + first);
  lane_store_where(there, arm_b.z, block->arm_b_z + first);
  lane_store_where(there, bias, block->bias + first);
  lane_store_where(there, w.nn, block->w_nn + first);
  lane_store_where(there, w.t11, block->w_11 + first);
  lane_store_where(there, w.t22, block->w_22 + first);
  lane_store_where(there, w.n1, block->w_n1 + first);
  lane_store_where(there, w.n2, block->w_n2 + first);
  lane_store_where(there, w.t12, block->w_12 + first);
  lane_store_where(there, r.normal, impulses->normal + first);
  lane_store_where(there, r.tangent_1, impulses->tangent_1 + first);
  lane_store_where(there, r.tangent_2, impulses->tangent_2 + first);
#if FEATURE_SOFT_CONTACTS
  lane_store_where(there & (softness > (lane)0), softness * w.nn, softness_block->softness + first);
#endif
}

kernel void prepare_contacts(
    const StepParams params, global const Vec4* positions, global const Vec4* orientations,
    global const Motion* motions, global const Velocity* previous_velocities, global const PointBlock* point_blocks,
    global const RimBlock* rim_blocks, global const StartBlock* start_blocks, global const ImpactBlock* impact_blocks,
    global const AngularFrictionPointBlock* angular_friction_points,
    global const StaticFrictionBlock* static_friction_blocks, global const AnisotropyBlock* anisotropy_blocks,
    global const BlockBodies* block_bodies, global const BlockRows* block_rows,
    global const BodyCopyBlock* body_copy_blocks, global ContactBlock* contact_blocks,
    global ImpulseBlock* impulse_blocks, global SoftnessBlock* softness_blocks, global SlideBlock* slide_blocks,
    global AngularFrictionBlock* angular_friction_blocks, global AngularFrictionImpulse* angular_friction_impulses,
    global EllipseBlock* ellipse_blocks, global NormalCoupling* normal_couplings, global PatchBlock* patch_blocks,
    global PatchImpulse* patch_impulses, global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(item, counters[COUNTER_BLOCKS] * ITEMS_PER_BLOCK) {
    const u32 first = item % ITEMS_PER_BLOCK * LANES;
    global const BlockBodies* bodies = block_bodies + item / ITEMS_PER_BLOCK;
    const BlockRows rows = block_rows[item / ITEMS_PER_BLOCK];
    const lane_u32 count = LANE_LOAD_U32(bodies->count + first);
    const lane_mask general = lane_general(bodies, first);
    PrepareBody a, b;
    prepare_load(bodies->body_a + first, params.bodies, positions, orientations, motions, previous_velocities, &a);
    prepare_load(bodies->body_b + first, params.bodies, positions, orientations, motions, previous_velocities, &b);
#if FEATURE_JACOBI
    body_copy_lighten(LANE_LOAD(body_copy_blocks[item / ITEMS_PER_BLOCK].copies_a + first), &a.motion);
    body_copy_lighten(LANE_LOAD(body_copy_blocks[item / ITEMS_PER_BLOCK].copies_b + first), &b.motion);
#endif
    LaneOverlap overlap = {(lane)0, (lane)0};
    PrepareBlow blows[MANIFOLD_POINTS];
    for (u32 row = rows.first; row < rows.first + rows.count; ++row) {
      const lane_mask there = LANE_MASK(count > (lane_u32)(row - rows.first));
      prepare_row(&params, first, there, general, &a, &b, point_blocks + row, rim_blocks + row, start_blocks + row,
                  impact_blocks + row, angular_friction_points + row, static_friction_blocks + row,
                  anisotropy_blocks + row, contact_blocks + row, softness_blocks + row, slide_blocks + row,
                  angular_friction_blocks + row, impulse_blocks + row, angular_friction_impulses + row,
                  ellipse_blocks + row, &overlap, &blows[row - rows.first]);
    }
    if (params.substep == 0u) {
      raise_maximum(counters, COUNTER_MAX_OVERLAP, lane_largest(overlap.depth));
      raise_maximum(counters, COUNTER_MAX_OVERLAP_RATIO, lane_largest(overlap.ratio));
    }
#if FEATURE_COUPLED_NORMALS
    couple_normals(first, rows.count, count, general, &a.motion, &b.motion, contact_blocks + rows.first,
                   normal_couplings + item / ITEMS_PER_BLOCK);
    lane hit_speed = (lane)0;
#if FEATURE_SOFT_CONTACTS
    hit_speed =
        lane_next_hit_speed(params.substep, LANE_LOAD(point_blocks[rows.first].bounding_radius + first),
                            lane_pair_load(first, rows.count, contact_blocks + rows.first, impulse_blocks + rows.first),
                            LANE_LOAD(normal_couplings[item / ITEMS_PER_BLOCK].hit_speed + first));
#endif
    LANE_STORE(hit_speed, normal_couplings[item / ITEMS_PER_BLOCK].hit_speed + first);
    prepare_blows(&params, first, rows.count, count, blows, impact_blocks + rows.first,
                  normal_couplings + item / ITEMS_PER_BLOCK, contact_blocks + rows.first, softness_blocks + rows.first);
#endif
#if FEATURE_PATCHES
    prepare_patches(params.substep, first, rows.count, count, &a.motion, &b.motion, contact_blocks + rows.first,
                    impulse_blocks + rows.first, patch_blocks + item / ITEMS_PER_BLOCK,
                    patch_impulses + item / ITEMS_PER_BLOCK);
#endif
  }
}
