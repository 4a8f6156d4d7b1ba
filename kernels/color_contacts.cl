#pragma OPENCL FP_CONTRACT OFF
// Gives each contact a colour so that contacts of one colour share no dynamic body (cpu_reference/color_contacts.hpp).
// Here by Jones and Plassmann's rounds: a contact bids its priority on its dynamic bodies, and one that is the highest
// bidder of both takes the lowest colour free in both.
#include "common.h"
#include "types.h"

// A bid that outbids all: every colour of the body is taken, what is left on it goes to overflow.
#define COLOR_FULL 0xffffffffu

// Distinct for distinct ranks, never 0 ("no bid"): a bijection of rank + 1 that leaves 0 where it is.
static inline u32 color_priority(u32 rank) {
  u32 x = rank + 1u;
  x = (x ^ (x >> 16)) * 0x9e3779b9u;
  x = (x ^ (x >> 15)) * 0x6a09e667u;
  return x ^ (x >> 16);
}

static inline u32 color_lowest_bit(u32 bits) { return 31u - clz(bits & (0u - bits)); }

// Lowest colour that is free in both words, MAX_COLORS where none is.
static inline u32 color_lowest_free(u32 used_low, u32 used_high) {
  if (~used_low != 0u) return color_lowest_bit(~used_low);
  if (~used_high != 0u) return 32u + color_lowest_bit(~used_high);
  return MAX_COLORS;
}

// The winner of a body is alone in writing its mask.
static inline void color_take(u32 color, u32 body, global u32* body_colors, global u32* next_bids) {
  body_colors[2u * body + color / 32u] |= 1u << (color % 32u);
  if ((body_colors[2u * body] & body_colors[2u * body + 1u]) == COLOR_FULL) atomic_max(next_bids + body, COLOR_FULL);
}

// One round over all contacts; 1 where some contact lost and bids again. Bids lie in three arrays that change roles, so
// that a round needs one launch: bids of round k are cleared in round k - 2, made in k - 1 and read in k.
static inline u32 color_bid(u32 round, u32 first, u32 stride, u32 count, u32 bodies, global const BodyInfo* body_infos,
                            global const Contact* contacts, global u32* body_colors, global u32* contact_colors,
                            global u32* color_bids) {
  global const u32* bids = color_bids + (round % 3u) * bodies;
  global u32* next_bids = color_bids + ((round + 1u) % 3u) * bodies;
  global u32* later_bids = color_bids + ((round + 2u) % 3u) * bodies;
  u32 lost = 0u;
  for (u32 i = first; i < count; i += stride) {
    if (contact_colors[i] != NONE) continue;
    const u32 a = contacts[i].body_a, b = contacts[i].body_b;
    const bool dynamic_a = body_infos[a].kind == BODY_DYNAMIC, dynamic_b = body_infos[b].kind == BODY_DYNAMIC;
    const u32 priority = color_priority(contacts[i].rank);
    const u32 bid_a = dynamic_a ? bids[a] : priority, bid_b = dynamic_b ? bids[b] : priority;
    if (bid_a == COLOR_FULL || bid_b == COLOR_FULL) {
      contact_colors[i] = MAX_COLORS;
    } else if (bid_a == priority && bid_b == priority) {
      const u32 low = (dynamic_a ? body_colors[2u * a] : 0u) | (dynamic_b ? body_colors[2u * b] : 0u);
      const u32 high = (dynamic_a ? body_colors[2u * a + 1u] : 0u) | (dynamic_b ? body_colors[2u * b + 1u] : 0u);
      const u32 color = color_lowest_free(low, high);
      contact_colors[i] = color;
      if (dynamic_a && color < MAX_COLORS) color_take(color, a, body_colors, next_bids);
      if (dynamic_b && color < MAX_COLORS) color_take(color, b, body_colors, next_bids);
    } else {
      lost = 1u;
      if (dynamic_a) {
        atomic_max(next_bids + a, priority);
        later_bids[a] = 0u;
      }
      if (dynamic_b) {
        atomic_max(next_bids + b, priority);
        later_bids[b] = 0u;
      }
    }
  }
  return lost;
}

kernel void color_start(const StepParams params, global u32* body_colors, global u32* contact_colors,
                        global u32* color_bids, global const u32* counters) {
  FOR_EACH(i, 2u * params.bodies) {
    body_colors[i] = 0u;
    color_bids[i] = 0u;
  }
  FOR_EACH(i, counters[COUNTER_CONTACTS]) contact_colors[i] = NONE;
}

// COUNTER_ROUNDS is one more than the last round that somebody lost.
kernel void color_round(const StepParams params, const u32 round, global const BodyInfo* body_infos,
                        global const Contact* contacts, global u32* body_colors, global u32* contact_colors,
                        global u32* color_bids, global u32* counters) {
  const u32 lost = color_bid(round, (u32)get_global_id(0), (u32)get_global_size(0), counters[COUNTER_CONTACTS],
                             params.bodies, body_infos, contacts, body_colors, contact_colors, color_bids);
  if (lost != 0u) counters[COUNTER_ROUNDS] = round + 1u;
}

// One work-group: the rounds from `first_round` on, until nobody loses. In each round the highest bidder wins.
kernel void color_tail(const StepParams params, const u32 first_round, global const BodyInfo* body_infos,
                       global const Contact* contacts, global u32* body_colors, global u32* contact_colors,
                       global u32* color_bids, global u32* counters) {
  for (u32 round = first_round;; ++round) {
    const u32 rounds = counters[COUNTER_ROUNDS];
    barrier(CLK_GLOBAL_MEM_FENCE);
    if (rounds != round) break;
    const u32 lost = color_bid(round, (u32)get_local_id(0), (u32)get_local_size(0), counters[COUNTER_CONTACTS],
                               params.bodies, body_infos, contacts, body_colors, contact_colors, color_bids);
    if (lost != 0u) counters[COUNTER_ROUNDS] = round + 1u;
    barrier(CLK_GLOBAL_MEM_FENCE);
  }
}
