// Which bodies touch where a simulation starts, found by the stages that find it in a step.
#pragma once

#include <vector>

#include "host/scene/compile.hpp"
#include "host/scene/suspicions.hpp"

namespace lockstep {

/// Of a larger scene only so many bodies are looked at, the first: it is to cost little beside loading it.
inline constexpr u32 most_bodies_looked_at = 10'000;

/// Found by the C++ reference: a pair of bodies once, where it is deepest, in the order of the bodies. Filters, joints
/// and triggers are heeded as in a step. Nothing of bodies of particles. `state`: what a batch that begins with the
/// scene was compiled to; its constants are lent, and as they were afterwards.
template <class real>
std::vector<FirstContact> first_contacts(const Scene& scene, InitialState<real>& state);

/// The same of a scene that is not compiled yet.
std::vector<FirstContact> first_contacts(const Scene& scene);

}  // namespace lockstep
