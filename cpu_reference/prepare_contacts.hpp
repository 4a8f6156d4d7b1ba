// Writes the packed constraint stream of a sub-step: for each contact the law that its velocity at the end obeys,
//   u_n + bias >= 0,  r_n >= 0,  complementary;  friction exact in the cone  (survey 2.3 and 3.2).
//
// Bias, with u_old the normal velocity at the start of the sub-step, u_free after the forces and theta of the scheme:
//   apart (gap > 0): bodies may close the gap, gap + dt ((1 - theta) u_old + theta u_n) >= 0;
//   overlapping:     poses take it back (cpu_reference/separate_contacts.hpp), or Baumgarte, a share of the
//                    penetration beyond the slop at a bounded speed; soft contacts are damped springs: u_n + bias +
//                    softness r_n >= 0 (Catto, Soft Constraints, GDC 2011);
//   restitution:     a contact that closes in this sub-step faster than the threshold leaves at e times that speed
//                    (Newton): u_n >= -e u_old. The same law lets a hard contact that parts faster come to close again,
//                    where others press it together (Moreau 1988): an impulse adds r_n (u_n + u_old) / 2 of energy, and
//                    to stop such a contact would be a gain;
//   other laws of impact (cpu_reference/impact.hpp): what is hit gets the impulse P of its law for itself alone, from
//                    the velocity u after the forces, with the part of e that the approach has that is not of these
//                    forces. All rows are biased so that P solves them: with no other contact, impulse and outcome are
//                    the law's.
// Friction is static where the contact slid slower than a speed at the start of the sub-step (feature
// static_friction), and of what slides elsewhere.
// The Delassus block is J M^-1 J^T of the contact in its frame (n, t1, t2), M that of the pair's copies of its bodies
// where they are split (cpu_reference/body_copies.hpp). Impulses start from the last step, later
// from the last sub-step, turned with the contact through the world frame and put back into the cone.
#pragma once

#include "cpu_reference/body_copies.hpp"
#include "cpu_reference/cone.hpp"
#include "cpu_reference/current_contact.hpp"
#include "cpu_reference/foresee_contact.hpp"
#include "cpu_reference/frame.hpp"
#include "cpu_reference/impact.hpp"
#include "cpu_reference/measure.hpp"
#include "cpu_reference/prepare_angular_friction.hpp"
#include "cpu_reference/prepare_blow.hpp"
#include "cpu_reference/prepare_patch.hpp"
#include "cpu_reference/rigid_body.hpp"
#include "cpu_reference/solve_contact.hpp"
#include "cpu_reference/solve_normals.hpp"
#include "cpu_reference/tolerances.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// What one side gives to J M^-1 J^T for axes d and e: (arm x d) . I^-1 (arm x e), of a general contact.
template <class real>
real angular_share(const Motion<real>& body, Vec3<real> arm, Vec3<real> d, Vec3<real> e) {
  return dot3(cross3(arm, d), angular_velocity_change(body, BLOCK_GENERAL, cross3(arm, e)));
}

/// The part of a movable body's arm along the normal: a central contact has no other, up to rounding.
template <class real>
Vec3<real> central_arm(const Motion<real>& body, Vec3<real> normal, Vec3<real> arm) {
  return body.inverse_mass > 0 ? scale3(dot3(normal, arm), normal) : arm;
}

/// What a contact asks of its normal velocity at the end of the sub-step: u_n + bias + softness r_n >= 0.
template <class real>
struct NormalLaw {
  real bias;
  bool soft;
};

/// What of an overlap is taken back: what is beyond the slop, m, at a speed up to a limit, m/s. A soft contact that
/// carries a load asks for that speed only to carry it, and may ask for more beside what it carries already: else the
/// limit would bound the load.
template <class real>
struct Correction {
  real slop, limit;
};

template <class real>
Correction<real> correction_of(const StepParams<real>& p, real inner_radius, real bounding_radius, real w_nn,
                               real load) {
  return {pair_slop(p, inner_radius, bounding_radius),
          pair_correction_limit(p, bounding_radius) + p.softness * w_nn * load};
}

