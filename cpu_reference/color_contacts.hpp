// Gives each pair in contact a colour so that pairs of one colour share no dynamic body and can be solved at once. The
// first contact of a pair carries its colour.
//
// Greedy: one pair after another takes the lowest colour that is free on both of its dynamic bodies, MAX_COLORS
// (overflow) where none is. The order is that of the ranks of
// their first contacts in their world, taken class by class modulo 64, where the
// next class lies 39 places on (64 divided by the golden ratio): neighbours in the list, which share a body, lie far
// apart in the order. So the parallel rounds of Jones and Plassmann (SIAM J. Sci. Comput. 14, 1993), which find the
// same colours from the order as a priority, need no more of them than with random priorities (measured: fewer), and a
// serial sweep needs no sorting.
#pragma once

#include <algorithm>
#include <vector>

#include "cpu_reference/math.hpp"
#include "cpu_reference/pair_contacts.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// Place in the order: distinct for distinct ranks.
inline u32 color_place(u32 rank) { return rank * 39u % 64u << 26 | rank >> 6; }

template <class real>
void color_contacts(Buffers<real>& buffers, const StepParams<real>&) {
  std::vector<u32> order;
  for (u32 i = 0; i < buffers.counters[COUNTER_CONTACTS]; ++i) {
    if (pair_contact_count(buffers, i) > 0)
      order.push_back(i);
    else
      buffers.contact_colors[i] = COLOR_OF_FIRST;
  }
  std::sort(order.begin(), order.end(), [&](u32 i, u32 j) {
    const u32 place_i = color_place(buffers.contacts[i].rank), place_j = color_place(buffers.contacts[j].rank);
    return place_i != place_j ? place_i < place_j : i < j;  // equal only in worlds that do not meet
  });

  auto& masks = buffers.body_colors;
  std::fill(masks.begin(), masks.end(), 0u);
  for (const u32 i : order) {
    const Contact& contact = buffers.contacts[i];
    std::vector<u32> dynamic_bodies;
    for (const u32 body : {contact.body_a, contact.body_b}) {
      if (buffers.body_infos[body].kind == BODY_DYNAMIC) dynamic_bodies.push_back(body);
    }
    const auto taken = [&](u32 color) {
      return std::any_of(dynamic_bodies.begin(), dynamic_bodies.end(),
                         [&](u32 body) { return (masks[2 * body + color / 32] >> (color % 32) & 1u) != 0; });
    };
    u32 color = 0;
    while (color < MAX_COLORS && taken(color)) ++color;
    buffers.contact_colors[i] = color;
    if (color == MAX_COLORS) continue;
    for (const u32 body : dynamic_bodies) masks[2 * body + color / 32] |= 1u << (color % 32);
  }
}

}  // namespace lockstep::reference
