#include "host/problems/oracles.hpp"

#include "host/problems/impulse_backend.hpp"
#include "host/problems/reduced_backend.hpp"

namespace lockstep {

std::vector<std::string> oracle_names() {
  std::vector<std::string> names = system_solver_names();
  for (const std::string& name : reduced_solver_names()) names.push_back(name);
  names.emplace_back(impulse_based);
  return names;
}

std::unique_ptr<OracleBackend> make_oracle(InitialState<double> state, const std::string& name, int directions,
                                           bool profile) {
  if (name == impulse_based) return std::make_unique<ImpulseBackend>(std::move(state), profile);
  if (ReducedSolver solver = find_reduced_solver(name, directions))
    return std::make_unique<ReducedBackend>(std::move(state), std::move(solver), profile);
  return std::make_unique<OracleBackend>(std::move(state), find_system_solver(name, directions), profile);
}

}  // namespace lockstep
