// Solves LANES pairs in contact: what the solver's sweeps and the warm start share.
// cpu_reference/solve_contact.hpp is the twin and states the method.
#ifndef LOCKSTEP_SOLVE_CONTACT_H
#define LOCKSTEP_SOLVE_CONTACT_H

#include "common.h"
#include "cone.h"
#include "lanes.h"
#include "sweep_change.h"

// The bodies on one side of the contacts, a lane each. Central contacts need the first half of a body's line only.
typedef struct LaneBody {
  Lane3 v, w;
  lane inverse_mass, xx;
#if FEATURE_GENERAL_CONTACTS
  lane yy, zz, xy, xz, yz;
#endif
} LaneBody;

// The geometry of the contacts.
typedef struct LaneContact {
  Lane3 normal, tangent_1, tangent_2, arm_a, arm_b;
} LaneContact;

static inline LaneBody lane_load_bodies(global const Motion* motions, global const u32* indices) {
  const LaneLines first = lane_gather(motions, 0u, indices);
  LaneBody body;
  body.v = lane_make3(first.c0, first.c1, first.c2);
  body.inverse_mass = first.c3;
  body.w = lane_make3(first.c4, first.c5, first.c6);
  body.xx = first.c7;
#if FEATURE_GENERAL_CONTACTS
  const LaneLines second = lane_gather(motions, 1u, indices);
  body.yy = second.c0, body.zz = second.c1;
  body.xy = second.c2, body.xz = second.c3, body.yz = second.c4;
#endif
  return body;
}

static inline LaneLines lane_first_half(LaneBody body) {
  LaneLines first;
  first.c0 = body.v.x, first.c1 = body.v.y, first.c2 = body.v.z;
  first.c3 = body.inverse_mass;
  first.c4 = body.w.x, first.c5 = body.w.y, first.c6 = body.w.z;
  first.c7 = body.xx;
  return first;
}

static inline void lane_store_bodies(LaneBody body, global Motion* motions, global const u32* indices) {
  lane_scatter_movable(lane_first_half(body), (global Real8*)motions, sizeof(Motion) / sizeof(Real8), indices);
}

// Duff et al. (2017), right-handed with the normal.
static inline void lane_tangents(Lane3 n, Lane3* t1, Lane3* t2) {
  const lane sign = n.z < (lane)0 ? (lane)-1 : (lane)1;
  const lane a = (lane)-1 / (sign + n.z);
  const lane b = n.x * n.y * a;
  *t1 = lane_make3((lane)1 + sign * n.x * n.x * a, sign * b, -sign * n.x);
  *t2 = lane_make3(b, sign + n.y * n.y * a, -n.y);
}

// Of a ContactBlock, or of a PatchBlock.
#define LANE_NORMAL(block, first) \
  lane_load_xyz((block)->normal_x + first, (block)->normal_y + first, (block)->normal_z + first)
#define LANE_ARM_A(block, first) \
  lane_load_xyz((block)->arm_a_x + first, (block)->arm_a_y + first, (block)->arm_a_z + first)
#define LANE_ARM_B(block, first) \
  lane_load_xyz((block)->arm_b_x + first, (block)->arm_b_y + first, (block)->arm_b_z + first)

static inline LaneContact lane_frame(Lane3 normal, Lane3 arm_a, Lane3 arm_b) {
  LaneContact c;
  c.normal = normal;
  c.arm_a = arm_a;
  c.arm_b = arm_b;
  lane_tangents(normal, &c.tangent_1, &c.tangent_2);
  return c;
}

static inline LaneContact lane_contact(global const ContactBlock* block, u32 first) {
  return lane_frame(LANE_NORMAL(block, first), LANE_ARM_A(block, first), LANE_ARM_B(block, first));
}

static inline LaneCone lane_impulse(global const ImpulseBlock* block, u32 first) {
  return lane_make_cone(LANE_LOAD(block->normal + first), LANE_LOAD(block->tangent_1 + first),
                        LANE_LOAD(block->tangent_2 + first));
}

#if FEATURE_GENERAL_CONTACTS
// Inverse inertia times a moment.
static inline Lane3 lane_apply_inverse_inertia(LaneBody body, Lane3 moment) {
  return lane_make3(body.xx * moment.x + body.xy * moment.y + body.xz * moment.z,
                    body.xy * moment.x + body.yy * moment.y + body.yz * moment.z,
                    body.xz * moment.x + body.yz * moment.y + body.zz * moment.z);
}
#endif

