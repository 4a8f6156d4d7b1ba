#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "types.h"

static inline bool match_before(ContactKey key, Contact contact) {
  if (key.shape_a != contact.shape_a) return key.shape_a < contact.shape_a;
  if (key.shape_b != contact.shape_b) return key.shape_b < contact.shape_b;
  return key.feature < contact.feature;
}

kernel void match_contacts(global const Contact* contacts, global const u32* cached_count,
                           global const ContactKey* cached_keys, global const ContactImpulse* cached_impulses,
                           global ContactImpulse* start_impulses, global const u32* counters) {
  const u32 cached = cached_count[0];
  FOR_EACH(i, counters[COUNTER_CONTACTS]) {
    const Contact contact = contacts[i];
    // the first key that is not before the contact
    u32 low = 0u, high = cached;
    while (low < high) {
      const u32 middle = low + (high - low) / 2u;
      if (match_before(cached_keys[middle], contact)) {
        low = middle + 1u;
      } else {
        high = middle;
      }
    }
    ContactImpulse impulse = {(real)0, (real)0, (real)0, (real)0};
    if (low < cached) {
      const ContactKey key = cached_keys[low];
      const bool known =
          key.shape_a == contact.shape_a && key.shape_b == contact.shape_b && key.feature == contact.feature;
      if (known) impulse = cached_impulses[low];
    }
    start_impulses[i] = impulse;
  }
}
