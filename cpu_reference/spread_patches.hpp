// After the last sub-step, spreads the friction and the twist of each pair that shares one friction patch over its
// contacts, in proportion to their normal impulses: what the next step starts from, and what the report holds against
// the model of a cone for each contact. With d_k from the centre of pressure to a contact and n the normal,
//   t_k = r_k / (sum r) t + r_k twist / (sum r |n x d|^2) (n x d_k).
#pragma once

#include "cpu_reference/solve_contact.hpp"

namespace lockstep::reference {

template <class real>
void spread_patch(const std::vector<ContactBlock<real>>& contacts, const PatchBlock<real>& block,
                  const PatchImpulse<real>& patch, u32 first, u32 count, u32 lane,
                  std::vector<ImpulseBlock<real>>& rows) {
  const ContactFrame<real> centre = contact_frame<real>(block, lane);
  const auto around = [&](u32 k) {
    return cross3(centre.normal, sub3(contact_arms<real>(contacts[first + k], lane).arm_a, centre.arm_a));
  };
  real load = 0, swing = 0;
  for (u32 k = 0; k < count; ++k) {
    const real r = rows[first + k].normal[lane];
    load = load + r;
    swing = swing + r * dot3(around(k), around(k));
  }
  const real along = load > 0 ? real(1) / load : real(0), about = swing > 0 ? patch.twist[lane] / swing : real(0);
  const Vec3<real> tangent = scale3(
      along, add3(scale3(patch.tangent_1[lane], centre.tangent_1), scale3(patch.tangent_2[lane], centre.tangent_2)));
  for (u32 k = 0; k < count; ++k) {
    const ContactFrame<real> c = contact_frame<real>(contacts[first + k], lane);
    ImpulseBlock<real>& row = rows[first + k];
    const Vec3<real> t = scale3(row.normal[lane], add3(tangent, scale3(about, around(k))));
    row.tangent_1[lane] = dot3(t, c.tangent_1);
    row.tangent_2[lane] = dot3(t, c.tangent_2);
  }
}

template <class real>
void spread_patches(Buffers<real>& buffers, const StepParams<real>&) {
  if (step_aborted(buffers.counters)) return;
  for (u32 block = 0; block < buffers.counters[COUNTER_BLOCKS]; ++block) {
    for (u32 lane = 0; lane < PACK; ++lane) {
      const u32 count = buffers.block_bodies[block].count[lane];
      if (count > 0)
        spread_patch(buffers.contact_blocks, buffers.patch_blocks[block], buffers.patch_impulses[block],
                     buffers.block_rows[block].first, count, lane, buffers.impulse_blocks);
    }
  }
}

}  // namespace lockstep::reference
