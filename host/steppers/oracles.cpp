#include "host/steppers/oracles.hpp"

#include <fmt/format.h>

#include "cpu_reference/oracle/cone/solvers.hpp"
#include "cpu_reference/oracle/joints/mixed.hpp"
#include "host/error.hpp"
#include "host/steppers/impulse_backend.hpp"
#include "host/steppers/reduced_backend.hpp"

namespace lockstep {

std::vector<std::string> oracle_names() {
  std::vector<std::string> names = system_solver_names();
  for (const std::string& name : reduced_solver_names()) names.push_back(name);
  names.emplace_back(impulse_based);
  return names;
}

std::unique_ptr<OracleBackend> make_oracle(InitialState<double> state, bool profile) {
  const auto [name, sides] = state.oracle;
  const int directions = static_cast<int>(sides);
  if (name == impulse_based) return std::make_unique<ImpulseBackend>(std::move(state), profile);
  if (ReducedSolver solver = find_reduced_solver(name, directions))
    return std::make_unique<ReducedBackend>(std::move(state), std::move(solver), profile);
  if (SystemSolver solver = find_system_solver(name, directions))
    return std::make_unique<OracleBackend>(std::move(state), std::move(solver), profile);
  throw Error(Failure::input, "solver", fmt::format("there is none of the name '{}'", name));
}

std::string oracle_descriptions() {
  std::string text =
      "Oracles solve the constraint system of each sub-step in double, on the reference, to the residual --tolerance\n"
      "(1e-10 unless given) in --iterations at most (100000):\n";
  for (const oracle::ConeSolver& solver : oracle::cone_solvers())
    text += fmt::format("  {:<20}{}\n", solver.name, solver.description);
  text += "Those that take motors, limits and springs of joints too:\n";
  for (const oracle::MixedSolver& solver : oracle::mixed_solvers())
    text += fmt::format("  {:<20}{}\n", solver.name, solver.description);
  return text +
         "  impulse_based       joints closed at the end of each sub-step, by predicting it; contacts beside them\n"
         "Other models:\n"
         "  pyramid_NAME        Model-LCP, friction in a pyramid of --directions sides, by enumeration, lemke, "
         "keller,\n"
         "                      baraff, murty, jacobi, damped_jacobi, pgs, psor, pgs_sm, nncg or fischer_newton\n"
         "  box_NAME            the boxed model, by baraff or one of those after murty\n"
         "  reduced_NAME        joints in reduced coordinates, which never open, with cones by one of the first names\n"
         "  reduced_pyramid_NAME  the same with friction pyramids (Model-DCA-LCP); also as mixed problems with "
         "velocities\n"
         "                      of some bodies, by reduced_mlcp1_fischer_newton and reduced_mlcp2_fischer_newton\n"
         "docs/theory/oracles.md and docs/theory/lcp.md say which one when.\n";
}

}  // namespace lockstep
