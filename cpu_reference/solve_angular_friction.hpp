// One contact with angular friction: slip and torsion in one cone (cpu_reference/torsion_cone.hpp), then rolling,
//   |m_t| <= rolling_coefficient r_n,   m_t against the relative angular velocity in the tangent plane
// (Contensou 1963; Johnson, Contact Mechanics, 1985, ch. 9: the pressure before a rolling body is higher than behind
// it, so that the resultant acts that far ahead). Rolling is held at once where it can be, else taken by a step of
// projection (solve_friction_disc), the cone given. kernels/solve_angular_friction.h is the twin, LANES contacts at a
// time.
#pragma once

#include "cpu_reference/solve_contact.hpp"
#include "cpu_reference/torsion_cone.hpp"

namespace lockstep::reference {

template <class real>
TorsionDelassus<real> torsion_delassus(const ContactBlock<real>& block, const AngularFrictionBlock<real>& angular,
                                       real softness, u32 lane) {
  return {block.w_nn[lane] + softness,
          block.w_11[lane],
          block.w_22[lane],
          block.w_n1[lane],
          block.w_n2[lane],
          block.w_12[lane],
          angular.w_ss[lane],
          angular.w_ns[lane],
          angular.w_1s[lane],
          angular.w_2s[lane]};
}

template <class real>
TorsionVector<real> multiply(const TorsionDelassus<real>& w, TorsionVector<real> r) {
  return {w.nn * r.normal + w.n1 * r.tangent_1 + w.n2 * r.tangent_2 + w.ns * r.torsion,
          w.n1 * r.normal + w.t11 * r.tangent_1 + w.t12 * r.tangent_2 + w.s1 * r.torsion,
          w.n2 * r.normal + w.t12 * r.tangent_1 + w.t22 * r.tangent_2 + w.s2 * r.torsion,
          w.ns * r.normal + w.s1 * r.tangent_1 + w.s2 * r.tangent_2 + w.ss * r.torsion};
}

template <class real>
Ellipse<real> ellipse_of(const EllipseBlock<real>& block, u32 lane) {
  return {block.s_11[lane], block.s_12[lane], block.s_22[lane], block.degenerate[lane]};
}

/// `ellipse`: none where the cone is round. Returns the square of by how much it changed the relative velocity; rolling
/// counts at the radius of gyration of the two bodies.
template <class real>
real solve_angular_friction(const ContactBlock<real>& block, const AngularFrictionBlock<real>& angular,
                            const EllipseBlock<real>* ellipse, ConeVector<real> bias, real softness,
                            ImpulseBlock<real>& impulses, AngularFrictionImpulse<real>& angular_impulses, u32 kind,
                            u32 lane, Motion<real>& a, Motion<real>& b) {
  const ContactFrame<real> c = contact_frame<real>(block, lane);
  const ConeVector<real> cone = impulse_of(impulses, lane);
  const TorsionVector<real> old = {cone.normal, cone.tangent_1, cone.tangent_2, angular_impulses.torsion[lane]};
  const TorsionDelassus<real> w = torsion_delassus(block, angular, real(0), lane);
  const real radius = angular.torsion_radius[lane];

  const auto [u_n, u_1, u_2] = biased_velocity(c, bias, a, b);
  const TorsionVector<real> own = multiply(w, old);
  const TorsionVector<real> q = {u_n - own.normal, u_1 - own.tangent_1, u_2 - own.tangent_2,
                                 radius * dot3(c.normal, sub3(vec3(a.w), vec3(b.w))) - own.torsion};
  const TorsionDelassus<real> soft = torsion_delassus(block, angular, softness, lane);
  TorsionVector<real> r;
  if (ellipse) {
    const Ellipse<real> s = ellipse_of(*ellipse, lane);
    r = stretch(s, solve_torsion_cone(stretch(s, q), stretch(s, soft), block.friction[lane]));
  } else {
    r = solve_torsion_cone(q, soft, block.friction[lane]);
  }
  impulses.normal[lane] = r.normal;
  impulses.tangent_1[lane] = r.tangent_1;
  impulses.tangent_2[lane] = r.tangent_2;
  angular_impulses.torsion[lane] = r.torsion;
  const TorsionVector<real> d = {r.normal - old.normal, r.tangent_1 - old.tangent_1, r.tangent_2 - old.tangent_2,
                                 r.torsion - old.torsion};
  push(c, kind, ConeVector<real>{d.normal, d.tangent_1, d.tangent_2}, a, b);
  twist_by(kind, scale3(radius * d.torsion, c.normal), a, b);

  const Vec3<real> angular_velocity = sub3(vec3(a.w), vec3(b.w));
  const real old_1 = angular_impulses.roll_1[lane], old_2 = angular_impulses.roll_2[lane];
  const DiscInverse<real> inverse = {angular.inverse_11[lane], angular.inverse_12[lane], angular.inverse_22[lane]};
  const auto [roll_1, roll_2] =
      solve_friction_disc(old_1, old_2, dot3(c.tangent_1, angular_velocity), dot3(c.tangent_2, angular_velocity),
                          inverse, angular.rolling_coefficient[lane] * r.normal);
  angular_impulses.roll_1[lane] = roll_1;
  angular_impulses.roll_2[lane] = roll_2;
  const real d_1 = roll_1 - old_1, d_2 = roll_2 - old_2;
  twist_by(kind, add3(scale3(d_1, c.tangent_1), scale3(d_2, c.tangent_2)), a, b);

  const TorsionVector<real> slid = multiply(w, d);
  const real change = slid.normal * slid.normal + slid.tangent_1 * slid.tangent_1 + slid.tangent_2 * slid.tangent_2 +
                      slid.torsion * slid.torsion;
  const auto [w_1, w_2] = disc_velocity(d_1, d_2, inverse);
  return larger((d_1 * w_1 + d_2 * w_2) * (a.inverse_mass + b.inverse_mass), change);
}

/// Gives the bodies the moments that the contact starts from.
template <class real>
void start_angular_friction(const ContactBlock<real>& block, const AngularFrictionBlock<real>& angular,
                            const AngularFrictionImpulse<real>& angular_impulses, u32 kind, u32 lane, Motion<real>& a,
                            Motion<real>& b) {
  twist_by(kind, angular_friction_moment(contact_frame<real>(block, lane), angular, angular_impulses, lane), a, b);
}

}  // namespace lockstep::reference
