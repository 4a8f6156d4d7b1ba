// What particles push with, and the longest time step that it bears (docs/theory/particles.md).
#pragma once

#include "host/scene/rounding.hpp"

namespace lockstep {

/// Contacts of particles lose energy; those that lose nearly all need dampers that no time step bears.
constexpr double least_restitution = 0.01;

/// Damping of sliding, in parts of the critical one of the normal spring.
constexpr double shear_damping_ratio = 0.3;

/// The velocity after over the velocity before the impact of x'' + 2 ratio x' + x = 0 that lasts until the force, which
/// only pushes, has come down to 0 (Schwager and Poeschel, Coefficient of restitution and linear dashpot model
/// revisited, 2007).
double restitution_of(double ratio);

/// The damping that gives this restitution, least_restitution .. 1, in parts of the critical one.
double damping_ratio(double restitution);

template <class real>
ParticleLaw<real> particle_law(const ParticleSettings& settings, const Origin& origin);

/// How many particles of a body can touch a flat surface at once: those within a quarter of a radius of the outermost
/// one, at most in one of 26 directions of the body and of its shapes.
double most_side_by_side(const BodyDescription& body, const std::vector<std::vector<Vector3>>& particles,
                         double radius);

/// The longest sub-step that keeps a body stable whose particles touch on all sides, s; infinite for a body that does
/// not move. `damping` is that of normal contacts, in parts of the critical one.
double longest_stable_step(const BodyDescription& body, const std::vector<std::vector<Vector3>>& particles,
                           const ParticleSettings& settings, double damping);

}  // namespace lockstep
