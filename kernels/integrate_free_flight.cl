#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "energy.h"
#include "gyroscopic.h"
#include "math.h"
#include "rigid_body.h"
#include "types.h"

// The formulas and their sources are in cpu_reference/integrate_free_flight.hpp.

// An orientation and the angular velocity in the body frame.
typedef struct RotationState {
  Quat q;
  Vec3 w;
} RotationState;

// What turns a body.
typedef struct RotationLaw {
  Vec3 ratios, inverse_inertia;
  Vec3 weight, com_offset;  // m g in the world frame; from the pivot to the centre of mass, body frame
} RotationLaw;

static inline Quat rotate_in_body(Quat q, Vec3 u) { return unit4(multiply4(q, rotation_by(u, (real)1))); }
static inline Vec3 delta_w(RotationLaw law, Quat q, Vec3 w, real dt) {
  const Vec3 moment = cross3(law.com_offset, unrotate3(q, law.weight));
  return scale3(dt, sub3(multiply3(law.inverse_inertia, moment), gyroscopic_term(law.ratios, w)));
}
static inline Vec3 runge_kutta_mean(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
  return scale3((real)1 / (real)6, add3(add3(a, d), scale3((real)2, add3(b, c))));
}
static inline RotationState rotation_step(RotationLaw law, RotationState start, real dt) {
  const real halved = (real)0.5;
  const Vec3 angle_1 = scale3(dt, start.w), change_1 = delta_w(law, start.q, start.w, dt);
  const Quat q_2 = rotate_in_body(start.q, scale3(halved, angle_1));
  const Vec3 w_2 = add3(start.w, scale3(halved, change_1));
  const Vec3 angle_2 = scale3(dt, w_2), change_2 = delta_w(law, q_2, w_2, dt);
  const Quat q_3 =
      rotate_in_body(start.q, add3(scale3(halved, angle_2), scale3((real)0.125, cross3(angle_1, angle_2))));
  const Vec3 w_3 = add3(start.w, scale3(halved, change_2));
  const Vec3 angle_3 = scale3(dt, w_3), change_3 = delta_w(law, q_3, w_3, dt);
  const Quat q_4 = rotate_in_body(start.q, angle_3);
  const Vec3 w_4 = add3(start.w, change_3);
  const Vec3 angle_4 = scale3(dt, w_4), change_4 = delta_w(law, q_4, w_4, dt);
  const Vec3 rotation =
      add3(runge_kutta_mean(angle_1, angle_2, angle_3, angle_4), scale3((real)1 / (real)12, cross3(angle_1, angle_4)));
  RotationState end;
  end.q = rotate_in_body(start.q, rotation);
  end.w = add3(start.w, runge_kutta_mean(change_1, change_2, change_3, change_4));
  return end;
}

kernel void integrate_free_flight(const StepParams params, global const BodyInfo* body_infos,
                                  global const Vec4* gravities, global const Mass* masses, global const Pivot* pivots,
                                  global Vec4* positions, global Vec4* orientations, global Motion* motions,
                                  global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  BodiesMeasure measure = {(real)0, 0, 0};

  FOR_EACH(i, params.bodies) {
    const BodyInfo info = body_infos[i];
    if (info.kind == BODY_STATIC) continue;
    const bool dynamic = info.kind == BODY_DYNAMIC;
    const bool pivoted = dynamic && IS_PIVOTED(pivots, i);
    const bool gyroscopic = dynamic && IS_GYROSCOPIC(params, info);

    const Mass mass = masses[i];
    Motion motion = motions[i];
    Vec3 v = vec3(motion.v);
    Vec3 w = vec3(motion.w);
    Vec4 position = positions[i];
    Vec3 x = vec3_of(position);
    const Vec3 zero = make3((real)0, (real)0, (real)0);
    Vec3 gravity = zero;
    if (dynamic) gravity = vec3_of(gravities[info.world]);

    if (params.substep == 0u && dynamic)
      measure_body(params.units_per_joule, mass, info, pivoted, gravity, x, quat(orientations[i]), v, w, &measure);

    // rotation
    RotationLaw law = {zero, vec3(mass.inverse_inertia), scale3(mass.mass, gravity), zero};
    if (gyroscopic) law.ratios = gyroscopic_ratios(mass);
    if (pivoted) {
      const Pivot pivot = pivots[i];
      law.com_offset = vec3(pivot.com_offset_body);
    }
    const Quat old_q = quat(orientations[i]);
    RotationState state = {old_q, unrotate3(old_q, w)};
    state = rotation_step(law, state, params.dt);
    const Quat q = state.q;
    if (pivoted || gyroscopic) w = rotate3(q, state.w);

    // translation
    if (pivoted) {
      const Pivot pivot = pivots[i];
      const Vec3 com_offset = com_offset_world(pivot, q);
      x = add3(vec3(pivot.point_world), com_offset);
      v = cross3(w, com_offset);
    } else {
      const Vec3 displacement = add3(scale3(params.dt, v), scale3((real)0.5 * params.dt * params.dt, gravity));
      x = add3(x, displacement);
      v = add3(v, scale3(params.dt, gravity));
    }

    if (is_bad_velocity(v, w, params.speed_limit)) report_bad(counters, STATUS_BAD_FLIGHT, i);
    if (is_bad_pose(x, q)) report_bad(counters, STATUS_BAD_POSE, i);

    position.x = x.x;
    position.y = x.y;
    position.z = x.z;
    positions[i] = position;
    orientations[i] = make_vec4(q);
    set_inverse_inertia(&motion, mass, info, q);
    store3(motion.v, v);
    store3(motion.w, w);
    motions[i] = motion;
  }
  if (params.substep == 0u) add_bodies(counters, &measure);
}
