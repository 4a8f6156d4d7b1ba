// Keeps what the next step starts from: each contact's key and its impulse at rest in the world frame, the tangential
// part as a vector, so that it survives a turned tangent frame and a contact that changes its slot; where contacts
// have angular friction, their moment beside it.
#pragma once

#include "cpu_reference/solve_contact.hpp"

namespace lockstep::reference {

template <class real>
void store_impulses(Buffers<real>& buffers, const StepParams<real>&) {
  if (step_aborted(buffers.counters)) return;
  const u32 count = buffers.counters[COUNTER_CONTACTS];
  buffers.cached_count[0] = count;
  for (u32 i = 0; i < count; ++i) {
    const u32 row = buffers.contact_slots[i] / PACK, lane = buffers.contact_slots[i] % PACK;
    const ContactFrame<real> c = contact_frame<real>(buffers.contact_blocks[row], lane);
    const ConeVector<real> r = impulse_of(buffers.impulse_blocks[row], lane);
    const Vec3<real> t = add3(scale3(r.tangent_1, c.tangent_1), scale3(r.tangent_2, c.tangent_2));
    const Contact& contact = buffers.contacts[i];
    buffers.cached_keys[i] = {contact.shape_a, contact.shape_b, contact.feature, 0};
    buffers.cached_impulses[i] = {r.normal, t.x, t.y, t.z};
    if (buffers.angular_friction_blocks.empty()) continue;
    const Vec3<real> m =
        angular_friction_moment(c, buffers.angular_friction_blocks[row], buffers.angular_friction_impulses[row], lane);
    buffers.cached_moments[i] = {m.x, m.y, m.z, 0};
  }
}

}  // namespace lockstep::reference
