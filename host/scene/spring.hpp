// Soft constraints: how a sub-step takes an error back by a damped spring.
#pragma once

#include <algorithm>

namespace lockstep {

/// The share of the error that a sub-step takes back, and the softness in parts of the constraint's own W = J M^-1 J^T.
struct Correction {
  double share, softness;
};

/// At most a quarter of the rate of sub-steps of length h: a spring as stiff as one sweep can solve. Hz.
inline double usable_frequency(double h, double frequency) { return std::min(frequency, 0.25 / h); }

/// A spring of so many Hz, as far as they are usable, and a damping in parts of the critical one, taken implicitly
/// (Catto, Soft Constraints, GDC 2011). With angular frequency w, damping z and c = h w (2 z + h w) it pushes at
/// w / (2 z + h w) times the error, and has the softness W / c.
inline Correction spring_correction(double h, double frequency, double damping) {
  const double phase = 6.283185307179586 * h * usable_frequency(h, frequency);
  const double damped = 2 * damping + phase;
  return {phase / damped, 1 / (phase * damped)};
}

}  // namespace lockstep
