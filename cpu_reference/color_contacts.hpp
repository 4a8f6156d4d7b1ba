// Gives each pair in contact a colour so that pairs of one colour share no dynamic body and can be solved at once. The
// first contact of a pair carries its colour.
//
// Greedy: one pair after another takes the lowest colour that is free on both of its dynamic bodies, MAX_COLORS
// (overflow) where none is. The order is that of the ranks of
// their first contacts in their world, taken class by class modulo 64, where the
// next class lies 39 ranks on (64 divided by the golden ratio): neighbours in the list, which share a body, lie far
// apart in the order. So the parallel rounds of Jones and Plassmann (SIAM J. Sci. Comput. 14, 1993), which find the
// same colours from the order as a priority, need no more of them than with random priorities (measured: fewer), and a
// serial sweep needs no sorting.
//
// Where islands sleep, the contacts of one are not to get other colours because those of another are not there: ranks
// tell how many contacts there are before, but which of two comes first does not depend on others. So classes there are
// a hash of the ids of both shapes, and within a class the order is that of the list.
//
// Where pairs are solved in cells (cpu_reference/schedule_contacts.hpp), colours are for those that are in none.
#pragma once

#include <algorithm>
#include <vector>

#include "cpu_reference/math.hpp"
#include "cpu_reference/pair_contacts.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// Key of the order: distinct for distinct ranks.
inline u32 color_sort_key(u32 rank) { return rank * 39u % 64u << 26 | rank >> 6; }

/// Where islands sleep: a host sees to it that ranks fit (host/sleepers.hpp).
inline u32 color_sort_key_of_shapes(u32 id_a, u32 id_b, u32 rank) {
  u32 h = id_a * 0x9e3779b1u + id_b * 0x85ebca77u;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  return h >> 26 << 26 | rank;
}

template <class real>
u32 color_sort_key_of(const Buffers<real>& b, const Contact& contact) {
  if (b.sleepers.empty()) return color_sort_key(contact.rank);
  return color_sort_key_of_shapes(b.shape_infos[contact.shape_a].id, b.shape_infos[contact.shape_b].id, contact.rank);
}

template <class real>
void color_contacts(Buffers<real>& buffers, const StepParams<real>&) {
  std::vector<u32> order;
  for (u32 i = 0; i < buffers.counters[COUNTER_CONTACTS]; ++i) {
    const bool in_cell = !buffers.cell_slots.empty() && buffers.cell_slots[i] != NONE;
    if (pair_contact_count(buffers, i) == 0)
      buffers.contact_colors[i] = COLOR_OF_FIRST;
    else if (in_cell)
      buffers.contact_colors[i] = COLOR_OF_CELL;
    else
      order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](u32 i, u32 j) {
    const u32 key_i = color_sort_key_of(buffers, buffers.contacts[i]),
              key_j = color_sort_key_of(buffers, buffers.contacts[j]);
    return key_i != key_j ? key_i < key_j : i < j;  // equal only in worlds that do not meet
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
