// Where a particle is, and with what two that touch push each other. kernels/particle.h is the twin.
//
// Particles of radius r, n the unit vector from i to j, overlap d = 2 r - |x_j - x_i|, u the velocity of j relative to
// i at the middle of the overlap, m = 1 / (q_i/m_i + q_j/m_j) with the masses of the two bodies and the numbers q of
// particles that each can set down side by side (Buffers::particle_shares holds q/m). On i acts (Harada, Real-Time
// Rigid Body Simulation on GPUs, GPU Gems 3, chapter 29, 2008; here in parts of the effective mass)
//
//   f = -p n + s,  p = max(0, k d - c u_n),   u_n = u . n,         c = 2 zeta sqrt(k m)
//   s = k_t y + c_t u_t, no longer than mu p,  u_t = u - u_n n,  c_t = 2 zeta_t sqrt(k m)
//
// at the middle of the overlap. The stretch y is how far j was sheared against i since they met: each sub-step turns it
// into the plane of the contact, y - (y . n) n, and adds dt u_t; where mu p cuts s, the surfaces slide, and y goes back
// to what gives that, (s - c_t u_t) / k_t (Cundall and Strack, A discrete numerical model for granular assemblies,
// 1979; in three dimensions Luding, Introduction to discrete element methods, 2008). With k_t = 0 there is none.
//
// On j acts the opposite, to the last bit: with n, u and y the other way round, all products have the same size. A
// plane is a j that moves with its body and has no end: d = r - distance, m = m_i / q_i.
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
void update_particle(Buffers<real>& b, u32 i) {
  const u32 body = b.particle_bodies[i];
  const Motion<real>& motion = b.motions[body];
  const Vec3<real> arm = rotate3(quat(b.orientations[body]), vec3_of(b.particle_offsets[i]));
  b.particle_positions[i] = vec4_of(add3(vec3_of(b.positions[body]), arm), real(0));
  b.particle_velocities[i] = vec4_of(point_velocity(motion, arm), real(0));
}

/// A plane where its body has it, world frame.
template <class real>
struct CurrentPlane {
  Vec3<real> point, normal;
};
template <class real>
CurrentPlane<real> current_plane(const Buffers<real>& b, u32 k) {
  const u32 body = b.plane_bodies[k];
  const Quat<real> q = quat(b.orientations[body]);
  return {add3(vec3_of(b.positions[body]), rotate3(q, vec3(b.particle_planes[k].point))),
          rotate3(q, vec3(b.particle_planes[k].normal))};
}

/// Where particle i overlaps something: along n, which points away from i, by `overlap` (0 or less: not at all). `arm`
/// leads from the centre of i to the middle of the overlap, where the other has the velocity `u` relative to i.
template <class real>
struct Touch {
  real overlap;
  Vec3<real> n, arm, u;
  real mass;
};

/// What acts on a particle, and its moment about the particle's centre.
template <class real>
struct Push {
  Vec3<real> force, moment;
};

/// What pushes a particle there, after the stretch of a spring along the surfaces was carried on by a sub-step.
template <class real>
Push<real> push_of(const ParticleLaw<real>& law, const Touch<real>& touch, real dt, Vec3<real>& stretch) {
  const real root = std::sqrt(touch.mass);
  const real u_n = dot3(touch.n, touch.u);
  const real pressure = law.stiffness * touch.overlap - law.damping * root * u_n;
  const real normal = pressure > real(0) ? pressure : real(0);
  const Vec3<real> slide = sub3(touch.u, scale3(u_n, touch.n));
  const Vec3<real> damper = scale3(law.shear_damping * root, slide);
  const bool springs = law.shear_stiffness > real(0);
  if (springs) {
    const Vec3<real> tangential = sub3(stretch, scale3(dot3(touch.n, stretch), touch.n));
    stretch = add3(tangential, scale3(dt, slide));
  }
  Vec3<real> shear = springs ? add3(scale3(law.shear_stiffness, stretch), damper) : damper;
  const real size = length3(shear), most = law.friction * normal;
  if (size > most) {
    shear = scale3(most / size, shear);
    if (springs) stretch = scale3(real(1) / law.shear_stiffness, sub3(shear, damper));
  }
  const Vec3<real> force = sub3(shear, scale3(normal, touch.n));
  return {force, cross3(touch.arm, force)};
}

}  // namespace lockstep::reference
