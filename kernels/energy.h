// Energy, counted in whole units in two counters. cpu_reference/measure.hpp is the twin and says more.
#ifndef LOCKSTEP_ENERGY_H
#define LOCKSTEP_ENERGY_H

#include "measure.h"
#include "rigid_body.h"

// 2^52: beyond it a body counts no more.
#define MOST_ENERGY_UNITS ((real)4503599627370496.0f)

static inline long energy_units(real joules, real units_per_joule) {
  const real units = joules * units_per_joule;
  if (units != units) return 0;
  if (units > MOST_ENERGY_UNITS) return (long)MOST_ENERGY_UNITS;
  if (units < -MOST_ENERGY_UNITS) return -(long)MOST_ENERGY_UNITS;
  return (long)rint(units);
}

// The low words wrap around and carry: in any order the sum is the same.
static inline void add_energy(volatile global u32* counters, u32 counter, long units) {
  if (units == 0) return;
  const u32 low = (u32)units, before = atomic_add(&counters[counter], low);
  atomic_add(&counters[counter + 1u], (u32)(units >> 32) + (before + low < before ? 1u : 0u));
}

static inline real kinetic_energy(Mass mass, BodyInfo info, bool pivoted, Quat q, Vec3 v, Vec3 w) {
  const Vec3 w_body = info.isotropic != 0u ? w : unrotate3(q, w);
  const real linear = pivoted ? (real)0 : mass.mass * dot3(v, v);
  return (real)0.5 * (linear + dot3(w_body, multiply3(vec3(mass.inertia), w_body)));
}

// Of many bodies, by one work-item.
typedef struct BodiesMeasure {
  real speed;  // its square
  long energy, kinetic;
} BodiesMeasure;

static inline void measure_body(real units_per_joule, Mass mass, BodyInfo info, bool pivoted, Vec3 gravity, Vec3 x,
                                Quat q, Vec3 v, Vec3 w, BodiesMeasure* measure) {
  const real speed = dot3(v, v), kinetic = kinetic_energy(mass, info, pivoted, q, v, w);
  measure->speed = speed > measure->speed ? speed : measure->speed;
  measure->kinetic += energy_units(kinetic, units_per_joule);
  measure->energy += energy_units(kinetic - mass.mass * dot3(gravity, x), units_per_joule);
}

static inline void add_bodies(volatile global u32* counters, const BodiesMeasure* measure) {
  raise_maximum(counters, COUNTER_MAX_SPEED, sqrt(measure->speed));
  add_energy(counters, COUNTER_ENERGY, measure->energy);
  add_energy(counters, COUNTER_KINETIC, measure->kinetic);
}

#endif
