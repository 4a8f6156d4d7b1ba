// Solves one contact: what the solver's sweeps and the warm start share. kernels/solve_contact.h is the twin,
// LANES pairs of shapes at a time.
//
// Blocked projected Gauss-Seidel (survey 4.3; Jourdan, Alart, Jean 1998): with the impulses of all others held,
//   u = relative velocity at the contact point,  q = u + bias - W r_old,
// the contact's own problem is solved exactly (cpu_reference/cone.hpp) and the change r - r_old is given to the bodies.
// A soft contact solves it with its softness added to w_nn. By how much a solve changed relative velocities is
// |W (r - r_old)|: what the contact's law was violated by until then (cpu_reference/solve_constraints.hpp).
#pragma once

#include "cpu_reference/cone.hpp"
#include "cpu_reference/frame.hpp"
#include "cpu_reference/rigid_body.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
struct ContactArms {
  Vec3<real> normal, arm_a, arm_b;
};

template <class real>
struct ContactFrame {
  Vec3<real> normal, tangent_1, tangent_2, arm_a, arm_b;
};

/// Of a ContactBlock, or of a PatchBlock.
template <class real, class Block>
ContactArms<real> contact_arms(const Block& block, u32 lane) {
  return {{block.normal_x[lane], block.normal_y[lane], block.normal_z[lane]},
          {block.arm_a_x[lane], block.arm_a_y[lane], block.arm_a_z[lane]},
          {block.arm_b_x[lane], block.arm_b_y[lane], block.arm_b_z[lane]}};
}

template <class real, class Block>
ContactFrame<real> contact_frame(const Block& block, u32 lane) {
  const ContactArms<real> c = contact_arms<real>(block, lane);
  const auto [t1, t2] = tangents(c.normal);
  return {c.normal, t1, t2, c.arm_a, c.arm_b};
}

template <class real>
ConeVector<real> impulse_of(const ImpulseBlock<real>& block, u32 lane) {
  return {block.normal[lane], block.tangent_1[lane], block.tangent_2[lane]};
}

/// Inverse inertia times a moment, world frame; that of a central contact is the same about every axis that counts.
template <class real>
Vec3<real> angular_velocity_change(const Motion<real>& body, u32 kind, Vec3<real> moment) {
  return kind == BLOCK_GENERAL ? apply_inverse_inertia(body, moment) : scale3(body.inertia_xx, moment);
}

/// The velocity of a against b at the ends of the arms.
template <class real>
Vec3<real> velocity_at(Vec3<real> arm_a, Vec3<real> arm_b, const Motion<real>& a, const Motion<real>& b) {
  return sub3(add3(vec3(a.v), cross3(vec3(a.w), arm_a)), add3(vec3(b.v), cross3(vec3(b.w), arm_b)));
}

/// An impulse on a at the end of its arm, its opposite on b. Bodies that cannot move are never written
/// (contract rule 8).
template <class real>
void push_at(Vec3<real> arm_a, Vec3<real> arm_b, u32 kind, Vec3<real> impulse, Motion<real>& a, Motion<real>& b) {
  if (a.inverse_mass > 0) {
    store3(a.v, add3(vec3(a.v), scale3(a.inverse_mass, impulse)));
    store3(a.w, add3(vec3(a.w), angular_velocity_change(a, kind, cross3(arm_a, impulse))));
  }
  if (b.inverse_mass > 0) {
    store3(b.v, sub3(vec3(b.v), scale3(b.inverse_mass, impulse)));
    store3(b.w, sub3(vec3(b.w), angular_velocity_change(b, kind, cross3(arm_b, impulse))));
  }
}

/// A moment on a, its opposite on b.
template <class real>
void twist_by(u32 kind, Vec3<real> moment, Motion<real>& a, Motion<real>& b) {
  if (a.inverse_mass > 0) store3(a.w, add3(vec3(a.w), angular_velocity_change(a, kind, moment)));
  if (b.inverse_mass > 0) store3(b.w, sub3(vec3(b.w), angular_velocity_change(b, kind, moment)));
}

/// As a vector of the world.
template <class real>
Vec3<real> impulse_world(const ContactFrame<real>& c, ConeVector<real> r) {
  return add3(add3(scale3(r.normal, c.normal), scale3(r.tangent_1, c.tangent_1)), scale3(r.tangent_2, c.tangent_2));
}

