#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "rigid_body.h"
#include "types.h"

kernel void sum_particles(global const BodyInfo* body_infos, global const u32* body_particles,
                          global const Vec4* particle_offsets, global const Vec4* orientations,
                          global const Vec4* particle_forces, global const Vec4* particle_moments,
                          global Load* particle_loads, global const u32* counters, const StepParams params) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(body, params.bodies) {
    const Quat q = quat(orientations[body]);
    Vec3 force = make3((real)0, (real)0, (real)0), torque = force;
    const u32 end = body_infos[body].kind == BODY_DYNAMIC ? body_particles[body + 1u] : 0u;
    for (u32 i = body_particles[body]; i < end; ++i) {
      const Vec3 f = vec3_of(particle_forces[i]), arm = rotate3(q, vec3_of(particle_offsets[i]));
      force = add3(force, f);
      torque = add3(torque, add3(cross3(arm, f), vec3_of(particle_moments[i])));
    }
    Load load;
    store3(load.force, force);
    store3(load.torque, torque);
    load.pad_f = (real)0;
    load.pad_t = (real)0;
    particle_loads[body] = load;
  }
}
