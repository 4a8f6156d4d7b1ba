// Where the energy of a scene may come from, and in which units steps count it.
#pragma once

#include "host/buffers.hpp"
#include "host/features.hpp"
#include "host/verdict.hpp"

namespace lockstep {

struct EnergyBudget {
  EnergySource source = EnergySource::none;
  double power = 0;  // W: what motors of bounded force add at most
  bool has_springs =
      false;  // a long step sees energy swing between them and bodies: only a rise above the start is a gain
  /// What nobody sees, J: to lift each body by its radius of gyration k and by the rounding of its position, and to
  /// move it by k / 100 in a second.
  double negligible = 0;
};

/// Of joints as they are, W: the sum of force times speed of their motors.
template <class real>
double motor_power(const std::vector<Joint<real>>& joints);

/// Of a state as it is.
template <class real>
EnergyBudget energy_budget(const Buffers<real>& buffers, Features features);

/// Units that a J is counted in, a power of two: 2^32 are what bodies have by their motion, by where they are, by
/// moving by a hundredth of their size in a sub-step, and what springs have that are as long as what they pull. What
/// has 2^20 times as much counts no more (cpu_reference/measure.hpp).
template <class real>
real units_per_joule(const Buffers<real>& buffers, const StepParams<real>& params);

/// The buffers that both read in a scene of these features.
std::vector<Buffer> energy_buffers(Features features);

}  // namespace lockstep
