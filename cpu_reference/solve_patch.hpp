// Solves one pair whose contacts share one friction patch, the `patch` kind: a normal row for each contact and, at
// their centre of pressure, one friction block and a twist about the normal. It is cheaper than a cone for each
// contact, and another model: friction and twist are bounded each by itself, by
//   |t| <= mu sum r_k,   |twist| <= mu sum distance_k r_k    (Macklin et al. 2019 and most engines bound them so).
// What the sweeps of the solver and the warm start share. kernels/solve_patch.h is the twin, LANES pairs at a time.
//
// One after another, each with the impulses of the others held: the normals, the twist, the friction
// (solve_friction_disc), and the normals again, since friction at the centre turns the bodies against them.
#pragma once

#include <vector>

#include "cpu_reference/solve_contact.hpp"

namespace lockstep::reference {

template <class real>
void push_patch(const ContactFrame<real>& c, real r_1, real r_2, Motion<real>& a, Motion<real>& b) {
  push_at(c.arm_a, c.arm_b, BLOCK_GENERAL, add3(scale3(r_1, c.tangent_1), scale3(r_2, c.tangent_2)), a, b);
}

/// The normal row of one contact. Returns the square of by how much it changed the normal velocity.
template <class real>
real solve_normal(const ContactBlock<real>& block, real bias, real softness, ImpulseBlock<real>& impulses, u32 lane,
                  Motion<real>& a, Motion<real>& b) {
  const ContactArms<real> c = contact_arms<real>(block, lane);
  const real u_n = dot3(c.normal, velocity_at(c.arm_a, c.arm_b, a, b)) + bias;
  const real old = impulses.normal[lane];
  const real next = old - (u_n + softness * old) / (block.w_nn[lane] + softness);
  const real r = next > 0 ? next : real(0);
  impulses.normal[lane] = r;
  push_at(c.arm_a, c.arm_b, BLOCK_GENERAL, scale3(r - old, c.normal), a, b);
  const real change = block.w_nn[lane] * (r - old);
  return change * change;
}

template <class real>
DiscInverse<real> patch_friction_inverse(const PatchBlock<real>& block, u32 lane) {
  return {block.inverse_11[lane], block.inverse_12[lane], block.inverse_22[lane]};
}

/// The larger of the squares of what changes of friction and twist make of the relative velocity: W is the inverse of
/// what the block holds, and the rotation counts at the radius of gyration of the two bodies about the normal.
template <class real>
real patch_friction_change(const PatchBlock<real>& block, u32 lane, real d_1, real d_2, real d_twist,
                           const Motion<real>& a, const Motion<real>& b) {
  const auto [u_1, u_2] = disc_velocity(d_1, d_2, patch_friction_inverse(block, lane));
  const real twist_change = d_twist * d_twist * (a.inverse_mass + b.inverse_mass) / block.inverse_twist[lane];
  return larger(u_1 * u_1 + u_2 * u_2, larger(twist_change, real(0)));
}

/// Twist and friction, under the normal impulses of the pair's rows. Returns the square of by how much they changed the
/// relative velocity.
template <class real>
real solve_patch_friction(const PatchBlock<real>& block, const std::vector<ImpulseBlock<real>>& rows, u32 first,
                          u32 count, PatchImpulse<real>& impulses, u32 lane, Motion<real>& a, Motion<real>& b) {
  real load = 0, moment = 0;
  for (u32 k = 0; k < count; ++k) {
    const real r = rows[first + k].normal[lane];
    load = load + r;
    moment = moment + block.distance[k][lane] * r;
  }
  const real limit = block.friction[lane] * load, twist_limit = block.friction[lane] * moment;
  const ContactFrame<real> c = contact_frame<real>(block, lane);

  const real old_twist = impulses.twist[lane];
  const real wanted = old_twist - block.inverse_twist[lane] * dot3(c.normal, sub3(vec3(a.w), vec3(b.w)));
  const real twist = wanted > twist_limit ? twist_limit : (wanted < -twist_limit ? -twist_limit : wanted);
  impulses.twist[lane] = twist;
  twist_by(BLOCK_GENERAL, scale3(twist - old_twist, c.normal), a, b);

  const Vec3<real> u = velocity_at(c.arm_a, c.arm_b, a, b);
  const real old_1 = impulses.tangent_1[lane], old_2 = impulses.tangent_2[lane];
  const auto [r_1, r_2] = solve_friction_disc(old_1, old_2, dot3(c.tangent_1, u), dot3(c.tangent_2, u),
                                              patch_friction_inverse(block, lane), limit);
  impulses.tangent_1[lane] = r_1;
  impulses.tangent_2[lane] = r_2;
  push_patch(c, r_1 - old_1, r_2 - old_2, a, b);
  return patch_friction_change(block, lane, r_1 - old_1, r_2 - old_2, twist - old_twist, a, b);
}

/// Gives the bodies the impulses that the pair starts from: row by row, then twist and friction.
template <class real>
void start_normal(const ContactBlock<real>& block, const ImpulseBlock<real>& impulses, u32 lane, Motion<real>& a,
                  Motion<real>& b) {
  const ContactArms<real> c = contact_arms<real>(block, lane);
  push_at(c.arm_a, c.arm_b, BLOCK_GENERAL, scale3(impulses.normal[lane], c.normal), a, b);
}
template <class real>
void start_patch_friction(const PatchBlock<real>& block, const PatchImpulse<real>& impulses, u32 lane, Motion<real>& a,
                          Motion<real>& b) {
  const ContactFrame<real> c = contact_frame<real>(block, lane);
  twist_by(BLOCK_GENERAL, scale3(impulses.twist[lane], c.normal), a, b);
  push_patch(c, impulses.tangent_1[lane], impulses.tangent_2[lane], a, b);
}

}  // namespace lockstep::reference
