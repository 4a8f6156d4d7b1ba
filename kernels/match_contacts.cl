#pragma OPENCL FP_CONTRACT OFF
// Finds the impulses that contacts start from (cpu_reference/match_contacts.hpp).
#include "common.h"
#include "sleep.h"
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

static inline bool match_is_pair(const Contact a, const Contact b) {
  return a.shape_a == b.shape_a && a.shape_b == b.shape_b;
}

static inline ContactImpulse match_add_share(ContactImpulse to, real share, ContactImpulse r) {
  to.normal = to.normal + share * r.normal;
  to.tangent_x = to.tangent_x + share * r.tangent_x;
  to.tangent_y = to.tangent_y + share * r.tangent_y;
  to.tangent_z = to.tangent_z + share * r.tangent_z;
  return to;
}

// Where no contact has angular friction there are no moments.
#if FEATURE_ANGULAR_FRICTION
#define MATCH_MOMENT(key) moments[key]
#else
#define MATCH_MOMENT(key) no_moment
#endif

static inline Vec4 match_add_moment(Vec4 to, real share, Vec4 m) {
  to.x = to.x + share * m.x;
  to.y = to.y + share * m.y;
  to.z = to.z + share * m.z;
  to.w = (real)0;
  return to;
}

#if FEATURE_SLEEPING
// How many keys have a shape a that is below this one.
static inline u32 match_first_key(global const ContactKey* keys, u32 count, u32 shape_a) {
  u32 low = 0u, high = count;
  while (low < high) {
    const u32 middle = low + (high - low) / 2u;
    if (keys[middle].shape_a < shape_a) {
      low = middle + 1u;
    } else {
      high = middle;
    }
  }
  return low;
}
#endif

// The first contact of a pair does the work of all: contacts and keys are in the same order.
kernel void match_contacts(global const Contact* contacts, global const ContactKey* cached_keys,
                           global const ContactImpulse* cached_impulses, global const Vec4* cached_moments,
                           global const u32* cached_starts, global const Sleeper* sleepers,
                           global const u32* slept_count, global const ContactKey* slept_keys,
                           global const ContactImpulse* slept_impulses, global const Vec4* slept_moments,
                           global ContactImpulse* start_impulses, global Vec4* start_moments,
                           global const u32* counters) {
  const u32 count = counters[COUNTER_CONTACTS];
  const ContactImpulse none = {(real)0, (real)0, (real)0, (real)0};
  const Vec4 no_moment = {(real)0, (real)0, (real)0, (real)0};
  FOR_EACH(first, count) {
    const Contact pair = contacts[first];
    if (first > 0u && match_is_pair(contacts[first - 1u], pair)) continue;
    global const ContactKey* keys = cached_keys;
    global const ContactImpulse* impulses = cached_impulses;
#if FEATURE_ANGULAR_FRICTION
    global const Vec4* moments = cached_moments;
#endif
    u32 key = cached_starts[pair.shape_a], end = cached_starts[pair.shape_a + 1u];
#if FEATURE_SLEEPING
    if (wakes(sleepers, pair.body_a) || wakes(sleepers, pair.body_b)) {
      keys = slept_keys;
      impulses = slept_impulses;
#if FEATURE_ANGULAR_FRICTION
      moments = slept_moments;
#endif
      key = match_first_key(slept_keys, slept_count[0], pair.shape_a);
      end = match_first_key(slept_keys, slept_count[0], pair.shape_a + 1u);
    }
#endif
    u32 high = end;
    while (key < high) {
      const u32 middle = key + (high - key) / 2u;
      if (keys[middle].shape_b < pair.shape_b) {
        key = middle + 1u;
      } else {
        high = middle;
      }
    }

    ContactImpulse lost = none;
    Vec4 lost_moment = no_moment;
    u32 gone = 0u, known = 0u, fresh = 0u;  // `known`: a bit for each contact
    u32 last = first;
    for (; last < count && match_is_pair(contacts[last], pair); ++last) {
      const u32 feature = contacts[last].feature;
      for (; key < end && keys[key].shape_b == pair.shape_b && keys[key].feature < feature; ++key) {
        lost = match_add_share(lost, (real)1, impulses[key]);
        lost_moment = match_add_moment(lost_moment, (real)1, MATCH_MOMENT(key));
        ++gone;
      }
      const bool is_known = key < end && keys[key].shape_b == pair.shape_b && keys[key].feature == feature;
      start_impulses[last] = is_known ? impulses[key] : none;
#if FEATURE_ANGULAR_FRICTION
      start_moments[last] = is_known ? moments[key] : no_moment;
#endif
      known |= is_known ? 1u << (last - first) : 0u;
      fresh += is_known ? 0u : 1u;
      key += is_known ? 1u : 0u;
    }
#if FEATURE_SOFT_CONTACTS
    for (; key < end && keys[key].shape_b == pair.shape_b; ++key, ++gone) {
      lost = match_add_share(lost, (real)1, impulses[key]);
      lost_moment = match_add_moment(lost_moment, (real)1, MATCH_MOMENT(key));
    }
    if (gone == 0u) continue;
    const real share = (real)1 / (real)(fresh > 0u ? fresh : last - first);
    for (u32 i = first; i < last; ++i) {
      const bool takes = fresh == 0u || (known >> (i - first) & 1u) == 0u;
      if (takes) start_impulses[i] = match_add_share(start_impulses[i], share, lost);
#if FEATURE_ANGULAR_FRICTION
      if (takes) start_moments[i] = match_add_moment(start_moments[i], share, lost_moment);
#endif
    }
#endif
  }
}
