#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "types.h"

// Where the keys of each shape a begin: entry s is the number of keys whose shape_a is below s.
kernel void match_contacts_index(global const u32* cached_count, global const ContactKey* cached_keys,
                                 global u32* cached_starts, const StepParams params) {
  const u32 cached = cached_count[0];
  FOR_EACH(k, cached + 1u) {
    const u32 first = k > 0u ? cached_keys[k - 1u].shape_a + 1u : 0u;
    const u32 last = k < cached ? cached_keys[k].shape_a : params.shapes;
    for (u32 shape = first; shape <= last; ++shape) cached_starts[shape] = k;
  }
}

static inline bool match_before(ContactKey key, Contact contact) {
  if (key.shape_b != contact.shape_b) return key.shape_b < contact.shape_b;
  return key.feature < contact.feature;
}

kernel void match_contacts(global const Contact* contacts, global const ContactKey* cached_keys,
                           global const ContactImpulse* cached_impulses, global const u32* cached_starts,
                           global ContactImpulse* start_impulses, global const u32* counters) {
  FOR_EACH(i, counters[COUNTER_CONTACTS]) {
    const Contact contact = contacts[i];
    const u32 end = cached_starts[contact.shape_a + 1u];
    // the first key of the shape that is not before the contact
    u32 low = cached_starts[contact.shape_a], high = end;
    while (low < high) {
      const u32 middle = low + (high - low) / 2u;
      if (match_before(cached_keys[middle], contact)) {
        low = middle + 1u;
      } else {
        high = middle;
      }
    }
    ContactImpulse impulse = {(real)0, (real)0, (real)0, (real)0};
    if (low < end && cached_keys[low].shape_b == contact.shape_b && cached_keys[low].feature == contact.feature)
      impulse = cached_impulses[low];
    start_impulses[i] = impulse;
  }
}
