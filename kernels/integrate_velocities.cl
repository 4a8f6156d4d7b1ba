#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "energy.h"
#include "gyroscopic.h"
#include "math.h"
#include "rigid_body.h"
#include "sleep.h"
#include "types.h"

// Of a user, of particles, or of both.
static inline Load load_of(global const Load* loads, global const Load* particle_loads, u32 i) {
  const Load none = {{(real)0, (real)0, (real)0}, (real)0, {(real)0, (real)0, (real)0}, (real)0};
  if (!FEATURE_PARTICLES) return IS_LOADED ? loads[i] : none;
  Load load = particle_loads[i];
  if (FEATURE_LOADS) {
    const Load more = loads[i];
    store3(load.force, add3(vec3(more.force), vec3(load.force)));
    store3(load.torque, add3(vec3(more.torque), vec3(load.torque)));
  }
  return load;
}

// The formulas and their sources are in cpu_reference/integrate_velocities.hpp.
kernel void integrate_velocities(const StepParams params, global const BodyInfo* body_infos,
                                 global const Vec4* gravities, global const Mass* masses, global const Pivot* pivots,
                                 global const Load* loads, global const Load* particle_loads,
                                 global const Sleeper* sleepers, global const Vec4* positions,
                                 global const Vec4* orientations, global Velocity* previous_velocities,
                                 global FreeRotation* free_rotations, global Motion* motions, global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  BodiesMeasure measure = {(real)0, 0, 0};

  FOR_EACH(i, params.bodies) {
    const BodyInfo info = body_infos[i];
    const Mass mass = masses[i];
    const Quat start_q = quat(orientations[i]);
    Motion motion = motions[i];
    Vec3 v = vec3(motion.v);
    Vec3 w = vec3(motion.w);
    previous_velocities[i] = make_velocity(v, w);
    if (params.substep == 0u && info.kind == BODY_DYNAMIC)
      measure_body(params.units_per_joule, mass, info, IS_PIVOTED(pivots, i), vec3_of(gravities[info.world]),
                   vec3_of(positions[i]), start_q, v, w, &measure);
    const bool in_middle = acts_in_middle(&params, info, IS_PIVOTED(pivots, i));
    const Quat q = in_middle ? orientation_in_middle(start_q, w, params.dt) : start_q;
    set_inverse_inertia(&motion, mass, info, q);

    FreeRotation record = {{(real)0, (real)0, (real)0, (real)0}, {(real)0, (real)0, (real)0}, (real)0};

    if (info.kind == BODY_DYNAMIC && !is_asleep(sleepers, i)) {
      const Vec3 gravity = vec3_of(gravities[info.world]);
      const bool pivoted = IS_PIVOTED(pivots, i);
      const bool gyroscopic = IS_GYROSCOPIC(params, info);
      const Load load = load_of(loads, particle_loads, i);

      // rotation, in the body frame: delta_w is dt I^-1 tau
      if (pivoted || gyroscopic) {
        Vec3 delta_w = make3((real)0, (real)0, (real)0);
        if (pivoted) {
          const real ahead = (real)2 * params.theta * ((real)1 - params.theta) * params.dt;
          const Vec3 moment = gravity_moment_body(pivots[i], mass, integrate_orientation(q, w, ahead), gravity);
          delta_w = scale3(params.dt, multiply3(vec3(mass.inverse_inertia), moment));
        }
        if (IS_LOADED) {
          Vec3 moment = vec3(load.torque);
          if (pivoted) moment = add3(moment, cross3(com_offset_world(pivots[i], q), vec3(load.force)));
          delta_w = add3(delta_w, scale3(params.dt, multiply3(vec3(mass.inverse_inertia), unrotate3(q, moment))));
        }
        Vec3 change = delta_w;
        FreeStep step;
        if (gyroscopic) {
          const Vec3 w_body = unrotate3(q, w);
          step = gyroscopic_step(mass, w_body, delta_w, params.gyroscopic_theta, params.theta, params.dt);
          change = sub3(step.w, w_body);
        }
        w = add3(w, rotate3(q, change));
        if (gyroscopic && !pivoted) {
          const Vec3 axis = rotate3(start_q, make3(step.rotation.x, step.rotation.y, step.rotation.z));
          const Vec3 gyroscopic_change = sub3(change, delta_w);
          record = make_free_rotation(make4(axis.x, axis.y, axis.z, step.rotation.w), w,
                                      FREE_SHARE * dot3(gyroscopic_change, gyroscopic_change));
        }
      } else if (IS_LOADED) {
        w = add3(w, scale3(params.dt, apply_inverse_inertia(motion, vec3(load.torque))));
      }

      // translation
      if (pivoted) {
        v = cross3(w, com_offset_world(pivots[i], q));
      } else {
        Vec3 pull = gravity;
        if (IS_LOADED) pull = add3(pull, scale3(mass.inverse_mass, vec3(load.force)));
        v = add3(v, scale3(params.dt, pull));
      }

      if (is_bad_velocity(v, w, params.speed_limit)) report_bad(counters, STATUS_BAD_FORCES, i);
    }

    if (FEATURE_GYROSCOPIC) free_rotations[i] = record;
    store3(motion.v, v);
    store3(motion.w, w);
    motions[i] = motion;
  }
  if (params.substep == 0u) add_bodies(counters, &measure);
}
