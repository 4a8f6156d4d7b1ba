#pragma OPENCL FP_CONTRACT OFF
// Gives each pair in contact a colour so that pairs of one colour share no dynamic body
// (cpu_reference/color_contacts.hpp).
// Two ways to the same colours: one work-item a world, in order, for a device with few threads; and for one with
// thousands the rounds of Jones and Plassmann, where a contact bids on its dynamic bodies with its priority, and one
// that is the highest bidder of both takes the lowest colour that is free in both.
#include "common.h"
#include "pair_contacts.h"
#include "types.h"

#define COLOR_CLASS_BITS 6u
#define COLOR_CLASSES (1u << COLOR_CLASS_BITS)

#if FEATURE_SLEEPING
// Where islands sleep, the class is a hash of the ids of both shapes; a host sees to it
// that ranks fit (host/sleepers.hpp).
static inline u32 color_class_of(Contact contact, global const ShapeInfo* shape_infos) {
  u32 h = shape_infos[contact.shape_a].id * 0x9e3779b1u + shape_infos[contact.shape_b].id * 0x85ebca77u;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  return h >> (32u - COLOR_CLASS_BITS);
}
#endif

// Of a contact before its pair has a colour: NONE, or what says that it needs none.
static inline u32 color_at_first(u32 i, global const Contact* contacts, global const u32* cell_slots) {
  if (!pair_contact_is_first(contacts, i)) return COLOR_OF_FIRST;
#if FEATURE_PARTITIONS
  if (cell_slots[i] != NONE) return COLOR_OF_CELL;
#endif
  return NONE;
}

// The class of this rank in the order; 23 is the inverse of 39 modulo 64.
static inline u32 color_class(u32 rank) { return rank * 23u % COLOR_CLASSES; }

// The order of the contacts of a world, as a falling priority: never 0 ("no bid") or COLOR_FULL.
static inline u32 color_priority(Contact contact, global const ShapeInfo* shape_infos) {
  const u32 rank = contact.rank;
#if FEATURE_SLEEPING
  const u32 sort_key = color_class_of(contact, shape_infos) << (32u - COLOR_CLASS_BITS) | rank;
#else
  const u32 sort_key = rank * 39u % COLOR_CLASSES << (32u - COLOR_CLASS_BITS) | rank >> COLOR_CLASS_BITS;
#endif
  return 0xfffffffeu - sort_key;
}

// A bid that outbids all: every colour of the body is taken, what is left on it goes to overflow.
#define COLOR_FULL 0xffffffffu

// Lowest colour that neither body has, MAX_COLORS where there is none.
static inline u32 color_lowest_free(u32 a, bool dynamic_a, u32 b, bool dynamic_b, global const u32* body_colors) {
  const u32 low = (dynamic_a ? body_colors[2u * a] : 0u) | (dynamic_b ? body_colors[2u * b] : 0u);
  if (~low != 0u) return lowest_bit(~low);
  const u32 high = (dynamic_a ? body_colors[2u * a + 1u] : 0u) | (dynamic_b ? body_colors[2u * b + 1u] : 0u);
  if (~high != 0u) return 32u + lowest_bit(~high);
  return MAX_COLORS;
}

static inline void color_take(u32 color, u32 body, global u32* body_colors) {
  body_colors[2u * body + color / 32u] |= 1u << (color % 32u);
}

// ---- in order -----------------------------------------------------------------------------------------------------

// The lowest colour that is free for the pair that contact i is the first of.
static inline void color_assign(u32 i, global const BodyInfo* body_infos, global const Contact* contacts,
                                global u32* body_colors, global u32* contact_colors) {
  const u32 a = contacts[i].body_a, b = contacts[i].body_b;
  const bool dynamic_a = body_infos[a].kind == BODY_DYNAMIC, dynamic_b = body_infos[b].kind == BODY_DYNAMIC;
  const u32 color = color_lowest_free(a, dynamic_a, b, dynamic_b, body_colors);
  contact_colors[i] = color;
  if (dynamic_a && color < MAX_COLORS) color_take(color, a, body_colors);
  if (dynamic_b && color < MAX_COLORS) color_take(color, b, body_colors);
}

