// Euler's equations of a rotating body, in its principal frame. cpu_reference/gyroscopic.hpp says the same in C++ and
// gives the formulas.
#ifndef LOCKSTEP_GYROSCOPIC_H
#define LOCKSTEP_GYROSCOPIC_H

#include "rigid_body.h"

#define GYROSCOPIC_ITERATIONS 8u
#define MAX_GYROSCOPIC_SUBSTEPS 64u
#define GYROSCOPIC_TOLERANCE (REAL_IS_DOUBLE ? (real)1e-17 : (real)1e-8)
#define FREE_SHARE ((real)1e-6)

static inline Vec3 gyroscopic_ratios(Mass mass) {
  return make3((mass.inertia[2] - mass.inertia[1]) * mass.inverse_inertia[0],
               (mass.inertia[0] - mass.inertia[2]) * mass.inverse_inertia[1],
               (mass.inertia[1] - mass.inertia[0]) * mass.inverse_inertia[2]);
}
static inline Vec3 gyroscopic_term(Vec3 ratios, Vec3 w) {
  return make3(ratios.x * (w.y * w.z), ratios.y * (w.z * w.x), ratios.z * (w.x * w.y));
}

static inline Vec3 solve3(Vec3 row_x, Vec3 row_y, Vec3 row_z, Vec3 right) {
  const Vec3 yz = cross3(row_y, row_z);
  const Vec3 zx = cross3(row_z, row_x);
  const Vec3 xy = cross3(row_x, row_y);
  const Vec3 sum = add3(add3(scale3(right.x, yz), scale3(right.y, zx)), scale3(right.z, xy));
  return scale3((real)1 / dot3(row_x, yz), sum);
}

static inline Vec3 gyroscopic_substep(Vec3 ratios, Vec3 w, Vec3 delta_w, real theta, real dt) {
  const Vec3 start = add3(w, delta_w);
  const Vec3 a = scale3(dt * theta, ratios);
  Vec3 x = start;
  for (u32 i = 0u; i < GYROSCOPIC_ITERATIONS; ++i) {
    const Vec3 y = mean3(theta, w, x);
    const Vec3 defect = add3(sub3(x, start), scale3(dt, gyroscopic_term(ratios, y)));
    const Vec3 row_x = make3((real)1, a.x * y.z, a.x * y.y);
    const Vec3 row_y = make3(a.y * y.z, (real)1, a.y * y.x);
    const Vec3 row_z = make3(a.z * y.y, a.z * y.x, (real)1);
    const Vec3 change = solve3(row_x, row_y, row_z, defect);
    x = sub3(x, change);
    if (dot3(change, change) <= GYROSCOPIC_TOLERANCE * dot3(x, x)) break;
  }
  return x;
}

typedef struct FreeStep {
  Vec3 w;         // after the step, in the frame that has rotated by then
  Quat rotation;  // in the frame before the step, not of unit length
} FreeStep;

static inline Vec3 relative_momentum(Mass mass, Vec3 w) {
  const real unit = mass.inverse_inertia[0];
  return make3(w.x, (mass.inertia[1] * unit) * w.y, (mass.inertia[2] * unit) * w.z);
}

static inline Quat missing_rotation(Vec3 momentum, Vec3 z) {
  const real squared = dot3(momentum, momentum), y = dot3(z, z);
  if (!(squared > (real)0) || !(y < (real)1)) return make4((real)0, (real)0, (real)0, (real)1);
  const TangentRatio ratio = tangent_ratio(y);
  const Vec3 along = scale3(dot3(momentum, z) / squared * (ratio.numerator - ratio.denominator), momentum);
  return make4(along.x, along.y, along.z, ratio.denominator + y * ratio.numerator);
}