template <class real>
NormalLaw<real> normal_law(const StepParams<real>& p, Correction<real> correction, real gap, real u_old, real u_free,
                           real restitution) {
  const real gap_free = gap + p.dt * ((real(1) - p.theta) * u_old + p.theta * u_free);
  NormalLaw<real> law = {0, !(gap > 0)};
  if (gap > 0) {
    const real bias = p.theta > 0 ? (gap / p.dt + (real(1) - p.theta) * u_old) / p.theta : gap / p.dt + u_old;
    law.bias = bias > 0 ? bias : real(0);
  } else {
    const real depth = -gap - correction.slop;
    const real speed = p.correction * (depth > 0 ? depth : real(0)) / p.dt;
    law.bias = -(speed < correction.limit ? speed : correction.limit);
  }
  if (restitution > 0 && u_old < -p.restitution_threshold && gap_free < 0) {
    const real bounce = restitution * u_old;
    const real push_out = gap > 0 ? real(0) : law.bias;
    const bool bounces = bounce < push_out;
    law = {bounces ? bounce : push_out, law.soft && !bounces};
  }
  const bool separates = u_old > p.restitution_threshold && u_old > -law.bias;
  if (restitution > 0 && separates && !(p.softness > 0)) {
    const real closing = restitution * u_old;
    law.bias = closing > law.bias ? closing : law.bias;
  }
  return law;
}

/// Whether a contact closes in this sub-step at a speed that is more than what forces add to it in the sub-step: what
/// is slower rests, and friction that holds what rests is not to aim at the end of an impact.
template <class real>
bool is_hit(const StepParams<real>& p, real gap, real u_old, real u_free) {
  const real gap_free = gap + p.dt * ((real(1) - p.theta) * u_old + p.theta * u_free);
  return gap_free < 0 && u_old < -p.restitution_threshold && u_free < 0 && !(u_free < real(2) * u_old);
}

template <class real>
void clear_lane(ContactBlock<real>& block, ImpulseBlock<real>& impulses, u32 lane) {
  for (real* field : {block.normal_x, block.normal_y, block.normal_z,  block.arm_a_x,      block.arm_a_y,
                      block.arm_a_z,  block.arm_b_x,  block.arm_b_y,   block.arm_b_z,      block.bias,
                      block.friction, block.w_nn,     block.w_11,      block.w_22,         block.w_n1,
                      block.w_n2,     block.w_12,     impulses.normal, impulses.tangent_1, impulses.tangent_2})
    field[lane] = 0;
}

/// J M^-1 J^T of a contact in its frame. Where its pair shares one friction patch, all but w_nn is the patch's.
template <class real>
Delassus<real> contact_delassus(const ContactFrame<real>& c, bool central, bool uses_patches,
                                const PairMotions<real>& motions) {
  const Motion<real>&a = motions.a, &b = motions.b;
  const real inverse_mass = a.inverse_mass + b.inverse_mass;
  Delassus<real> w = {inverse_mass, 0, 0, 0, 0, 0};
  if (central) {
    if (uses_patches) return w;
    w.t11 = inverse_mass + dot3(c.arm_a, c.arm_a) * a.inertia_xx + dot3(c.arm_b, c.arm_b) * b.inertia_xx;
    w.t22 = w.t11;
    return w;
  }
  const auto share = [&](Vec3<real> d, Vec3<real> e) {
    return angular_share(a, c.arm_a, d, e) + angular_share(b, c.arm_b, d, e);
  };
  w.nn = inverse_mass + share(c.normal, c.normal);
  if (uses_patches) return w;
  w.t11 = inverse_mass + share(c.tangent_1, c.tangent_1);
  w.t22 = inverse_mass + share(c.tangent_2, c.tangent_2);
  w.n1 = share(c.normal, c.tangent_1);
  w.n2 = share(c.normal, c.tangent_2);
  w.t12 = share(c.tangent_1, c.tangent_2);
  return w;
}

