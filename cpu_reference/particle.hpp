// Where a particle is, and with what two that touch push each other. kernels/particle.h is the twin.
//
// Particles of radius r, n the unit vector from i to j, overlap d = 2 r - |x_j - x_i|, u the velocity of j relative to
// i at the middle of the overlap, m = 1 / (q_i/m_i + q_j/m_j) with the masses of the two bodies and the numbers q of
// particles that each can set down side by side (Buffers::particle_shares holds q/m). On i acts (Harada, Real-Time
// Rigid Body Simulation on GPUs, GPU Gems 3, chapter 29, 2008; here in parts of the effective mass)
//
//   f = -max(0, k d - c u_n) n + s,   u_n = u . n,  c = 2 zeta sqrt(k m)
//   s = c_t u_t, no longer than mu times the first part,   u_t = u - u_n n,  c_t = 2 zeta_t sqrt(k m)
//
// at the middle of the overlap. On j acts the opposite, to the last bit: with n and u the other way round, all
// products have the same size. A plane is a j that moves with its body and has no end: d = r - distance, m = m_i / q_i.
#pragma once

#include "cpu_reference/grid.hpp"
#include "cpu_reference/rigid_body.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
Vec4<real> vec4_of(Vec3<real> a, real w) {
  return {a.x, a.y, a.z, w};
}

/// Position and velocity of particle i, world frame.
template <class real>
void place_particle(Buffers<real>& b, u32 i) {
  const u32 body = b.particle_bodies[i];
  const Motion<real>& motion = b.motions[body];
  const Vec3<real> arm = rotate3(quat(b.orientations[body]), vec3_of(b.particle_offsets[i]));
  b.particle_places[i] = vec4_of(add3(vec3_of(b.positions[body]), arm), real(0));
  b.particle_velocities[i] = vec4_of(point_velocity(motion, arm), real(0));
}

/// What acts on a particle, and its moment about the particle's centre.
template <class real>
struct Push {
  Vec3<real> force, moment;
};

/// What pushes particle i where it overlaps something along the normal n, which points away from i. `overlap` is
/// positive, `arm` leads from the centre of i to the middle of the overlap, `u` is the velocity of the other there.
template <class real>
Push<real> push_of(const ParticleLaw<real>& law, Vec3<real> n, real overlap, Vec3<real> arm, Vec3<real> u, real mass) {
  const real root = std::sqrt(mass);
  const real u_n = dot3(n, u);
  const real pressure = law.stiffness * overlap - law.damping * root * u_n;
  const real normal = pressure > real(0) ? pressure : real(0);
  Vec3<real> shear = scale3(law.shear_damping * root, sub3(u, scale3(u_n, n)));
  const real size = length3(shear), most = law.friction * normal;
  if (size > most) shear = scale3(most / size, shear);
  const Vec3<real> force = sub3(shear, scale3(normal, n));
  return {force, cross3(arm, force)};
}

}  // namespace lockstep::reference
