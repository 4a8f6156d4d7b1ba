// The contacts of one pair of shapes follow one another in the list. They share their bodies, so that they take one
// colour and one lane of a block between them.
#pragma once

#include "host/buffers.hpp"

namespace lockstep::reference {

/// How many contacts the pair has that contact `i` is the first of; 0 where it is not the first.
template <class real>
u32 pair_contact_count(const Buffers<real>& b, u32 i) {
  const auto same_pair = [&](u32 j) {
    return b.contacts[j].shape_a == b.contacts[i].shape_a && b.contacts[j].shape_b == b.contacts[i].shape_b;
  };
  if (i > 0 && same_pair(i - 1)) return 0;
  u32 count = 1;
  while (i + count < b.counters[COUNTER_CONTACTS] && same_pair(i + count)) ++count;
  return count;
}

}  // namespace lockstep::reference
