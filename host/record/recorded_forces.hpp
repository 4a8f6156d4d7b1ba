// The forces of a step as recordings have them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/record/recording.hpp"
#include "host/simulation.hpp"

namespace lockstep {

struct RecordedForces {
  std::vector<ContactForceRow> contacts;  // what sleepers last carried among them; ordered by their shapes
  std::vector<JointForceRow> joints;      // all of them
};

/// Of the step that the simulation has just done (docs/reference/forces.md).
template <class real>
RecordedForces recorded_forces(Simulation<real>& simulation);

/// The first number of a table that is another, in words.
std::optional<std::string> difference(const RecordedForces& recorded, const RecordedForces& here);

}  // namespace lockstep
