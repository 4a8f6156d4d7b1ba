// An impact in the plane in closed form: what laws of impact are held to.
#pragma once

#include "host/scene/scene.hpp"

namespace lockstep {

/// One contact before the impact: its velocities along the normal (u_n < 0) and the tangent, m/s, and its Delassus
/// block, 1/kg.
struct PlanarImpact {
  double u_n, u_t;
  double w_nn, w_tt, w_nt;
  double friction, restitution, tangential_restitution = 0;
};

/// The impulse along both, N s.
struct PlanarImpulse {
  double normal, tangent;
};

/// By Routh's method (1860) for Poisson's and Stronge's laws, whose paths are two straight lines: a slide until it
/// stops, then stuck or a slide the other way (or on, from rest). Newton's u_n+ = -e u_n and Coulomb's law of the end
/// velocity; Chatterjee and Ruina's (1998), eq 20-22.
PlanarImpulse planar_impact(ImpactLaw law, const PlanarImpact& impact);

/// What an impulse adds to the kinetic energy, J.
double energy_of(const PlanarImpact& impact, const PlanarImpulse& impulse);

}  // namespace lockstep
