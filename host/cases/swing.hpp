// How well the joints of a mechanism that swings are held, and its energy kept.
#pragma once

#include "host/cases/trial.hpp"

namespace lockstep {

/// The largest of a whole run. Energy is in parts of its range: what the weights of all bodies could do at most on the
/// way to the origin, from which a mechanism hangs (the energy itself may be 0).
struct Swung {
  double separation = 0, angle = 0;  // m, rad, of a joint
  double gained = 0, lost = 0;       // of energy
};

/// Runs the scene for so long (s), and looks at each step.
Swung swing(const Scene& scene, double duration, Trial& trial);

}  // namespace lockstep
