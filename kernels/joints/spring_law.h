// The law of a spring along a free coordinate, and what takes an error of one back.
// cpu_reference/joints/spring_law.hpp is the twin.
#ifndef LOCKSTEP_SPRING_LAW_H
#define LOCKSTEP_SPRING_LAW_H

#include "rigid_body.h"

// The law of a spring: u_f + bias + compliance r_l = 0.
typedef struct SpringLaw {
  real bias, compliance;
} SpringLaw;

static inline SpringLaw joint_spring_law(real given_rate, real given_compliance, const StepParams* params, real above,
                                         real mobility, real before) {
  SpringLaw law = {given_rate * above, given_compliance};
#if FEATURE_JOINTS_AHEAD
  const real damped = (real)1 - params->theta * params->dt * given_rate;
  if (params->theta != (real)0.5 || !(given_compliance > (real)0) || !(damped > (real)1e-6)) return law;
  const real mass = damped / given_compliance, z = mass * mobility;
  const real mass_before = mass * ((real)1 - (z + (real)3) / (z + (real)6));
  law.compliance = (real)1 / ((real)1 / given_compliance - mass_before);
  const real rate = given_rate / given_compliance * law.compliance;
  law.bias = rate * above + law.compliance * (mass_before * before);
#endif
  return law;
}

static inline real joint_correction_speed(real change, bool counted, real dt) {
  const real most = (real)JOINT_CLOSING_ANGLE;
  if (counted && change > most) return most / dt;
  return counted && change < -most ? -most / dt : change / dt;
}

// Of a body at the start of the sub-step.
static inline Velocity joint_velocity_before(u32 body, u32 bodies, global const Velocity* previous_velocities) {
  Velocity none = {{0}};
  return body < bodies ? previous_velocities[body] : none;
}

#endif