// The same where a contact is general; the inertia of a central one is the same about every axis that counts.
static inline Lane3 lane_angular_velocity_change(LaneBody body, lane_mask general, Lane3 moment) {
  const Lane3 central = lane_scale3(body.xx, moment);
#if FEATURE_GENERAL_CONTACTS
  return lane_select3(general, lane_apply_inverse_inertia(body, moment), central);
#else
  return central;
#endif
}

// The velocity of a against b at the ends of the arms.
static inline Lane3 lane_velocity_at(Lane3 arm_a, Lane3 arm_b, const LaneBody* a, const LaneBody* b) {
  return lane_sub3(lane_add3(a->v, lane_cross3(a->w, arm_a)), lane_add3(b->v, lane_cross3(b->w, arm_b)));
}

// An impulse on a at the end of its arm, its opposite on b.
static inline void lane_push_at(Lane3 arm_a, Lane3 arm_b, lane_mask general, Lane3 impulse, LaneBody* a, LaneBody* b) {
  a->v = lane_add3(a->v, lane_scale3(a->inverse_mass, impulse));
  a->w = lane_add3(a->w, lane_angular_velocity_change(*a, general, lane_cross3(arm_a, impulse)));
  b->v = lane_sub3(b->v, lane_scale3(b->inverse_mass, impulse));
  b->w = lane_sub3(b->w, lane_angular_velocity_change(*b, general, lane_cross3(arm_b, impulse)));
}

// A moment on a, its opposite on b.
static inline void lane_twist_by(lane_mask general, Lane3 moment, LaneBody* a, LaneBody* b) {
  a->w = lane_add3(a->w, lane_angular_velocity_change(*a, general, moment));
  b->w = lane_sub3(b->w, lane_angular_velocity_change(*b, general, moment));
}

// As vectors of the world.
static inline Lane3 lane_impulse_world(LaneContact c, LaneCone r) {
  return lane_add3(lane_add3(lane_scale3(r.normal, c.normal), lane_scale3(r.tangent_1, c.tangent_1)),
                   lane_scale3(r.tangent_2, c.tangent_2));
}

static inline void lane_push(LaneContact c, lane_mask general, LaneCone r, LaneBody* a, LaneBody* b) {
  lane_push_at(c.arm_a, c.arm_b, general, lane_impulse_world(c, r), a, b);
}

#define PURPOSE_SOLVE 0u
#define PURPOSE_RELAX 1u  // soft contacts become hard, without a bias (cpu_reference/relax_constraints.hpp)

// Of the normal velocity: u_n + bias + softness r_n >= 0.
typedef struct LaneLaw {
  lane bias, softness, w_nn;
} LaneLaw;

static inline LaneLaw lane_law(const u32 purpose, global const ContactBlock* block,
                               global const SoftnessBlock* softness_block, u32 first) {
  LaneLaw law;
  law.bias = LANE_LOAD(block->bias + first);
  law.softness = (lane)0;
  law.w_nn = LANE_LOAD(block->w_nn + first);
#if FEATURE_SOFT_CONTACTS
  const lane softness = LANE_LOAD(softness_block->softness + first);
  if (purpose == PURPOSE_RELAX)
    law.bias = softness > (lane)0 ? (lane)0 : law.bias;
  else
    law.softness = softness;
#endif
  return law;
}

// The contacts' relative velocities, the bias of the normal ones and that of `slides` added, in their frames.
static inline LaneCone lane_biased_velocity(LaneContact c, lane bias, global const SlideBlock* slides, u32 first,
                                            const LaneBody* a, const LaneBody* b) {
  const Lane3 u = lane_velocity_at(c.arm_a, c.arm_b, a, b);
  LaneCone biased = lane_make_cone(lane_dot3(c.normal, u) + bias, lane_dot3(c.tangent_1, u), lane_dot3(c.tangent_2, u));
#if FEATURE_IMPACT_LAWS
  biased.tangent_1 = biased.tangent_1 + LANE_LOAD(slides->bias_1 + first);
  biased.tangent_2 = biased.tangent_2 + LANE_LOAD(slides->bias_2 + first);
#endif
  return biased;
}

