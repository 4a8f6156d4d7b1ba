// The contacts of one pair of shapes (cpu_reference/pair_contacts.hpp).
#ifndef LOCKSTEP_PAIR_CONTACTS_H
#define LOCKSTEP_PAIR_CONTACTS_H

#include "types.h"

static inline bool pair_contacts_same(global const Contact* contacts, u32 i, u32 j) {
  return contacts[i].shape_a == contacts[j].shape_a && contacts[i].shape_b == contacts[j].shape_b;
}

// Whether contact i is the first of its pair.
static inline bool pair_contact_is_first(global const Contact* contacts, u32 i) {
#if FEATURE_MANIFOLDS
  return i == 0u || !pair_contacts_same(contacts, i, i - 1u);
#else
  return true;
#endif
}

// How many contacts the pair has that contact i is the first of; 0 where it is not the first.
static inline u32 pair_contact_count(global const Contact* contacts, u32 i, u32 contact_count) {
  if (!pair_contact_is_first(contacts, i)) return 0u;
  u32 count = 1u;
#if FEATURE_MANIFOLDS
  while (i + count < contact_count && pair_contacts_same(contacts, i, i + count)) ++count;
#endif
  return count;
}

// First contact of the worlds from `world` on.
static inline u32 first_contact_of_world(u32 world, u32 count, global const Contact* contacts) {
  u32 begin = 0u, end = count;
  while (begin < end) {
    const u32 middle = begin + (end - begin) / 2u;
    if (contacts[middle].world < world)
      begin = middle + 1u;
    else
      end = middle;
  }
  return begin;
}

#endif
