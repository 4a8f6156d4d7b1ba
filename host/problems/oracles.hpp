// All that can take the place of the sweeps, by name (docs/solvers_oracle.md).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/problems/oracle_backend.hpp"

namespace lockstep {

/// Those of system_solver_names() and reduced_solver_names(), and impulse_based.
std::vector<std::string> oracle_names();

/// `name`: one of them; `directions`: sides of its friction pyramid, where it has one.
std::unique_ptr<OracleBackend> make_oracle(InitialState<double> state, const std::string& name, int directions,
                                           bool profile = false);

}  // namespace lockstep