/// What a contact aims at that is hit by another law than Newton's, `free` its velocity after the forces; `law` becomes
/// that of the normal velocity.
template <class real>
ImpactTarget<real> hit_target(const StepParams<real>& p, Correction<real> correction, real gap, real u_old,
                              ConeVector<real> free, const Delassus<real>& w, const ImpactMaterial<real>& material,
                              NormalLaw<real>& law) {
  const real share = u_old > free.normal ? u_old / free.normal : real(1);
  ImpactMaterial<real> shared = material;
  shared.restitution = share * material.restitution;
  const ImpactTarget<real> target = target_of(impact(free, w, shared), w, material.friction);
  law = normal_law(p, correction, gap, u_old, free.normal, real(0));
  const real least = gap > 0 ? real(0) : law.bias;
  const bool bounces = target.bias.normal < least;
  law = {bounces ? target.bias.normal : least, law.soft && !bounces};
  return target;
}

/// mu of static friction, or of what slid at the start of the sub-step.
template <class real>
real stick_or_slip_friction(const StaticFrictionBlock<real>& static_friction, real sliding, Vec3<real> old,
                            Vec3<real> t1, Vec3<real> t2, u32 lane) {
  const real u_1 = dot3(t1, old), u_2 = dot3(t2, old);
  return std::sqrt(u_1 * u_1 + u_2 * u_2) > static_friction.speed[lane] ? sliding : static_friction.friction[lane];
}

/// The impulse that a contact starts from: normal part, and tangential part as a world vector.
template <class real>
ContactImpulse<real> start_impulse(const StepParams<real>& params, const StartBlock<real>& starts,
                                   const ContactBlock<real>& block, const ImpulseBlock<real>& impulses, u32 lane) {
  if (params.substep == 0)
    return {starts.normal[lane], starts.tangent_x[lane], starts.tangent_y[lane], starts.tangent_z[lane]};
  const auto [t1, t2] = tangents(Vec3<real>{block.normal_x[lane], block.normal_y[lane], block.normal_z[lane]});
  const Vec3<real> t = add3(scale3(impulses.tangent_1[lane], t1), scale3(impulses.tangent_2[lane], t2));
  return {impulses.normal[lane], t.x, t.y, t.z};
}

template <class real>
ContactPoint<real> contact_point_of(const PointBlock<real>& p, u32 lane) {
  return {{p.anchor_a_x[lane], p.anchor_a_y[lane], p.anchor_a_z[lane]},
          p.radius_a[lane],
          {p.anchor_b_x[lane], p.anchor_b_y[lane], p.anchor_b_z[lane]},
          p.radius_b[lane],
          {p.normal_x[lane], p.normal_y[lane], p.normal_z[lane], 0}};
}

/// The contact at the end of the sub-step, where it is foreseen.
template <class real>
struct Foresight {
  bool is_there;
  CurrentContact<real> end;
};

/// Moves the normal and the arms to where the contact acts.
template <class real>
Foresight<real> foresee(const Buffers<real>& buffers, const StepParams<real>& params, const ContactPoint<real>& point,
                        u32 row, u32 lane, ForeseenSide<real> a, ForeseenSide<real> b, const PairMotions<real>& motions,
                        CurrentContact<real>& current) {
  const u32 frame = buffers.point_blocks[row].frame[lane];
  if (rotates_by_itself(motions.a) || rotates_by_itself(motions.b)) {
    predict_arms(params, point, frame, a, b, current);
    return {false, current};
  }
  if (!(params.separation > 0) || frame == NORMAL_OF_IMPACT) return {false, current};
  if (!buffers.rim_blocks.empty()) {
    const RimBlock<real>& rims = buffers.rim_blocks[row];
    a.axis = rotate3(a.pose.orientation, {rims.axis_a_x[lane], rims.axis_a_y[lane], rims.axis_a_z[lane]});
    b.axis = rotate3(b.pose.orientation, {rims.axis_b_x[lane], rims.axis_b_y[lane], rims.axis_b_z[lane]});
  }
  const Vec3<real> normal = current.normal;
  const CurrentContact<real> end = contact_after(point, frame, a, b, normal, params.dt, params.dt);
  if (params.theta < real(1)) {
    const real gap = current.gap;
    current = contact_after(point, frame, a, b, normal, params.dt, (real(1) - params.theta) * params.dt);
    current.gap = gap;
  }
  return {true, end};
}

