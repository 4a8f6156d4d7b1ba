// Solves LANES contacts with angular friction. cpu_reference/solve_angular_friction.hpp is the twin and states the
// method.
#ifndef LOCKSTEP_SOLVE_ANGULAR_FRICTION_H
#define LOCKSTEP_SOLVE_ANGULAR_FRICTION_H

#include "solve_contact.h"
#include "torsion_cone.h"

#if FEATURE_ANGULAR_FRICTION

static inline LaneTorsionDelassus lane_torsion_delassus(global const ContactBlock* block,
                                                        global const AngularFrictionBlock* angular, u32 first) {
  LaneTorsionDelassus w;
  w.nn = LANE_LOAD(block->w_nn + first);
  w.t11 = LANE_LOAD(block->w_11 + first), w.t22 = LANE_LOAD(block->w_22 + first);
  w.n1 = LANE_LOAD(block->w_n1 + first), w.n2 = LANE_LOAD(block->w_n2 + first);
  w.t12 = LANE_LOAD(block->w_12 + first);
  w.ss = LANE_LOAD(angular->w_ss + first), w.ns = LANE_LOAD(angular->w_ns + first);
  w.s1 = LANE_LOAD(angular->w_1s + first), w.s2 = LANE_LOAD(angular->w_2s + first);
  return w;
}

static inline LaneTorsion lane_multiply_torsion(LaneTorsionDelassus w, LaneTorsion r) {
  return lane_make_torsion(w.nn * r.normal + w.n1 * r.tangent_1 + w.n2 * r.tangent_2 + w.ns * r.torsion,
                           w.n1 * r.normal + w.t11 * r.tangent_1 + w.t12 * r.tangent_2 + w.s1 * r.torsion,
                           w.n2 * r.normal + w.t12 * r.tangent_1 + w.t22 * r.tangent_2 + w.s2 * r.torsion,
                           w.ns * r.normal + w.s1 * r.tangent_1 + w.s2 * r.tangent_2 + w.ss * r.torsion);
}

#if FEATURE_ELLIPTIC_FRICTION
static inline LaneEllipse lane_ellipse(global const EllipseBlock* block, u32 first) {
  LaneEllipse s;
  s.s_11 = LANE_LOAD(block->s_11 + first);
  s.s_12 = LANE_LOAD(block->s_12 + first);
  s.s_22 = LANE_LOAD(block->s_22 + first);
  s.degenerate = LANE_LOAD(block->degenerate + first);
  return s;
}
#endif

// The moments on a of the contacts of a row, N m s.
static inline Lane3 lane_angular_friction_moment(LaneContact c, global const AngularFrictionBlock* angular,
                                                 global const AngularFrictionImpulse* angular_impulses, u32 first) {
  const lane torsion = LANE_LOAD(angular->torsion_radius + first) * LANE_LOAD(angular_impulses->torsion + first);
  return lane_add3(
      lane_add3(lane_scale3(torsion, c.normal), lane_scale3(LANE_LOAD(angular_impulses->roll_1 + first), c.tangent_1)),
      lane_scale3(LANE_LOAD(angular_impulses->roll_2 + first), c.tangent_2));
}

// One solve of a row of contacts: the `law` of their normal velocities, `slides` of the tangential ones.
static inline void solve_angular_friction(u32 first, lane_mask general, LaneLaw law, global const ContactBlock* block,
                                          global const SlideBlock* slides, global const AngularFrictionBlock* angular,
                                          global const EllipseBlock* ellipse, global ImpulseBlock* impulses,
                                          global AngularFrictionImpulse* angular_impulses, LaneBody* a, LaneBody* b,
                                          lane* change) {
  const LaneContact c = lane_contact(block, first);
  const LaneCone cone = lane_impulse(impulses, first);
  const LaneTorsion old =
      lane_make_torsion(cone.normal, cone.tangent_1, cone.tangent_2, LANE_LOAD(angular_impulses->torsion + first));
  LaneTorsionDelassus w = lane_torsion_delassus(block, angular, first);
  const lane radius = LANE_LOAD(angular->torsion_radius + first);

  const LaneCone u = lane_biased_velocity(c, law.bias, slides, first, a, b);
  const LaneTorsion own = lane_multiply_torsion(w, old);
  const LaneTorsion q =
      lane_make_torsion(u.normal - own.normal, u.tangent_1 - own.tangent_1, u.tangent_2 - own.tangent_2,
                        radius * lane_dot3(c.normal, lane_sub3(a->w, b->w)) - own.torsion);
  LaneTorsionDelassus soft = w;
  soft.nn = w.nn + law.softness;
  const lane friction = LANE_LOAD(block->friction + first);
#if FEATURE_ELLIPTIC_FRICTION
  const LaneEllipse s = lane_ellipse(ellipse, first);
  const LaneTorsion r =
      lane_stretch(s, lane_solve_torsion_cone(lane_stretch(s, q), lane_stretch_block(s, soft), friction));
#else
  const LaneTorsion r = lane_solve_torsion_cone(q, soft, friction);
#endif
  LANE_STORE(r.normal, impulses->normal + first);
  LANE_STORE(r.tangent_1, impulses->tangent_1 + first);
  LANE_STORE(r.tangent_2, impulses->tangent_2 + first);
  LANE_STORE(r.torsion, angular_impulses->torsion + first);
  const LaneTorsion d = lane_make_torsion(r.normal - old.normal, r.tangent_1 - old.tangent_1,
                                          r.tangent_2 - old.tangent_2, r.torsion - old.torsion);
  lane_push(c, general, lane_make_cone(d.normal, d.tangent_1, d.tangent_2), a, b);
  lane_twist_by(general, lane_scale3(radius * d.torsion, c.normal), a, b);

  const Lane3 angular_velocity = lane_sub3(a->w, b->w);
  LaneDiscInverse inverse;
  inverse.xx = LANE_LOAD(angular->inverse_11 + first), inverse.xy = LANE_LOAD(angular->inverse_12 + first);
  inverse.yy = LANE_LOAD(angular->inverse_22 + first);
  LaneDisc old_roll, u_roll;
  old_roll.x = LANE_LOAD(angular_impulses->roll_1 + first), old_roll.y = LANE_LOAD(angular_impulses->roll_2 + first);
  u_roll.x = lane_dot3(c.tangent_1, angular_velocity), u_roll.y = lane_dot3(c.tangent_2, angular_velocity);
  const LaneDisc roll =
      lane_solve_friction_disc(old_roll, u_roll, inverse, LANE_LOAD(angular->rolling_coefficient + first) * r.normal);
  LANE_STORE(roll.x, angular_impulses->roll_1 + first);
  LANE_STORE(roll.y, angular_impulses->roll_2 + first);
  const lane d_1 = roll.x - old_roll.x, d_2 = roll.y - old_roll.y;
  lane_twist_by(general, lane_add3(lane_scale3(d_1, c.tangent_1), lane_scale3(d_2, c.tangent_2)), a, b);
#if FEATURE_TOLERANCE
  const LaneTorsion slid = lane_multiply_torsion(w, d);
  *change = lane_larger(slid.normal * slid.normal + slid.tangent_1 * slid.tangent_1 + slid.tangent_2 * slid.tangent_2 +
                            slid.torsion * slid.torsion,
                        *change);
  const LaneDisc rolled = lane_disc_velocity(d_1, d_2, inverse);
  *change = lane_larger((d_1 * rolled.x + d_2 * rolled.y) * (a->inverse_mass + b->inverse_mass), *change);
#endif
}

#endif

#endif
