// All that can take the place of the sweeps, by name (docs/theory/oracles.md).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/steppers/oracle_backend.hpp"

namespace lockstep {

/// Those of system_solver_names() and reduced_solver_names(), and impulse_based.
std::vector<std::string> oracle_names();

/// The oracle that the state is compiled for. Throws Error (input) where there is none of this name, and for a scene
/// that it does not take.
std::unique_ptr<OracleBackend> make_oracle(InitialState<double> state, bool profile = false);

/// What the names stand for, some to a line, for those who choose one.
std::string oracle_descriptions();

}  // namespace lockstep
