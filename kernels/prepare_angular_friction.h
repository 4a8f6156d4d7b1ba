// What LANES contacts with angular friction ask of their bodies in a sub-step.
// cpu_reference/prepare_angular_friction.hpp is the twin and states the law.
#ifndef LOCKSTEP_PREPARE_ANGULAR_FRICTION_H
#define LOCKSTEP_PREPARE_ANGULAR_FRICTION_H

#include "lane_math.h"
#include "solve_angular_friction.h"

#if FEATURE_ANGULAR_FRICTION

// The moments that a row starts from, world frame; `contact`, `block` and `impulses` still hold the last sub-step.
static inline Lane3 start_moment(u32 substep, u32 first, global const AngularFrictionPointBlock* points,
                                 global const ContactBlock* contact, global const AngularFrictionBlock* block,
                                 global const AngularFrictionImpulse* impulses) {
  if (substep == 0u) return lane_load_xyz(points->moment_x + first, points->moment_y + first, points->moment_z + first);
  return lane_angular_friction_moment(lane_contact(contact, first), block, impulses, first);
}

static inline lane torsion_coupling(lane radius, LaneContact c, Lane3 axis, Lane3 response_n_a, Lane3 response_n_b) {
  return radius *
         (lane_dot3(lane_cross3(c.arm_a, axis), response_n_a) + lane_dot3(lane_cross3(c.arm_b, axis), response_n_b));
}

#if FEATURE_ELLIPTIC_FRICTION
// The ellipses of a row of contacts at the current poses.
static inline LaneEllipse prepare_ellipse(u32 first, lane_mask there, LaneContact c, LaneQuat q_a, LaneQuat q_b,
                                          global const AnisotropyBlock* anisotropy, global EllipseBlock* block) {
  const Lane3 own = lane_load_xyz(anisotropy->x + first, anisotropy->y + first, anisotropy->z + first);
  const lane_mask of_a = LANE_MASK(LANE_LOAD_U32(anisotropy->side + first) == (lane_u32)0);
  const Lane3 along = lane_select3(of_a, lane_rotate3(q_a, own), lane_rotate3(q_b, own));
  const lane along_1 = lane_dot3(c.tangent_1, along), along_2 = lane_dot3(c.tangent_2, along);
  const lane_mask perpendicular = LANE_MASK(LANE_LOAD_U32(anisotropy->perpendicular + first) != (lane_u32)0);
  const lane d_1 = perpendicular ? -along_2 : along_1, d_2 = perpendicular ? along_1 : along_2;
  const lane squared = d_1 * d_1 + d_2 * d_2;
  const lane_mask is_oval = squared > (lane)(real)1e-6;
  const lane across = is_oval ? LANE_LOAD(anisotropy->across + first) : (lane)1;
  const lane more = is_oval ? ((lane)1 - across) / squared : (lane)0;
  LaneEllipse s;
  s.s_11 = across + more * (d_1 * d_1);
  s.s_12 = more * (d_1 * d_2);
  s.s_22 = across + more * (d_2 * d_2);
  s.degenerate = across > (lane)0 ? (lane)0 : (lane)1;
  lane_store_where(there, s.s_11, block->s_11 + first);
  lane_store_where(there, s.s_12, block->s_12 + first);
  lane_store_where(there, s.s_22, block->s_22 + first);
  lane_store_where(there, s.degenerate, block->degenerate + first);
  return s;
}
#endif

// `c` is a row of contacts at the current poses, `moment` what it starts from. Returns the start of its cone: `r`, and
// the torsion.
static inline LaneTorsion prepare_angular_friction(u32 first, lane_mask there, lane_mask general, LaneContact c,
                                                   const LaneBody* a, const LaneBody* b, lane w_nn, LaneCone r,
                                                   Lane3 moment, lane friction, const LaneEllipse* ellipse,
                                                   global const AngularFrictionPointBlock* points,
                                                   global AngularFrictionBlock* block,
                                                   global AngularFrictionImpulse* impulses) {
  const lane radius = LANE_LOAD(points->torsion_radius + first),
             rolling_coefficient = LANE_LOAD(points->rolling_coefficient + first);
  const Lane3 n = c.normal, t1 = c.tangent_1, t2 = c.tangent_2;
  const Lane3 response_n_a = lane_angular_velocity_change(*a, general, n),
              response_n_b = lane_angular_velocity_change(*b, general, n);
  const lane_mask has_torsion = radius > (lane)0, couples = has_torsion & general;
  lane_store_where(there, radius, block->torsion_radius + first);
  lane_store_where(there, rolling_coefficient, block->rolling_coefficient + first);
  lane_store_where(there,
                   has_torsion ? radius * radius * (lane_dot3(n, response_n_a) + lane_dot3(n, response_n_b)) : w_nn,
                   block->w_ss + first);
  lane_store_where(there, couples ? torsion_coupling(radius, c, n, response_n_a, response_n_b) : (lane)0,
                   block->w_ns + first);
  lane_store_where(there, couples ? torsion_coupling(radius, c, t1, response_n_a, response_n_b) : (lane)0,
                   block->w_1s + first);
  lane_store_where(there, couples ? torsion_coupling(radius, c, t2, response_n_a, response_n_b) : (lane)0,
                   block->w_2s + first);

  const Lane3 response_2_a = lane_angular_velocity_change(*a, general, t2),
              response_2_b = lane_angular_velocity_change(*b, general, t2);
  const lane w_11 = lane_dot3(t1, lane_angular_velocity_change(*a, general, t1)) +
                    lane_dot3(t1, lane_angular_velocity_change(*b, general, t1));
  const lane w_22 = lane_dot3(t2, response_2_a) + lane_dot3(t2, response_2_b);
  const lane w_12 = lane_dot3(t1, response_2_a) + lane_dot3(t1, response_2_b);
  const lane_mask rolls = rolling_coefficient > (lane)0;
  const lane inverse = (lane)1 / (w_11 * w_22 - w_12 * w_12);
  lane_store_where(there, rolls ? w_22 * inverse : (lane)0, block->inverse_11 + first);
  lane_store_where(there, rolls ? -w_12 * inverse : (lane)0, block->inverse_12 + first);
  lane_store_where(there, rolls ? w_11 * inverse : (lane)0, block->inverse_22 + first);

  const lane torsion = has_torsion ? lane_dot3(moment, n) / radius : (lane)0;
  LaneTorsion start = lane_make_torsion(r.normal, r.tangent_1, r.tangent_2, torsion);
#if FEATURE_ELLIPTIC_FRICTION
  start = lane_stretch(*ellipse, lane_clamp_to_torsion_cone(lane_shrink(*ellipse, start), friction));
#else
  start = lane_clamp_to_torsion_cone(start, friction);
#endif
  const lane roll_1 = lane_dot3(moment, t1), roll_2 = lane_dot3(moment, t2);
  const lane length = sqrt(roll_1 * roll_1 + roll_2 * roll_2), limit = rolling_coefficient * start.normal;
  const lane scale = length > limit ? limit / length : (lane)1;
  lane_store_where(there, start.torsion, impulses->torsion + first);
  lane_store_where(there, scale * roll_1, impulses->roll_1 + first);
  lane_store_where(there, scale * roll_2, impulses->roll_2 + first);
  return start;
}

#endif

#endif
