#pragma OPENCL FP_CONTRACT OFF
// Spreads the friction and the twist of each pair that shares one friction patch over its contacts
// (cpu_reference/spread_patches.hpp).
#include "common.h"
#include "frame.h"
#include "types.h"

// From the centre of pressure to the contact, turned by a right angle about the normal.
static inline Vec3 spread_around(global const ContactBlock* row, Vec3 normal, Vec3 centre, u32 lane) {
  return cross3(normal, sub3(make3(row->arm_a_x[lane], row->arm_a_y[lane], row->arm_a_z[lane]), centre));
}

kernel void spread_patches(global const BlockBodies* block_bodies, global const BlockRows* block_rows,
                           global const ContactBlock* contact_blocks, global const PatchBlock* patch_blocks,
                           global const PatchImpulse* patch_impulses, global ImpulseBlock* impulse_blocks,
                           global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(slot, counters[COUNTER_BLOCKS] * PACK) {
    const u32 block = slot / PACK, lane = slot % PACK, count = block_bodies[block].count[lane];
    global const PatchBlock* patch = patch_blocks + block;
    global const ContactBlock* contacts = contact_blocks + block_rows[block].first;
    global ImpulseBlock* rows = impulse_blocks + block_rows[block].first;
    const Vec3 n = make3(patch->normal_x[lane], patch->normal_y[lane], patch->normal_z[lane]);
    const Vec3 centre = make3(patch->arm_a_x[lane], patch->arm_a_y[lane], patch->arm_a_z[lane]);
    real load = (real)0, swing = (real)0;
    for (u32 k = 0u; k < count; ++k) {
      const Vec3 around = spread_around(contacts + k, n, centre, lane);
      load = load + rows[k].normal[lane];
      swing = swing + rows[k].normal[lane] * dot3(around, around);
    }
    const real along = load > (real)0 ? (real)1 / load : (real)0;
    const real about = swing > (real)0 ? patch_impulses[block].twist[lane] / swing : (real)0;
    Vec3 t1, t2;
    tangents(n, &t1, &t2);
    const Vec3 tangent = scale3(along, add3(scale3(patch_impulses[block].tangent_1[lane], t1),
                                            scale3(patch_impulses[block].tangent_2[lane], t2)));
    for (u32 k = 0u; k < count; ++k) {
      tangents(make3(contacts[k].normal_x[lane], contacts[k].normal_y[lane], contacts[k].normal_z[lane]), &t1, &t2);
      const Vec3 t =
          scale3(rows[k].normal[lane], add3(tangent, scale3(about, spread_around(contacts + k, n, centre, lane))));
      rows[k].tangent_1[lane] = dot3(t, t1);
      rows[k].tangent_2[lane] = dot3(t, t2);
    }
  }
}
