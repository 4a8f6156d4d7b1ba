// The law of a spring along a free coordinate, and what takes an error of one back (cpu_reference/prepare_joints.hpp).
// kernels/joints/spring_law.h is the twin.
#pragma once

#include "cpu_reference/rigid_body.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// The law of a spring: u_f + bias + compliance r_l = 0.
template <class real>
struct SpringLaw {
  real bias, compliance;
};

/// `given`: its rate and compliance; `above`: of its rest, m or rad; `mobility`: of the free row beside the locked ones
/// and armature; `before`: its velocity at the start of the sub-step. Of 1 / compliance a damper has the part h c, a
/// share of 1 - theta h rate.
template <class real>
SpringLaw<real> spring_law(real given_rate, real given_compliance, const StepParams<real>& params, real above,
                           real mobility, real before) {
  const real damped = real(1) - params.theta * params.dt * given_rate;
  if (params.theta != real(0.5) || !(given_compliance > 0) || !(damped > real(1e-6)))
    return {given_rate * above, given_compliance};
  const real mass = damped / given_compliance, z = mass * mobility;
  const real mass_before = mass * (real(1) - (z + real(3)) / (z + real(6)));
  const real compliance = real(1) / (real(1) / given_compliance - mass_before);
  const real rate = given_rate / given_compliance * compliance;
  return {rate * above + compliance * (mass_before * before), compliance};
}

/// The velocity that takes back so much of an error in a sub-step; of an angle that counts its revolutions no more than
/// a radian: it is relaxed, so that nobody foresees it.
template <class real>
real correction_speed(real change, bool counted, real dt) {
  const real most = real(JOINT_CLOSING_ANGLE);
  if (counted && change > most) return most / dt;
  return counted && change < -most ? -most / dt : change / dt;
}

/// Of a body at the start of the sub-step.
template <class real>
Velocity<real> velocity_before(const Buffers<real>& buffers, const StepParams<real>& params, u32 body) {
  if (body < params.bodies) return buffers.previous_velocities[body];
  return make_velocity(Vec3<real>{0, 0, 0}, Vec3<real>{0, 0, 0});
}

}  // namespace lockstep::reference
