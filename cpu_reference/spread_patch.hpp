// How the friction and the twist of a pair that shares one friction patch are spread over its contacts: in proportion
// to their normal impulses. With d_k from the centre of pressure to a contact and n the normal,
//   t_k = r_k / (sum r) t + r_k twist / (sum r |n x d|^2) (n x d_k).
// kernels/spread_patch.h is the twin, LANES pairs at a time.
#pragma once

#include <vector>

#include "cpu_reference/solve_contact.hpp"

namespace lockstep::reference {

template <class real>
struct PatchSpread {
  Vec3<real> normal, centre, tangent;  // for a unit of normal impulse
  Vec3<real> rest;                     // of the friction, for each contact: what these shares leave
  real about;                          // of the twist, for a unit of normal impulse at a unit of distance
};

/// From the centre of pressure to the contact, turned by a right angle about the normal.
template <class real>
Vec3<real> spread_around(const ContactBlock<real>& row, u32 lane, Vec3<real> normal, Vec3<real> centre) {
  return cross3(normal, sub3(contact_arms<real>(row, lane).arm_a, centre));
}

/// Of the pair whose contacts are in `count` rows from `first` on.
template <class real>
PatchSpread<real> spread_of(const std::vector<ContactBlock<real>>& contacts,
                            const std::vector<ImpulseBlock<real>>& impulses, u32 first, u32 count, u32 lane,
                            const PatchBlock<real>& block, const PatchImpulse<real>& patch) {
  const ContactFrame<real> c = contact_frame<real>(block, lane);
  real load = 0, swing = 0;
  Vec3<real> drift = {0, 0, 0};
  for (u32 k = 0; k < count; ++k) {
    const Vec3<real> around = spread_around(contacts[first + k], lane, c.normal, c.arm_a);
    const real r = impulses[first + k].normal[lane];
    load = load + r;
    swing = swing + r * dot3(around, around);
    drift = add3(drift, scale3(r, around));
  }
  const real along = load > 0 ? real(1) / load : real(0), about = swing > 0 ? patch.twist[lane] / swing : real(0);
  const Vec3<real> tangent =
      add3(scale3(patch.tangent_1[lane], c.tangent_1), scale3(patch.tangent_2[lane], c.tangent_2));
  const Vec3<real> left = scale3(load > 0 ? real(0) : real(1), tangent);
  const Vec3<real> rest = scale3(real(1) / static_cast<real>(count), sub3(left, scale3(about, drift)));
  return {c.normal, c.arm_a, scale3(along, tangent), rest, about};
}

/// What a contact gets along its tangents, beside its normal impulse.
template <class real>
ConeVector<real> spread_to(const PatchSpread<real>& spread, const ContactBlock<real>& row, u32 lane, real normal) {
  const ContactFrame<real> c = contact_frame<real>(row, lane);
  const Vec3<real> around = spread_around(row, lane, spread.normal, spread.centre);
  const Vec3<real> t = scale3(normal, add3(spread.tangent, scale3(spread.about, around)));
  return {normal, dot3(t, c.tangent_1), dot3(t, c.tangent_2)};
}

}  // namespace lockstep::reference
