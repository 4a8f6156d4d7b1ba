// The order of the visits: what the solver's sweeps and the warm start share. kernels/sweep_contacts.h is the twin.
#pragma once

#include "cpu_reference/purpose.hpp"
#include "cpu_reference/visit_contact.hpp"
#include "cpu_reference/visit_patch.hpp"

namespace lockstep::reference {

/// Calls visit(bodies, block, lane) for every pair, colour after colour and overflow block after overflow block: as
/// blocks are laid out in that order, simply one after another.
template <class real, class Visit>
void for_each_pair_slot(const Buffers<real>& buffers, Visit&& visit) {
  if (buffers.color_starts.empty()) return;  // a scene of joints alone
  for (u32 block = 0; block < buffers.color_starts[MAX_COLORS + 1]; ++block) {
    for (u32 lane = 0; lane < PACK; ++lane) {
      if (buffers.block_bodies[block].count[lane] > 0) visit(buffers.block_bodies[block], block, lane);
    }
  }
}

/// The law of the normal velocity, u_n + bias + softness r_n >= 0: soft contacts relax into hard ones without a bias
/// (cpu_reference/relax_constraints.hpp).
template <class real>
struct LawNow {
  real bias, softness;
};

template <class real>
LawNow<real> law_now(Purpose purpose, const Buffers<real>& buffers, u32 row, u32 lane) {
  const real bias = buffers.contact_blocks[row].bias[lane];
  const real softness = buffers.softness_blocks.empty() ? real(0) : buffers.softness_blocks[row].softness[lane];
  if (purpose == Purpose::solve) return {bias, softness};
  return {softness > 0 ? real(0) : bias, 0};
}

/// One sweep over all pairs.
template <class real>
void sweep_contacts(Purpose purpose, Buffers<real>& buffers) {
  for_each_pair_slot(buffers, [&](const BlockBodies& bodies, u32 block, u32 lane) {
    Motion<real>&a = buffers.motions[bodies.body_a[lane]], &b = buffers.motions[bodies.body_b[lane]];
    const u32 first = buffers.block_rows[block].first, count = bodies.count[lane];
    const auto visit_each = [&](auto&& visit) {  // contact of the pair, one after another
      for (u32 row = first; row < first + count; ++row) {
        const LawNow<real> law = law_now(purpose, buffers, row, lane);
        visit(buffers.contact_blocks[row], law, buffers.impulse_blocks[row]);
      }
    };
    if (buffers.patch_blocks.empty()) {
      visit_each([&](const auto& contact, LawNow<real> law, auto& impulses) {
        visit_contact(contact, law.bias, law.softness, impulses, bodies.kind[lane], lane, a, b);
      });
      return;
    }
    const auto visit = [&](const auto& contact, LawNow<real> law, auto& impulses) {
      visit_normal(contact, law.bias, law.softness, impulses, lane, a, b);
    };
    visit_each(visit);
    visit_rubbing(buffers.patch_blocks[block], buffers.impulse_blocks, first, count, buffers.patch_impulses[block],
                  lane, a, b);
    visit_each(visit);
  });
}

/// Gives the bodies the impulses that the contacts start from.
template <class real>
void start_contacts(Buffers<real>& buffers) {
  for_each_pair_slot(buffers, [&](const BlockBodies& bodies, u32 block, u32 lane) {
    Motion<real>&a = buffers.motions[bodies.body_a[lane]], &b = buffers.motions[bodies.body_b[lane]];
    const u32 first = buffers.block_rows[block].first, end = first + bodies.count[lane];
    const bool rubs_as_one = !buffers.patch_blocks.empty();
    for (u32 row = first; row < end; ++row) {
      if (rubs_as_one)
        start_normal(buffers.contact_blocks[row], buffers.impulse_blocks[row], lane, a, b);
      else
        push(contact_frame<real>(buffers.contact_blocks[row], lane), bodies.kind[lane],
             impulse_of(buffers.impulse_blocks[row], lane), a, b);
    }
    if (rubs_as_one) start_rubbing(buffers.patch_blocks[block], buffers.patch_impulses[block], lane, a, b);
  });
}

}  // namespace lockstep::reference