static inline FreeStep gyroscopic_step(Mass mass, Vec3 w, Vec3 delta_w, real theta, real position_theta, real dt) {
  FreeStep step;
  const Vec3 ratios = gyroscopic_ratios(mass);
  const Vec3 end = add3(w, delta_w);
  const real old_squared = dot3(w, w), end_squared = dot3(end, end);
  const real angle_squared = (old_squared < end_squared ? end_squared : old_squared) * (dt * dt);
  u32 substeps = 1u;
  while (substeps < MAX_GYROSCOPIC_SUBSTEPS && (real)(substeps * substeps) < angle_squared) substeps += substeps;
  const bool too_fast = (real)(substeps * substeps) < angle_squared;
  if (theta == (real)0 || too_fast) {
    step.rotation = rotation_by(add3(w, scale3(position_theta, delta_w)), dt);
    step.w = too_fast ? end : sub3(end, scale3(dt, gyroscopic_term(ratios, w)));
    return step;
  }

  const real share = (real)1 / (real)substeps;
  const real substep_dt = share * dt;
  const Vec3 substep_delta_w = scale3(share, delta_w);
  step.rotation = make4((real)0, (real)0, (real)0, (real)1);
  for (u32 i = 0u; i < substeps; ++i) {
    const Vec3 x = gyroscopic_substep(ratios, w, substep_delta_w, theta, substep_dt);
    const Vec3 mean_w = add3(mean3(theta, w, x), scale3(position_theta - theta, substep_delta_w));
    const Vec3 z = scale3((real)0.5 * substep_dt, mean_w);
    step.rotation = multiply4(
        step.rotation, multiply4(missing_rotation(relative_momentum(mass, w), z), make4(z.x, z.y, z.z, (real)1)));
    w = x;
  }
  step.w = w;
  return step;
}

static inline bool acts_in_middle(const StepParams* params, BodyInfo info, bool pivoted) {
  return params->theta == (real)0.5 && info.kind == BODY_DYNAMIC && IS_GYROSCOPIC(*params, info) && !pivoted;
}

static inline bool is_carried(const StepParams* params, BodyInfo info) {
  return params->theta > (real)0 && info.kind == BODY_DYNAMIC && IS_GYROSCOPIC(*params, info);
}

// What no body of the scene has is compiled out.
#if FEATURE_JOINTS
#define IS_JOINTED(starts, i) ((starts)[i] != (starts)[(i) + 1u])
#else
#define IS_JOINTED(starts, i) false
#endif

static inline Quat orientation_in_middle(Quat old_q, Vec3 w_old, real dt) {
  return integrate_orientation(old_q, w_old, (real)0.5 * dt);
}

static inline Vec3 gyroscopic_loss(Mass mass, Vec3 w_old, Vec3 w_new, real theta, real dt) {
  return scale3(dt, gyroscopic_term(gyroscopic_ratios(mass), mean3(theta, w_old, w_new)));
}

static inline Vec3 correct_gyroscopic_moment(const StepParams* params, Mass mass, FreeRotation free_rotation, Quat q,
                                             Vec3 w_old, Vec3 w) {
  const real dt = params->dt, theta = params->gyroscopic_theta;
  const Vec3 before = unrotate3(q, w_old), foreseen = unrotate3(q, vec3(free_rotation.w)), after = unrotate3(q, w);
  const real old_squared = dot3(before, before), new_squared = dot3(after, after);
  const real pi_squared = (real)9.8696044010893586;
  if ((old_squared < new_squared ? new_squared : old_squared) * (dt * dt) > pi_squared) return w;
  Vec3 change =
      sub3(gyroscopic_loss(mass, before, foreseen, theta, dt), gyroscopic_loss(mass, before, after, theta, dt));
  if (params->theta == (real)1) {
    const Vec3 pushed = sub3(after, foreseen), momentum = multiply3(vec3(mass.inertia), pushed);
    const real squared = dot3(momentum, pushed);
    if (squared > (real)0) change = sub3(change, scale3(dot3(momentum, change) / squared, pushed));
  }
  return add3(w, rotate3(q, change));
}

#endif