#if FEATURE_SLEEPING
// The first contacts of pairs among first .. end - 1, sorted by class; how many they are. Of a class they stay in
// order.
static inline u32 color_sort(u32 first, u32 end, global const ShapeInfo* shape_infos, global const Contact* contacts,
                             global const u32* cell_slots, global u32* color_order, global u32* contact_colors) {
  u32 starts[COLOR_CLASSES + 1u];
  for (u32 rank = 0u; rank <= COLOR_CLASSES; ++rank) starts[rank] = 0u;
  for (u32 i = first; i < end; ++i) {
    contact_colors[i] = color_at_first(i, contacts, cell_slots);
    if (contact_colors[i] == NONE) ++starts[color_class_of(contacts[i], shape_infos) + 1u];
  }
  for (u32 rank = 0u; rank < COLOR_CLASSES; ++rank) starts[rank + 1u] += starts[rank];
  const u32 count = starts[COLOR_CLASSES];
  for (u32 i = first; i < end; ++i) {
    if (contact_colors[i] != NONE) continue;
    color_order[first + starts[color_class_of(contacts[i], shape_infos)]++] = i;
  }
  return count;
}
#endif

kernel void color_worlds(const StepParams params, global const WorldRange* world_ranges,
                         global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                         global const Contact* contacts, global const u32* cell_slots, global u32* body_colors,
                         global u32* color_order, global u32* contact_colors, global const u32* counters) {
  FOR_EACH(world, params.worlds) {
    const u32 first_word = 2u * world_ranges[world].first_body;
    for (u32 i = 0u; i < 2u * world_ranges[world].body_count; ++i) body_colors[first_word + i] = 0u;

    const u32 first = first_contact_of_world(world, counters[COUNTER_CONTACTS], contacts);
    const u32 end = first_contact_of_world(world + 1u, counters[COUNTER_CONTACTS], contacts);
#if FEATURE_SLEEPING
    const u32 count = color_sort(first, end, shape_infos, contacts, cell_slots, color_order, contact_colors);
    for (u32 k = 0u; k < count; ++k)
      color_assign(color_order[first + k], body_infos, contacts, body_colors, contact_colors);
#else
    for (u32 rank = 0u; rank < COLOR_CLASSES; ++rank) {
      for (u32 i = first + color_class(rank); i < end; i += COLOR_CLASSES) {
        contact_colors[i] = color_at_first(i, contacts, cell_slots);
        if (contact_colors[i] == NONE) color_assign(i, body_infos, contacts, body_colors, contact_colors);
      }
    }
#endif
  }
}

// ---- in rounds ----------------------------------------------------------------------------------------------------

// The winner of a body is alone in writing its mask.
static inline void color_win(u32 color, u32 body, global u32* body_colors, global u32* next_bids) {
  color_take(color, body, body_colors);
  if ((body_colors[2u * body] & body_colors[2u * body + 1u]) == 0xffffffffu) atomic_max(next_bids + body, COLOR_FULL);
}

static inline void color_lose(u32 priority, u32 body, global u32* next_bids, global u32* later_bids) {
  atomic_max(next_bids + body, priority);
  later_bids[body] = 0u;
}

