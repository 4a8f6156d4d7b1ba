#pragma OPENCL FP_CONTRACT OFF
// Keeps what the next step starts from (cpu_reference/store_impulses.hpp).
#include "common.h"
#include "frame.h"
#include "types.h"

kernel void store_impulses(global const Contact* contacts, global const u32* contact_slots,
                           global const ContactBlock* contact_blocks, global const ImpulseBlock* impulse_blocks,
                           global const AngularFrictionBlock* angular_friction_blocks,
                           global const AngularFrictionImpulse* angular_friction_impulses, global u32* cached_count,
                           global ContactKey* cached_keys, global ContactImpulse* cached_impulses,
                           global Vec4* cached_moments, global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  if (get_global_id(0) == 0) cached_count[0] = counters[COUNTER_CONTACTS];
  FOR_EACH(i, counters[COUNTER_CONTACTS]) {
    const u32 lane = contact_slots[i] % PACK;
    global const ContactBlock* block = contact_blocks + contact_slots[i] / PACK;
    global const ImpulseBlock* impulses = impulse_blocks + contact_slots[i] / PACK;
    Vec3 t1, t2;
    const Vec3 n = make3(block->normal_x[lane], block->normal_y[lane], block->normal_z[lane]);
    tangents(n, &t1, &t2);
    const Vec3 t = add3(scale3(impulses->tangent_1[lane], t1), scale3(impulses->tangent_2[lane], t2));
    cached_keys[i].shape_a = contacts[i].shape_a;
    cached_keys[i].shape_b = contacts[i].shape_b;
    cached_keys[i].feature = contacts[i].feature;
    cached_keys[i].normal = 0u;
    cached_impulses[i].normal = impulses->normal[lane];
    cached_impulses[i].tangent_x = t.x;
    cached_impulses[i].tangent_y = t.y;
    cached_impulses[i].tangent_z = t.z;
#if FEATURE_ANGULAR_FRICTION
    global const AngularFrictionImpulse* angular_impulses = angular_friction_impulses + contact_slots[i] / PACK;
    const real torsion =
        angular_friction_blocks[contact_slots[i] / PACK].torsion_radius[lane] * angular_impulses->torsion[lane];
    const Vec3 m = add3(add3(scale3(torsion, n), scale3(angular_impulses->roll_1[lane], t1)),
                        scale3(angular_impulses->roll_2[lane], t2));
    cached_moments[i].x = m.x;
    cached_moments[i].y = m.y;
    cached_moments[i].z = m.z;
    cached_moments[i].w = (real)0;
#endif
  }
}
