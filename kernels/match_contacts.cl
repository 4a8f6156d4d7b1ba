#pragma OPENCL FP_CONTRACT OFF
// Finds the impulses that contacts start from (cpu_reference/match_contacts.hpp).
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

#if FEATURE_SOFT_CONTACTS
static inline bool match_is_pair(u32 shape_a, u32 shape_b, const Contact contact) {
  return shape_a == contact.shape_a && shape_b == contact.shape_b;
}

static inline ContactImpulse match_add_share(ContactImpulse to, real share, ContactImpulse r) {
  to.normal = to.normal + share * r.normal;
  to.tangent_x = to.tangent_x + share * r.tangent_x;
  to.tangent_y = to.tangent_y + share * r.tangent_y;
  to.tangent_z = to.tangent_z + share * r.tangent_z;
  return to;
}

// What contact i starts from where its pair has lost others; `key` is the first that is not before it, `begin` and
// `end` those of its shape a.
static inline ContactImpulse match_hand_over(u32 i, u32 contact_count, global const Contact* contacts, u32 key,
                                             u32 begin, u32 end, global const ContactKey* cached_keys,
                                             global const ContactImpulse* cached_impulses, bool known,
                                             ContactImpulse own) {
  const Contact contact = contacts[i];
  u32 first_key = key, first = i, last = i + 1u;
  while (first_key > begin && cached_keys[first_key - 1u].shape_b == contact.shape_b) --first_key;
  while (first > 0u && match_is_pair(contacts[first - 1u].shape_a, contacts[first - 1u].shape_b, contact)) --first;
  while (last < contact_count && match_is_pair(contacts[last].shape_a, contacts[last].shape_b, contact)) ++last;

  ContactImpulse lost = {(real)0, (real)0, (real)0, (real)0};
  u32 stay = 0u, at = first, k = first_key;
  for (; k < end && cached_keys[k].shape_b == contact.shape_b; ++k) {
    while (at < last && contacts[at].feature < cached_keys[k].feature) ++at;
    const bool stays = at < last && contacts[at].feature == cached_keys[k].feature;
    stay += stays ? 1u : 0u;
    if (!stays) lost = match_add_share(lost, (real)1, cached_impulses[k]);
  }
  const u32 fresh = last - first - stay;
  if (stay == k - first_key || (fresh > 0u && known)) return own;
  return match_add_share(own, (real)1 / (real)(fresh > 0u ? fresh : last - first), lost);
}
#endif

kernel void match_contacts(global const Contact* contacts, global const ContactKey* cached_keys,
                           global const ContactImpulse* cached_impulses, global const u32* cached_starts,
                           global ContactImpulse* start_impulses, global const u32* counters) {
  FOR_EACH(i, counters[COUNTER_CONTACTS]) {
    const Contact contact = contacts[i];
    const u32 end = cached_starts[contact.shape_a + 1u];
    // the first key of the shape that is not before the contact
    const u32 begin = cached_starts[contact.shape_a];
    u32 low = begin, high = end;
    while (low < high) {
      const u32 middle = low + (high - low) / 2u;
      if (match_before(cached_keys[middle], contact)) {
        low = middle + 1u;
      } else {
        high = middle;
      }
    }
    ContactImpulse impulse = {(real)0, (real)0, (real)0, (real)0};
    const bool known =
        low < end && cached_keys[low].shape_b == contact.shape_b && cached_keys[low].feature == contact.feature;
    if (known) impulse = cached_impulses[low];
#if FEATURE_SOFT_CONTACTS
    impulse = match_hand_over(i, counters[COUNTER_CONTACTS], contacts, low, begin, end, cached_keys, cached_impulses,
                              known, impulse);
#endif
    start_impulses[i] = impulse;
  }
}