/// The normal velocity of a contact there, by the velocities after the forces.
template <class real>
real foreseen_velocity(const CurrentContact<real>& c, bool central, const PairMotions<real>& motions) {
  const Vec3<real> arm_a = central ? central_arm(motions.a, c.normal, c.arm_a) : c.arm_a;
  const Vec3<real> arm_b = central ? central_arm(motions.b, c.normal, c.arm_b) : c.arm_b;
  return dot3(c.normal, velocity_at(arm_a, arm_b, motions.a, motions.b));
}

/// The softness of the contact, 1/kg, and what a blow on its pair asks.
template <class real>
struct PreparedContact {
  real softness;
  BlowPoint<real> point;
};

template <class real>
PreparedContact<real> prepare_contact(Buffers<real>& buffers, const StepParams<real>& params, const BlockBodies& bodies,
                                      const PairMotions<real>& motions, u32 lane, u32 row, ContactBlock<real>& block,
                                      ImpulseBlock<real>& impulses) {
  const u32 a = bodies.body_a[lane], b = bodies.body_b[lane];
  const PointBlock<real>& points = buffers.point_blocks[row];
  const Pose<real> pose_a = make_pose(buffers.positions[a], buffers.orientations[a]);
  const Pose<real> pose_b = make_pose(buffers.positions[b], buffers.orientations[b]);
  const ContactPoint<real> point = contact_point_of(points, lane);
  CurrentContact<real> current = current_contact(point, points.frame[lane], pose_a, pose_b);
  const real inner_radius = points.inner_radius[lane];
  if (params.substep == 0) {
    raise_maximum(buffers.counters, COUNTER_MAX_OVERLAP, -current.gap);
    if (inner_radius > 0) raise_maximum(buffers.counters, COUNTER_MAX_OVERLAP_RATIO, -current.gap / inner_radius);
  }
  const Motion<real>&motion_a = motions.a, &motion_b = motions.b;
  const Velocity<real>&old_a = buffers.previous_velocities[a], &old_b = buffers.previous_velocities[b];
  const bool central = bodies.kind[lane] == BLOCK_CENTRAL;
  const Foresight<real> foreseen =
      foresee(buffers, params, point, row, lane, {pose_a, vec3(old_a.v), vec3(old_a.w), {}},
              {pose_b, vec3(old_b.v), vec3(old_b.w), {}}, motions, current);
  const Vec3<real> n = current.normal;
  const auto [t1, t2] = tangents(n);
  const Vec3<real> arm_a = central ? central_arm(motion_a, n, current.arm_a) : current.arm_a;
  const Vec3<real> arm_b = central ? central_arm(motion_b, n, current.arm_b) : current.arm_b;

  const Vec3<real> old =
      sub3(add3(vec3(old_a.v), cross3(vec3(old_a.w), arm_a)), add3(vec3(old_b.v), cross3(vec3(old_b.w), arm_b)));
  const real u_old = dot3(n, old);
  const Vec3<real> free = sub3(add3(vec3(motion_a.v), cross3(vec3(motion_a.w), arm_a)),
                               add3(vec3(motion_b.v), cross3(vec3(motion_b.w), arm_b)));
  const real u_free = dot3(n, free);
  const real u_foreseen = foreseen.is_there ? foreseen_velocity(foreseen.end, central, motions) : u_free;
  const real friction =
      buffers.static_friction_blocks.empty()
          ? points.friction[lane]
          : stick_or_slip_friction(buffers.static_friction_blocks[row], points.friction[lane], old, t1, t2, lane);
  const ContactImpulse<real> start = start_impulse(params, buffers.start_blocks[row], block, impulses, lane);
  const Vec3<real> tangent = {start.tangent_x, start.tangent_y, start.tangent_z};
  ConeVector<real> r = {start.normal > 0 ? start.normal : real(0), dot3(tangent, t1), dot3(tangent, t2)};

  const ContactFrame<real> frame = {n, t1, t2, arm_a, arm_b};
  const Delassus<real> w = contact_delassus(frame, central, !buffers.patch_blocks.empty(), motions);

  if (buffers.angular_friction_blocks.empty()) {
    r = clamp_to_cone(r, friction);
  } else {
    const AngularFrictionPointBlock<real>& angular_friction_points = buffers.angular_friction_points[row];
    AngularFrictionBlock<real>& angular = buffers.angular_friction_blocks[row];
    AngularFrictionImpulse<real>& angular_impulses = buffers.angular_friction_impulses[row];
    const Vec3<real> moment = start_moment(params, angular_friction_points, block, angular, angular_impulses, lane);
    Ellipse<real> ellipse;
    const bool is_round = buffers.anisotropy_blocks.empty();
    if (!is_round)
      ellipse = prepare_ellipse(buffers.anisotropy_blocks[row], frame, pose_a.orientation, pose_b.orientation,
                                buffers.ellipse_blocks[row], lane);
    const TorsionVector<real> cone =
        prepare_angular_friction(angular_friction_points, frame, bodies.kind[lane], motions, w.nn, r, moment, friction,
                                 is_round ? nullptr : &ellipse, angular, angular_impulses, lane);
    r = {cone.normal, cone.tangent_1, cone.tangent_2};
  }
  block.normal_x[lane] = n.x;
  block.normal_y[lane] = n.y;
  block.normal_z[lane] = n.z;
  block.arm_a_x[lane] = arm_a.x;
  block.arm_a_y[lane] = arm_a.y;
  block.arm_a_z[lane] = arm_a.z;
  block.arm_b_x[lane] = arm_b.x;
  block.arm_b_y[lane] = arm_b.y;
  block.arm_b_z[lane] = arm_b.z;
  const Correction<real> correction = correction_of(params, inner_radius, points.bounding_radius[lane], w.nn, r.normal);
  NormalLaw<real> law = normal_law(params, correction, current.gap, u_old, u_free, points.restitution[lane]);
  const bool may_bounce = points.restitution[lane] > 0 && std::fabs(u_old) > params.restitution_threshold;
  if (foreseen.is_there && !(current.gap > 0) && !may_bounce)
    law.bias = law.bias + (params.theta < real(1) ? real(1) : real(0.5)) * (u_foreseen - u_free);
  ImpactTarget<real> target = {{0, 0, 0}, friction};
  if (!buffers.impact_blocks.empty()) {
    const ImpactBlock<real>& impacts = buffers.impact_blocks[row];
    const ImpactMaterial<real> material = {impacts.law[lane], friction, points.restitution[lane],
                                           impacts.tangential_restitution[lane]};
    if (material.law != IMPACT_NEWTON && is_hit(params, current.gap, u_old, u_free))
      target = hit_target(params, correction, current.gap, u_old, {u_free, dot3(free, t1), dot3(free, t2)}, w, material,
                          law);
    buffers.slide_blocks[row].bias_1[lane] = target.bias.tangent_1;
    buffers.slide_blocks[row].bias_2[lane] = target.bias.tangent_2;
  }
  block.bias[lane] = law.bias;
  block.friction[lane] = target.friction;
  block.w_nn[lane] = w.nn;
  block.w_11[lane] = w.t11;
  block.w_22[lane] = w.t22;
  block.w_n1[lane] = w.n1;
  block.w_n2[lane] = w.n2;
  block.w_12[lane] = w.t12;
  impulses.normal[lane] = r.normal;
  impulses.tangent_1[lane] = r.tangent_1;
  impulses.tangent_2[lane] = r.tangent_2;
  const real restitution = points.restitution[lane];
  PreparedContact<real> prepared = {law.soft ? params.softness * w.nn : real(0), {}};
  if (restitution > 0) {
    const real gap_free = current.gap + params.dt * ((real(1) - params.theta) * u_old + params.theta * u_free);
    const NormalLaw<real> rests = normal_law(params, correction, current.gap, u_old, u_free, real(0));
    prepared.point = {current.gap,
                      u_old,
                      restitution,
                      rests.bias,
                      rests.soft ? params.softness : real(0),
                      u_old < -params.restitution_threshold && gap_free < 0};
  }
  return prepared;
}

