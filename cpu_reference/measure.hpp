// What the state was like that a step starts from, in its counters (docs/reference/error_measures.md): what a run is
// judged by, taken in every step by stages that have at hand what it takes, at the start of the first sub-step.
//
// Nothing depends on the order of bodies. A maximum is one of words: floats that are not negative order as their bits.
// The energy is a sum of whole units, each body's rounded to one.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "cpu_reference/rigid_body.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
void raise_maximum(std::vector<u32>& counters, u32 counter, real value) {
  if (value > 0) counters[counter] = std::max(counters[counter], std::bit_cast<u32>(static_cast<float>(value)));
}

/// Beyond 2^52 units a body counts no more. Sums wrap around at 63 bits, long after a run has gone bad.
template <class real>
std::int64_t energy_units(real joules, real units_per_joule) {
  constexpr real most = 4503599627370496.0;
  const real units = joules * units_per_joule;
  if (units != units) return 0;
  if (units > most) return std::int64_t(most);
  if (units < -most) return -std::int64_t(most);
  return static_cast<std::int64_t>(std::rint(units));
}

/// To a counter of two words.
inline void add_energy(std::vector<u32>& counters, u32 counter, std::int64_t units) {
  const std::uint64_t sum =
      (std::uint64_t{counters[counter + 1]} << 32 | counters[counter]) + static_cast<std::uint64_t>(units);
  counters[counter] = static_cast<u32>(sum);
  counters[counter + 1] = static_cast<u32>(sum >> 32);
}

/// m v^2 / 2 + w I w / 2, J. The moments of a body on a pivot are about that, so that they hold the motion of its
/// centre.
template <class real>
real kinetic_energy(const Mass<real>& mass, const BodyInfo& info, bool pivoted, Quat<real> q, Vec3<real> v,
                    Vec3<real> w) {
  const Vec3<real> w_body = info.isotropic != 0 ? w : unrotate3(q, w);
  const real linear = pivoted ? real(0) : mass.mass * dot3(v, v);
  return real(0.5) * (linear + dot3(w_body, multiply3(vec3(mass.inertia), w_body)));
}

/// The speed and the energy of a dynamic body: that of motion, and with it that of weight, -m g . x.
template <class real>
void measure_body(Buffers<real>& b, const StepParams<real>& params, u32 i) {
  const BodyInfo& info = b.body_infos[i];
  const Mass<real>& mass = b.masses[i];
  const Vec3<real> v = vec3(b.motions[i].v), w = vec3(b.motions[i].w), gravity = vec3_of(b.gravities[info.world]);
  const real kinetic = kinetic_energy(mass, info, is_pivoted(b.pivots, i), quat(b.orientations[i]), v, w);
  const real weight = mass.mass * dot3(gravity, vec3_of(b.positions[i]));
  raise_maximum(b.counters, COUNTER_MAX_SPEED, std::sqrt(dot3(v, v)));
  add_energy(b.counters, COUNTER_KINETIC, energy_units(kinetic, params.units_per_joule));
  add_energy(b.counters, COUNTER_ENERGY, energy_units(kinetic - weight, params.units_per_joule));
}

}  // namespace lockstep::reference