#if FEATURE_TOLERANCE
// The square of what a change of its impulse makes of a contact's relative velocity: |W d|^2.
static inline lane lane_contact_change(lane_mask general, global const ContactBlock* block, u32 first, LaneCone d) {
  const lane w_nn = LANE_LOAD(block->w_nn + first), w_11 = LANE_LOAD(block->w_11 + first);
  LaneCone u = lane_make_cone(w_nn * d.normal, w_11 * d.tangent_1, w_11 * d.tangent_2);
#if FEATURE_GENERAL_CONTACTS
  const lane w_22 = LANE_LOAD(block->w_22 + first), w_n1 = LANE_LOAD(block->w_n1 + first);
  const lane w_n2 = LANE_LOAD(block->w_n2 + first), w_12 = LANE_LOAD(block->w_12 + first);
  const LaneCone whole = lane_make_cone(w_nn * d.normal + w_n1 * d.tangent_1 + w_n2 * d.tangent_2,
                                        w_n1 * d.normal + w_11 * d.tangent_1 + w_12 * d.tangent_2,
                                        w_n2 * d.normal + w_12 * d.tangent_1 + w_22 * d.tangent_2);
  u = lane_select_cone(general, whole, u);
#endif
  return u.normal * u.normal + u.tangent_1 * u.tangent_1 + u.tangent_2 * u.tangent_2;
}
#endif

// One Gauss-Seidel solve of a row of contacts. `change` keeps the largest of the squared changes of velocities.
static inline void solve_contact_row(const u32 purpose, u32 first, lane_mask general, global const ContactBlock* block,
                                     global const SoftnessBlock* softness_block, global const SlideBlock* slides,
                                     global ImpulseBlock* impulses, LaneBody* a, LaneBody* b, lane* change) {
  const LaneContact c = lane_contact(block, first);
  const LaneCone old = lane_impulse(impulses, first);
  const lane friction = LANE_LOAD(block->friction + first);
  const LaneLaw law = lane_law(purpose, block, softness_block, first);
  const lane w_nn = law.w_nn, own_nn = w_nn + law.softness, w_11 = LANE_LOAD(block->w_11 + first);

  const LaneCone u = lane_biased_velocity(c, law.bias, slides, first, a, b);
  LaneCone r = lane_make_cone((lane)0, (lane)0, (lane)0);
  if (LANE_ANY(!general)) {
    const LaneCone q = lane_make_cone(u.normal - w_nn * old.normal, u.tangent_1 - w_11 * old.tangent_1,
                                      u.tangent_2 - w_11 * old.tangent_2);
    r = lane_solve_central(q, own_nn, w_11, friction);
  }
#if FEATURE_GENERAL_CONTACTS
  if (LANE_ANY(general)) {
    LaneDelassus w;
    w.nn = w_nn;
    w.t11 = w_11;
    w.t22 = LANE_LOAD(block->w_22 + first);
    w.n1 = LANE_LOAD(block->w_n1 + first);
    w.n2 = LANE_LOAD(block->w_n2 + first);
    w.t12 = LANE_LOAD(block->w_12 + first);
    const LaneCone q =
        lane_make_cone(u.normal - (w.nn * old.normal + w.n1 * old.tangent_1 + w.n2 * old.tangent_2),
                       u.tangent_1 - (w.n1 * old.normal + w.t11 * old.tangent_1 + w.t12 * old.tangent_2),
                       u.tangent_2 - (w.n2 * old.normal + w.t12 * old.tangent_1 + w.t22 * old.tangent_2));
    w.nn = own_nn;
    r = lane_select_cone(general, lane_solve_general(general, q, w, friction), r);
  }
#endif

  LANE_STORE(r.normal, impulses->normal + first);
  LANE_STORE(r.tangent_1, impulses->tangent_1 + first);
  LANE_STORE(r.tangent_2, impulses->tangent_2 + first);
  const LaneCone d = lane_make_cone(r.normal - old.normal, r.tangent_1 - old.tangent_1, r.tangent_2 - old.tangent_2);
  lane_push(c, general, d, a, b);
#if FEATURE_TOLERANCE
  *change = lane_larger(lane_contact_change(general, block, first, d), *change);
#endif
}

// A lane that has no contact in a row reads zeros there, and keeps its bodies to the sign of a zero.
static inline void lane_select_body(lane_mask there, LaneBody next, LaneBody* body) {
  body->v = lane_select3(there, next.v, body->v);
  body->w = lane_select3(there, next.w, body->w);
}

static inline lane_mask lane_general(global const BlockBodies* bodies, u32 first) {
  return LANE_MASK(LANE_LOAD_U32(bodies->kind + first) == (lane_u32)BLOCK_GENERAL);
}

#endif