/// A lane without a contact: cleared once, for nothing writes it until contacts are packed again.
template <class real>
void clear_row(Buffers<real>& buffers, u32 row, u32 lane) {
  clear_lane(buffers.contact_blocks[row], buffers.impulse_blocks[row], lane);
  if (!buffers.angular_friction_blocks.empty())
    clear_lane(buffers.angular_friction_blocks[row], buffers.angular_friction_impulses[row], lane);
  if (!buffers.ellipse_blocks.empty()) clear_lane(buffers.ellipse_blocks[row], lane);
  if (!buffers.slide_blocks.empty())
    buffers.slide_blocks[row].bias_1[lane] = buffers.slide_blocks[row].bias_2[lane] = 0;
  if (!buffers.softness_blocks.empty()) buffers.softness_blocks[row].softness[lane] = 0;
}

/// The rows of a pair, and what they ask of its normals together.
template <class real>
void prepare_pair(Buffers<real>& buffers, const StepParams<real>& params, u32 block, u32 lane) {
  const BlockBodies& bodies = buffers.block_bodies[block];
  const u32 first = buffers.block_rows[block].first, count = bodies.count[lane];
  const PairMotions<real> motions = pair_motions(buffers, block, lane);
  std::array<BlowPoint<real>, MANIFOLD_POINTS> points;
  for (u32 k = 0; k < count; ++k) {
    const PreparedContact<real> contact =
        prepare_contact(buffers, params, bodies, motions, lane, first + k, buffers.contact_blocks[first + k],
                        buffers.impulse_blocks[first + k]);
    points[k] = contact.point;
    if (!buffers.softness_blocks.empty()) buffers.softness_blocks[first + k].softness[lane] = contact.softness;
  }
  if (!buffers.normal_couplings.empty()) {
    couple_normals(buffers.contact_blocks, first, count, bodies.kind[lane], lane, motions,
                   buffers.normal_couplings[block]);
    real& hit_speed = buffers.normal_couplings[block].hit_speed[lane];
    if (buffers.softness_blocks.empty())
      hit_speed = 0;
    else
      hit_speed =
          next_hit_speed(params.substep, buffers.point_blocks[first].bounding_radius[lane],
                         pair_load(buffers.contact_blocks, buffers.impulse_blocks, first, count, lane), hit_speed);
    const u32 law = buffers.impact_blocks.empty() ? u32{IMPACT_NEWTON} : buffers.impact_blocks[first].law[lane];
    prepare_blow(buffers, params, block, lane, law, points);
  }
  if (!buffers.patch_blocks.empty())
    prepare_patch(buffers, params, motions, count, lane, first, buffers.patch_blocks[block],
                  buffers.patch_impulses[block]);
}

template <class real>
void prepare_contacts(Buffers<real>& buffers, const StepParams<real>& params) {
  if (step_aborted(buffers.counters)) return;
  for_each_pair_slot(buffers,
                     [&](const BlockBodies&, u32 block, u32 lane) { prepare_pair(buffers, params, block, lane); });
  if (params.substep > 0) return;
  for (u32 block = 0; block < buffers.counters[COUNTER_BLOCKS]; ++block) {
    const auto [first, count] = buffers.block_rows[block];
    for (u32 lane = 0; lane < PACK; ++lane) {
      const u32 used = buffers.block_bodies[block].count[lane];
      for (u32 k = used; k < count; ++k) clear_row(buffers, first + k, lane);
      if (used > 0) continue;
      if (!buffers.normal_couplings.empty()) clear_lane(buffers.normal_couplings[block], lane);
      if (!buffers.patch_blocks.empty()) clear_lane(buffers.patch_blocks[block], buffers.patch_impulses[block], lane);
    }
  }
}

}  // namespace lockstep::reference
