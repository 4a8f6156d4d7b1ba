// What a contact with angular friction asks of its bodies in a sub-step (cpu_reference/solve_angular_friction.hpp): the
// part of the Delassus block of its torsion, and the inverse of the block of rolling; and what it starts from, the
// moment of the last step or sub-step, turned with the contact through the world frame.
// kernels/prepare_angular_friction.h is the twin.
#pragma once

#include "cpu_reference/body_copies.hpp"
#include "cpu_reference/solve_angular_friction.hpp"

namespace lockstep::reference {

template <class real>
void clear_lane(AngularFrictionBlock<real>& block, AngularFrictionImpulse<real>& impulses, u32 lane) {
  for (real* field :
       {block.torsion_radius, block.rolling_coefficient, block.w_ss, block.w_ns, block.w_1s, block.w_2s,
        block.inverse_11, block.inverse_12, block.inverse_22, impulses.torsion, impulses.roll_1, impulses.roll_2})
    field[lane] = 0;
}

template <class real>
void clear_lane(EllipseBlock<real>& block, u32 lane) {
  block.s_11[lane] = block.s_12[lane] = block.s_22[lane] = block.degenerate[lane] = 0;
}

/// The moment that a contact starts from, world frame; `contact`, `block` and `impulses` still hold the last sub-step.
template <class real>
Vec3<real> start_moment(const StepParams<real>& params, const AngularFrictionPointBlock<real>& points,
                        const ContactBlock<real>& contact, const AngularFrictionBlock<real>& block,
                        const AngularFrictionImpulse<real>& impulses, u32 lane) {
  if (params.substep == 0) return {points.moment_x[lane], points.moment_y[lane], points.moment_z[lane]};
  return angular_friction_moment(contact_frame<real>(contact, lane), block, impulses, lane);
}

/// The ellipse of a contact at the current poses: its axis of anisotropy in the tangent plane. Where that is along the
/// normal the cone is round.
template <class real>
Ellipse<real> prepare_ellipse(const AnisotropyBlock<real>& anisotropy, const ContactFrame<real>& c, Quat<real> q_a,
                              Quat<real> q_b, EllipseBlock<real>& block, u32 lane) {
  const Vec3<real> along = rotate3(anisotropy.side[lane] == 0 ? q_a : q_b,
                                   Vec3<real>{anisotropy.x[lane], anisotropy.y[lane], anisotropy.z[lane]});
  const real along_1 = dot3(c.tangent_1, along), along_2 = dot3(c.tangent_2, along);
  const bool perpendicular = anisotropy.perpendicular[lane] != 0;
  const real d_1 = perpendicular ? -along_2 : along_1, d_2 = perpendicular ? along_1 : along_2;
  const real squared = d_1 * d_1 + d_2 * d_2;
  const bool is_oval = squared > real(1e-6);
  const real across = is_oval ? anisotropy.across[lane] : real(1),
             more = is_oval ? (real(1) - across) / squared : real(0);
  block.s_11[lane] = across + more * (d_1 * d_1);
  block.s_12[lane] = more * (d_1 * d_2);
  block.s_22[lane] = across + more * (d_2 * d_2);
  block.degenerate[lane] = across > 0 ? real(0) : real(1);
  return ellipse_of(block, lane);
}

/// `c` is the contact at the current poses, `moment` what it starts from. Returns the start of its cone: `r`, and the
/// torsion.
template <class real>
TorsionVector<real> prepare_angular_friction(const AngularFrictionPointBlock<real>& points, const ContactFrame<real>& c,
                                             u32 kind, const PairMotions<real>& motions, real w_nn, ConeVector<real> r,
                                             Vec3<real> moment, real friction, const Ellipse<real>* ellipse,
                                             AngularFrictionBlock<real>& block, AngularFrictionImpulse<real>& impulses,
                                             u32 lane) {
  const Motion<real>&a = motions.a, &b = motions.b;
  const real radius = points.torsion_radius[lane], rolling_coefficient = points.rolling_coefficient[lane];
  const Vec3<real> n = c.normal, t1 = c.tangent_1, t2 = c.tangent_2;
  const Vec3<real> response_n_a = angular_velocity_change(a, kind, n),
                   response_n_b = angular_velocity_change(b, kind, n);
  const auto torsion_coupling = [&](Vec3<real> axis) {
    return radius * (dot3(cross3(c.arm_a, axis), response_n_a) + dot3(cross3(c.arm_b, axis), response_n_b));
  };
  const bool has_torsion = radius > 0, general = has_torsion && kind == BLOCK_GENERAL;
  block.torsion_radius[lane] = radius;
  block.rolling_coefficient[lane] = rolling_coefficient;
  block.w_ss[lane] = has_torsion ? radius * radius * (dot3(n, response_n_a) + dot3(n, response_n_b)) : w_nn;
  block.w_ns[lane] = general ? torsion_coupling(n) : real(0);
  block.w_1s[lane] = general ? torsion_coupling(t1) : real(0);
  block.w_2s[lane] = general ? torsion_coupling(t2) : real(0);

  const Vec3<real> response_2_a = angular_velocity_change(a, kind, t2),
                   response_2_b = angular_velocity_change(b, kind, t2);
  const real w_11 = dot3(t1, angular_velocity_change(a, kind, t1)) + dot3(t1, angular_velocity_change(b, kind, t1));
  const real w_22 = dot3(t2, response_2_a) + dot3(t2, response_2_b),
             w_12 = dot3(t1, response_2_a) + dot3(t1, response_2_b);
  const bool rolls = rolling_coefficient > 0;
  const real inverse = real(1) / (w_11 * w_22 - w_12 * w_12);
  block.inverse_11[lane] = rolls ? w_22 * inverse : real(0);
  block.inverse_12[lane] = rolls ? -w_12 * inverse : real(0);
  block.inverse_22[lane] = rolls ? w_11 * inverse : real(0);

  TorsionVector<real> start = {r.normal, r.tangent_1, r.tangent_2, has_torsion ? dot3(moment, n) / radius : real(0)};
  if (ellipse)
    start = stretch(*ellipse, clamp_to_torsion_cone(shrink(*ellipse, start), friction));
  else
    start = clamp_to_torsion_cone(start, friction);
  const real roll_1 = dot3(moment, t1), roll_2 = dot3(moment, t2);
  const real length = std::sqrt(roll_1 * roll_1 + roll_2 * roll_2), limit = rolling_coefficient * start.normal;
  const real scale = length > limit ? limit / length : real(1);
  impulses.torsion[lane] = start.torsion;
  impulses.roll_1[lane] = scale * roll_1;
  impulses.roll_2[lane] = scale * roll_2;
  return start;
}

}  // namespace lockstep::reference
