// What the contacts of a pair share in a sub-step where they share one friction patch (cpu_reference/solve_patch.hpp):
// the centre of pressure under the impulses that they start from, the distances of the contacts from it, and the masses
// that friction and twist meet there. kernels/prepare_patch.h is the twin.
//
// Friction starts the step from the sum of what the contacts had, and their moment about the normal at the centre of
// pressure; later sub-steps from the last one, turned with the normal and moved to where the
// centre of pressure has gone.
#pragma once

#include "cpu_reference/body_copies.hpp"
#include "cpu_reference/solve_contact.hpp"

namespace lockstep::reference {

/// The mean of the ends of the arms, weighed by the normal impulses; where none presses yet, the plain mean. The
/// offsets are in the world frame.
template <class real>
struct PatchCentre {
  Vec3<real> arm_a, arm_b;
  Vec3<real> offsets[MANIFOLD_POINTS];
};

template <class real>
PatchCentre<real> patch_centre(const Buffers<real>& buffers, u32 first, u32 count, u32 lane) {
  real load = 0, points = 0;
  for (u32 k = 0; k < count; ++k) {
    load = load + buffers.impulse_blocks[first + k].normal[lane];
    points = points + real(1);
  }
  PatchCentre<real> centre;
  for (u32 k = 0; k < count; ++k) {
    const ContactArms<real> c = contact_arms<real>(buffers.contact_blocks[first + k], lane);
    const real share = load > 0 ? buffers.impulse_blocks[first + k].normal[lane] / load : real(1) / points;
    const Vec3<real> a = scale3(share, c.arm_a), b = scale3(share, c.arm_b);
    centre.arm_a = k == 0 ? a : add3(centre.arm_a, a);
    centre.arm_b = k == 0 ? b : add3(centre.arm_b, b);
  }
  for (u32 k = 0; k < count; ++k)
    centre.offsets[k] = sub3(contact_arms<real>(buffers.contact_blocks[first + k], lane).arm_a, centre.arm_a);
  return centre;
}

template <class real>
void clear_lane(PatchBlock<real>& block, PatchImpulse<real>& impulses, u32 lane) {
  for (real* field : {block.normal_x, block.normal_y, block.normal_z, block.arm_a_x, block.arm_a_y, block.arm_a_z,
                      block.arm_b_x, block.arm_b_y, block.arm_b_z, block.friction, block.inverse_11, block.inverse_12,
                      block.inverse_22, block.inverse_twist, impulses.tangent_1, impulses.tangent_2, impulses.twist})
    field[lane] = 0;
  for (auto& distance : block.distance) distance[lane] = 0;
}

/// The rows of the pair are prepared; `block` and `impulses` still hold the last sub-step.
template <class real>
void prepare_patch(const Buffers<real>& buffers, const StepParams<real>& params, const PairMotions<real>& motions,
                   u32 count, u32 lane, u32 first, PatchBlock<real>& block, PatchImpulse<real>& impulses) {
  const Motion<real>&a = motions.a, &b = motions.b;
  const ContactFrame<real> row = contact_frame<real>(buffers.contact_blocks[first], lane);
  const Vec3<real> n = row.normal, t1 = row.tangent_1, t2 = row.tangent_2;
  const PatchCentre<real> centre = patch_centre(buffers, first, count, lane);

  Vec3<real> tangent = {0, 0, 0};
  real twist = 0;
  if (params.substep == 0) {
    for (u32 k = 0; k < count; ++k) {
      const ContactFrame<real> c = contact_frame<real>(buffers.contact_blocks[first + k], lane);
      const ConeVector<real> r = impulse_of(buffers.impulse_blocks[first + k], lane);
      const Vec3<real> t = add3(scale3(r.tangent_1, c.tangent_1), scale3(r.tangent_2, c.tangent_2));
      tangent = k == 0 ? t : add3(tangent, t);
      const real moment = dot3(n, cross3(centre.offsets[k], t));
      twist = k == 0 ? moment : twist + moment;
    }
  } else {
    const ContactFrame<real> old = contact_frame<real>(block, lane);
    tangent = add3(scale3(impulses.tangent_1[lane], old.tangent_1), scale3(impulses.tangent_2[lane], old.tangent_2));
    twist = impulses.twist[lane] + dot3(n, cross3(sub3(old.arm_a, centre.arm_a), tangent));
  }
  impulses.tangent_1[lane] = dot3(tangent, t1);
  impulses.tangent_2[lane] = dot3(tangent, t2);
  impulses.twist[lane] = twist;

  const Vec3<real> a_1 = cross3(centre.arm_a, t1), a_2 = cross3(centre.arm_a, t2);
  const Vec3<real> b_1 = cross3(centre.arm_b, t1), b_2 = cross3(centre.arm_b, t2);
  const Vec3<real> response_a = apply_inverse_inertia(a, a_2), response_b = apply_inverse_inertia(b, b_2);
  const real inverse_mass = a.inverse_mass + b.inverse_mass;
  const real w_11 =
      inverse_mass + (dot3(a_1, apply_inverse_inertia(a, a_1)) + dot3(b_1, apply_inverse_inertia(b, b_1)));
  const real w_22 = inverse_mass + (dot3(a_2, response_a) + dot3(b_2, response_b));
  const real w_12 = dot3(a_1, response_a) + dot3(b_1, response_b);
  const real w_twist = dot3(n, apply_inverse_inertia(a, n)) + dot3(n, apply_inverse_inertia(b, n));
  const real inverse = real(1) / (w_11 * w_22 - w_12 * w_12);

  block.normal_x[lane] = n.x;
  block.normal_y[lane] = n.y;
  block.normal_z[lane] = n.z;
  block.arm_a_x[lane] = centre.arm_a.x;
  block.arm_a_y[lane] = centre.arm_a.y;
  block.arm_a_z[lane] = centre.arm_a.z;
  block.arm_b_x[lane] = centre.arm_b.x;
  block.arm_b_y[lane] = centre.arm_b.y;
  block.arm_b_z[lane] = centre.arm_b.z;
  block.friction[lane] = buffers.contact_blocks[first].friction[lane];
  for (u32 k = 0; k < MANIFOLD_POINTS; ++k) block.distance[k][lane] = k < count ? length3(centre.offsets[k]) : real(0);
  block.inverse_11[lane] = w_22 * inverse;
  block.inverse_12[lane] = -w_12 * inverse;
  block.inverse_22[lane] = w_11 * inverse;
  block.inverse_twist[lane] = w_twist > 0 ? real(1) / w_twist : real(0);
}

}  // namespace lockstep::reference