// A contact in one round; whether it lost and bids again. Bids lie in three arrays that change roles, so that a round
// needs one launch: bids of round k are cleared in round k - 2, made in k - 1 and read in k.
static inline bool color_bid(u32 round, u32 i, u32 bodies, global const BodyInfo* body_infos,
                             global const ShapeInfo* shape_infos, global const Contact* contacts,
                             global u32* body_colors, global u32* contact_colors, global u32* color_bids) {
  if (contact_colors[i] != NONE) return false;
  global const u32* bids = color_bids + (round % 3u) * bodies;
  global u32* next_bids = color_bids + ((round + 1u) % 3u) * bodies;
  global u32* later_bids = color_bids + ((round + 2u) % 3u) * bodies;
  const u32 a = contacts[i].body_a, b = contacts[i].body_b;
  const bool dynamic_a = body_infos[a].kind == BODY_DYNAMIC, dynamic_b = body_infos[b].kind == BODY_DYNAMIC;
  const u32 priority = color_priority(contacts[i], shape_infos);
  const u32 bid_a = dynamic_a ? bids[a] : priority, bid_b = dynamic_b ? bids[b] : priority;
  if (bid_a == COLOR_FULL || bid_b == COLOR_FULL) {
    contact_colors[i] = MAX_COLORS;
    return false;
  }
  if (bid_a == priority && bid_b == priority) {
    const u32 color = color_lowest_free(a, dynamic_a, b, dynamic_b, body_colors);
    contact_colors[i] = color;
    if (dynamic_a && color < MAX_COLORS) color_win(color, a, body_colors, next_bids);
    if (dynamic_b && color < MAX_COLORS) color_win(color, b, body_colors, next_bids);
    return false;
  }
  if (dynamic_a) color_lose(priority, a, next_bids, later_bids);
  if (dynamic_b) color_lose(priority, b, next_bids, later_bids);
  return true;
}

kernel void color_start(const StepParams params, global const Contact* contacts, global const u32* cell_slots,
                        global u32* body_colors, global u32* contact_colors, global u32* color_bids,
                        global u32* colorless_count, global const u32* counters) {
  if (get_global_id(0) == 0) colorless_count[0] = 0u;
  FOR_EACH(i, 2u * params.bodies) {
    body_colors[i] = 0u;
    color_bids[i] = 0u;
  }
  FOR_EACH(i, counters[COUNTER_CONTACTS]) contact_colors[i] = color_at_first(i, contacts, cell_slots);
}

kernel void color_round(const StepParams params, const u32 round, global const BodyInfo* body_infos,
                        global const ShapeInfo* shape_infos, global const Contact* contacts, global u32* body_colors,
                        global u32* contact_colors, global u32* color_bids, global const u32* counters) {
  FOR_EACH(i, counters[COUNTER_CONTACTS]) {
    color_bid(round, i, params.bodies, body_infos, shape_infos, contacts, body_colors, contact_colors, color_bids);
  }
}

// The contacts that have no colour yet, in whatever order: a winner is one whoever bids first.
kernel void color_gather(global const u32* contact_colors, global u32* colorless, global u32* colorless_count,
                         global const u32* counters) {
  FOR_EACH(i, counters[COUNTER_CONTACTS]) {
    if (contact_colors[i] == NONE) colorless[atomic_inc(colorless_count)] = i;
  }
}

// One work-group: the rounds from `first_round` on, until nobody loses. In each round the highest bidder wins.
kernel void color_tail(const StepParams params, const u32 first_round, global const BodyInfo* body_infos,
                       global const ShapeInfo* shape_infos, global const Contact* contacts, global u32* body_colors,
                       global u32* contact_colors, global u32* color_bids, global const u32* colorless,
                       global const u32* colorless_count) {
  local u32 lost;
  u32 round = first_round;
  bool goes_on;
  do {
    if (get_local_id(0) == 0) lost = 0u;
    barrier(CLK_LOCAL_MEM_FENCE);
    FOR_EACH_OF_GROUP(k, colorless_count[0]) {
      if (color_bid(round, colorless[k], params.bodies, body_infos, shape_infos, contacts, body_colors, contact_colors,
                    color_bids))
        atomic_or(&lost, 1u);
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    goes_on = lost != 0u;
    ++round;
    barrier(CLK_LOCAL_MEM_FENCE);
  } while (goes_on);
}
