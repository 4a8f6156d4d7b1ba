// Warm start across steps: a contact begins with the impulse that the contact of the same shapes and feature ended the
// last step with (Catto, Iterative Dynamics with Temporal Coherence, 2005).
//
// Two shapes that lie on each other change features while they settle: a face becomes two edges and a face again, a
// corner the crossing of two edges in the same place. Where contacts are soft, a sub-step has a sweep or two, too few
// to find a load from nothing; so what the contacts of a pair carried whose features are gone is handed over: to the
// new ones of the pair, in equal parts, or to all of them where none is new. The pair goes on with the sum that it had.
//
// What a body that has just woken touched when it fell asleep is found among what sleepers keep.
#pragma once

#include <algorithm>
#include <tuple>
#include <vector>

#include "cpu_reference/sleep.hpp"

namespace lockstep::reference {

inline bool is_before(const ContactKey& key, const Contact& contact) {
  return std::tie(key.shape_a, key.shape_b, key.feature) < std::tie(contact.shape_a, contact.shape_b, contact.feature);
}
template <class A, class B>
bool is_same_pair(const A& a, const B& b) {
  return a.shape_a == b.shape_a && a.shape_b == b.shape_b;
}

template <class real>
ContactImpulse<real> add_share(const ContactImpulse<real>& to, real share, const ContactImpulse<real>& r) {
  return {to.normal + share * r.normal, to.tangent_x + share * r.tangent_x, to.tangent_y + share * r.tangent_y,
          to.tangent_z + share * r.tangent_z};
}

template <class real>
Vec4<real> add_share(const Vec4<real>& to, real share, const Vec4<real>& m) {
  return {to.x + share * m.x, to.y + share * m.y, to.z + share * m.z, 0};
}

/// Where the impulses are that a contact may start from, in order; and the moments, where contacts have angular
/// friction.
template <class real>
struct KnownImpulses {
  const std::vector<ContactKey>& keys;
  const std::vector<ContactImpulse<real>>& impulses;
  const std::vector<Vec4<real>>& moments;
  u32 count;
};
template <class real>
KnownImpulses<real> impulses_before(const Buffers<real>& b, const Contact& contact) {
  const auto woken = [&](u32 body) { return !b.sleepers.empty() && b.sleepers[body].island == ISLAND_WAKES; };
  if (woken(contact.body_a) || woken(contact.body_b))
    return {b.slept_keys, b.slept_impulses, b.slept_moments, b.slept_count[0]};
  return {b.cached_keys, b.cached_impulses, b.cached_moments, b.cached_count[0]};
}

/// What the last step knew about a contact: the first key that is not before it, which is its own or none.
struct KnownContact {
  u32 key;
  bool known;
};
template <class real>
KnownContact known_contact(const KnownImpulses<real>& before, const Contact& contact) {
  const auto end = before.keys.begin() + before.count;
  const auto key = std::lower_bound(before.keys.begin(), end, contact, is_before);
  const bool known = key != end && is_same_pair(*key, contact) && key->feature == contact.feature;
  return {static_cast<u32>(key - before.keys.begin()), known};
}

/// Hands over what the pair has lost. Contacts first .. end - 1 are those of a pair, in the order of their features, as
/// the keys are.
template <class real>
void hand_over(Buffers<real>& b, u32 first, u32 end) {
  const KnownImpulses<real> before = impulses_before(b, b.contacts[first]);
  Contact start = b.contacts[first];
  start.feature = 0;
  const bool has_moments = !b.cached_moments.empty();
  ContactImpulse<real> lost = {0, 0, 0, 0};
  Vec4<real> lost_moment = {0, 0, 0, 0};
  u32 known = 0, contact = first;
  const u32 begin = known_contact(before, start).key;
  u32 key = begin;
  for (; key < before.count && is_same_pair(before.keys[key], start); ++key) {
    while (contact < end && b.contacts[contact].feature < before.keys[key].feature) ++contact;
    const bool stays = contact < end && b.contacts[contact].feature == before.keys[key].feature;
    known += stays ? 1 : 0;
    if (!stays) lost = add_share(lost, real(1), before.impulses[key]);
    if (!stays && has_moments) lost_moment = add_share(lost_moment, real(1), before.moments[key]);
  }
  if (known == key - begin) return;
  const u32 fresh = end - first - known;
  const real share = real(1) / real(fresh > 0 ? fresh : end - first);
  for (u32 i = first; i < end; ++i) {
    const bool takes = fresh == 0 || !known_contact(before, b.contacts[i]).known;
    if (takes) b.start_impulses[i] = add_share(b.start_impulses[i], share, lost);
    if (takes && has_moments) b.start_moments[i] = add_share(b.start_moments[i], share, lost_moment);
  }
}

/// New contacts begin with zero, or with what is handed over. The cache is ordered as contacts are.
template <class real>
void match_contacts(Buffers<real>& b, const StepParams<real>&) {
  const u32 count = b.counters[COUNTER_CONTACTS];
  for (u32 i = 0; i < count; ++i) {
    const KnownImpulses<real> before = impulses_before(b, b.contacts[i]);
    const KnownContact same = known_contact(before, b.contacts[i]);
    b.start_impulses[i] = same.known ? before.impulses[same.key] : ContactImpulse<real>{0, 0, 0, 0};
    if (!b.start_moments.empty()) b.start_moments[i] = same.known ? before.moments[same.key] : Vec4<real>{0, 0, 0, 0};
  }
  if (b.softness_blocks.empty()) return;
  for (u32 first = 0, end = 0; first < count; first = end) {
    while (end < count && is_same_pair(b.contacts[end], b.contacts[first])) ++end;
    hand_over(b, first, end);
  }
}

}  // namespace lockstep::reference
