// How the friction and the twist of LANES pairs that share one friction patch each are spread over their contacts.
// cpu_reference/spread_patch.hpp is the twin and states the law.
#ifndef LOCKSTEP_SPREAD_PATCH_H
#define LOCKSTEP_SPREAD_PATCH_H

#include "solve_patch.h"

#if FEATURE_PATCHES

typedef struct LaneSpread {
  Lane3 normal, centre, tangent;  // for a unit of normal impulse
  Lane3 rest;                     // of the friction, for each contact: what these shares leave
  lane about;                     // of the twist, for a unit of normal impulse at a unit of distance
} LaneSpread;

// From the centre of pressure to the contact, turned by a right angle about the normal.
static inline Lane3 spread_around(u32 first, global const ContactBlock* row, Lane3 normal, Lane3 centre) {
  return lane_cross3(normal, lane_sub3(LANE_ARM_A(row, first), centre));
}

static inline LaneSpread spread_of(u32 first, u32 rows, lane_u32 count, global const ContactBlock* contacts,
                                   global const ImpulseBlock* impulses, global const PatchBlock* patch,
                                   global const PatchImpulse* patch_impulse) {
  const LaneContact c = lane_patch(patch, first);
  lane load = (lane)0, swing = (lane)0, points = (lane)0;
  Lane3 drift = lane_make3((lane)0, (lane)0, (lane)0);
  for (u32 k = 0u; k < rows; ++k) {
    const Lane3 around = spread_around(first, contacts + k, c.normal, c.arm_a);
    const lane r = LANE_LOAD(impulses[k].normal + first);
    const lane_mask there = LANE_MASK(count > (lane_u32)k);
    load = there ? load + r : load;
    swing = there ? swing + r * lane_dot3(around, around) : swing;
    drift = lane_select3(there, lane_add3(drift, lane_scale3(r, around)), drift);
    points = there ? points + (lane)1 : points;
  }
  const lane along = load > (lane)0 ? (lane)1 / load : (lane)0;
  LaneSpread spread;
  spread.normal = c.normal;
  spread.centre = c.arm_a;
  spread.about = swing > (lane)0 ? LANE_LOAD(patch_impulse->twist + first) / swing : (lane)0;
  const Lane3 tangent = lane_add3(lane_scale3(LANE_LOAD(patch_impulse->tangent_1 + first), c.tangent_1),
                                  lane_scale3(LANE_LOAD(patch_impulse->tangent_2 + first), c.tangent_2));
  const Lane3 left = lane_scale3(load > (lane)0 ? (lane)0 : (lane)1, tangent);
  spread.tangent = lane_scale3(along, tangent);
  spread.rest = lane_scale3((lane)1 / points, lane_sub3(left, lane_scale3(spread.about, drift)));
  return spread;
}

// What a row of contacts gets along its tangents, beside its normal impulses.
static inline LaneCone spread_to(const LaneSpread* spread, u32 first, global const ContactBlock* row, lane normal) {
  const LaneContact c = lane_contact(row, first);
  const Lane3 around = spread_around(first, row, spread->normal, spread->centre);
  const Lane3 t = lane_scale3(normal, lane_add3(spread->tangent, lane_scale3(spread->about, around)));
  return lane_make_cone(normal, lane_dot3(t, c.tangent_1), lane_dot3(t, c.tangent_2));
}

#endif

#endif
