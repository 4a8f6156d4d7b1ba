// Gives each contact a colour so that contacts of one colour share no dynamic body and can be solved at once.
//
// Greedy, in the order of descending priority: a contact takes the lowest colour that is free on both of its dynamic
// bodies, MAX_COLORS (overflow) where none is. The priority is a bijection of the contact's rank in its world that
// looks random, so that Jones and Plassmann's parallel rounds (SIAM J. Sci. Comput. 14, 1993), which the kernel runs,
// find the same colours in few rounds. The number of rounds is part of the result: the plan of the next step comes from
// it.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "cpu_reference/math.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// Distinct for distinct ranks, never 0.
inline u32 color_priority(u32 rank) {
  u32 x = rank + 1;
  x = (x ^ (x >> 16)) * 0x9e3779b9u;
  x = (x ^ (x >> 15)) * 0x6a09e667u;
  return x ^ (x >> 16);
}

/// Lowest colour that is free in both words, MAX_COLORS where none is.
inline u32 color_lowest_free(u32 used_low, u32 used_high) {
  for (u32 color = 0; color < MAX_COLORS; ++color) {
    const u32 word = color < 32 ? used_low : used_high;
    if ((word & (1u << (color % 32))) == 0) return color;
  }
  return MAX_COLORS;
}

template <class real>
void color_contacts(Buffers<real>& buffers, const StepParams<real>& params) {
  const u32 count = buffers.counters[COUNTER_CONTACTS];
  std::vector<u32> priorities(count), order(count);
  for (u32 i = 0; i < count; ++i) priorities[i] = color_priority(buffers.contacts[i].rank);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](u32 i, u32 j) {
    return priorities[i] != priorities[j] ? priorities[i] > priorities[j] : i < j;  // equal only in different worlds
  });

  auto& masks = buffers.body_colors;
  std::fill(masks.begin(), masks.end(), 0u);
  // The last round that each body takes part in, and the round in which it ran out of colours: what is left on it is
  // given up in the next.
  std::vector<u32> last_round(params.bodies, 0), full_round(params.bodies, NONE);
  u32 rounds = 0;
  for (const u32 i : order) {
    const Contact& contact = buffers.contacts[i];
    u32 dynamic[2];
    u32 sides = 0;
    for (const u32 body : {contact.body_a, contact.body_b}) {
      if (buffers.body_infos[body].kind == BODY_DYNAMIC) dynamic[sides++] = body;
    }

    u32 low = 0, high = 0, waits = 0, given_up = NONE;
    for (u32 side = 0; side < sides; ++side) {
      const u32 body = dynamic[side];
      low |= masks[2 * body];
      high |= masks[2 * body + 1];
      waits = std::max(waits, last_round[body]);
      given_up = std::min(given_up, full_round[body]);
    }
    const u32 color = color_lowest_free(low, high);
    const u32 round = 1 + std::min(waits, given_up);
    buffers.contact_colors[i] = color;
    rounds = std::max(rounds, round);

    for (u32 side = 0; side < sides; ++side) {
      const u32 body = dynamic[side];
      last_round[body] = std::max(last_round[body], round);
      if (color == MAX_COLORS) continue;
      masks[2 * body + color / 32] |= 1u << (color % 32);
      if ((masks[2 * body] & masks[2 * body + 1]) == 0xffffffffu) full_round[body] = round;
    }
  }
  buffers.counters[COUNTER_ROUNDS] = rounds;
}

}  // namespace lockstep::reference
