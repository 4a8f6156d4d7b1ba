// Warm start across steps: a contact begins with the impulse that the contact of the same shapes and feature ended the
// last step with (Catto, Iterative Dynamics with Temporal Coherence, 2005).
#pragma once

#include <algorithm>
#include <tuple>

#include "host/buffers.hpp"

namespace lockstep::reference {

/// New contacts begin with zero. The cache is ordered as contacts are.
template <class real>
void match_contacts(Buffers<real>& b, const StepParams<real>&) {
  const auto before = [](const ContactKey& key, const Contact& contact) {
    return std::tie(key.shape_a, key.shape_b, key.feature) <
           std::tie(contact.shape_a, contact.shape_b, contact.feature);
  };
  const auto end = b.cached_keys.begin() + b.cached_count[0];
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
    const Contact& contact = b.contacts[i];
    const auto key = std::lower_bound(b.cached_keys.begin(), end, contact, before);
    const bool known = key != end && key->shape_a == contact.shape_a && key->shape_b == contact.shape_b &&
                       key->feature == contact.feature;
    b.start_impulses[i] = known ? b.cached_impulses[key - b.cached_keys.begin()] : ContactImpulse<real>{0, 0, 0, 0};
  }
}

}  // namespace lockstep::reference