template <class real>
void push(const ContactFrame<real>& c, u32 kind, ConeVector<real> r, Motion<real>& a, Motion<real>& b) {
  push_at(c.arm_a, c.arm_b, kind, impulse_world(c, r), a, b);
}

/// The moment on a of a contact with angular friction, N m s.
template <class real>
Vec3<real> angular_friction_moment(const ContactFrame<real>& c, const AngularFrictionBlock<real>& angular,
                                   const AngularFrictionImpulse<real>& angular_impulses, u32 lane) {
  return add3(add3(scale3(angular.torsion_radius[lane] * angular_impulses.torsion[lane], c.normal),
                   scale3(angular_impulses.roll_1[lane], c.tangent_1)),
              scale3(angular_impulses.roll_2[lane], c.tangent_2));
}

/// The larger of a change and those before it; what is no number does not count.
template <class real>
real larger(real change, real so_far) {
  return change > so_far ? change : so_far;
}

/// The square of what a change of its impulse makes of a contact's relative velocity.
template <class real>
real contact_change(const Delassus<real>& w, u32 kind, ConeVector<real> d) {
  ConeVector<real> u = {w.nn * d.normal, w.t11 * d.tangent_1, w.t11 * d.tangent_2};
  if (kind == BLOCK_GENERAL) {
    u = {w.nn * d.normal + w.n1 * d.tangent_1 + w.n2 * d.tangent_2,
         w.n1 * d.normal + w.t11 * d.tangent_1 + w.t12 * d.tangent_2,
         w.n2 * d.normal + w.t12 * d.tangent_1 + w.t22 * d.tangent_2};
  }
  return u.normal * u.normal + u.tangent_1 * u.tangent_1 + u.tangent_2 * u.tangent_2;
}

/// A contact's relative velocity, its bias added, in its frame.
template <class real>
ConeVector<real> biased_velocity(const ContactFrame<real>& c, ConeVector<real> bias, const Motion<real>& a,
                                 const Motion<real>& b) {
  const Vec3<real> u = velocity_at(c.arm_a, c.arm_b, a, b);
  return {dot3(c.normal, u) + bias.normal, dot3(c.tangent_1, u) + bias.tangent_1,
          dot3(c.tangent_2, u) + bias.tangent_2};
}

/// Returns the square of by how much it changed the relative velocity.
template <class real>
real solve_contact(const ContactBlock<real>& block, ConeVector<real> bias, real softness, ImpulseBlock<real>& impulses,
                   u32 kind, u32 lane, Motion<real>& a, Motion<real>& b) {
  const ContactFrame<real> c = contact_frame<real>(block, lane);
  const ConeVector<real> old = impulse_of(impulses, lane);
  const real friction = block.friction[lane];
  const Delassus<real> w = {block.w_nn[lane], block.w_11[lane], block.w_22[lane],
                            block.w_n1[lane], block.w_n2[lane], block.w_12[lane]};

  const auto [u_n, u_1, u_2] = biased_velocity(c, bias, a, b);
  ConeVector<real> r;
  if (kind == BLOCK_GENERAL) {
    const ConeVector<real> q = {u_n - (w.nn * old.normal + w.n1 * old.tangent_1 + w.n2 * old.tangent_2),
                                u_1 - (w.n1 * old.normal + w.t11 * old.tangent_1 + w.t12 * old.tangent_2),
                                u_2 - (w.n2 * old.normal + w.t12 * old.tangent_1 + w.t22 * old.tangent_2)};
    r = solve_general(q, {w.nn + softness, w.t11, w.t22, w.n1, w.n2, w.t12}, friction);
  } else {
    const ConeVector<real> q = {u_n - w.nn * old.normal, u_1 - w.t11 * old.tangent_1, u_2 - w.t11 * old.tangent_2};
    r = solve_central(q, w.nn + softness, w.t11, friction);
  }

  impulses.normal[lane] = r.normal;
  impulses.tangent_1[lane] = r.tangent_1;
  impulses.tangent_2[lane] = r.tangent_2;
  const ConeVector<real> d = {r.normal - old.normal, r.tangent_1 - old.tangent_1, r.tangent_2 - old.tangent_2};
  push(c, kind, d, a, b);
  return contact_change(w, kind, d);
}

}  // namespace lockstep::reference
