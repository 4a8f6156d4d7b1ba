#include "host/steppers/reduced_solvers.hpp"

#include <fmt/format.h>

#include "cpu_reference/oracle/articulated/dca_models.hpp"
#include "cpu_reference/oracle/articulated/reduced_cones.hpp"
#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "host/error.hpp"
#include "host/steppers/system_solvers.hpp"

namespace lockstep {

namespace {

using namespace oracle::articulated;
using Eigen::Index;
using Eigen::VectorXd;
using oracle::SolveLimits;
namespace lcp = oracle::lcp;

// What takes minutes a step is no longer of use; complementarity problems are dense.
constexpr Index most_contacts = 4000, most_unknowns = 3000;

ReducedSolution solve_cones(const oracle::ConeSolver& solver, const Step& step, const Demand& demand,
                            const VectorXd& start, const SolveLimits& limits, const std::string& where) {
  expect_moderate(where, Index(demand.contacts.size()), most_contacts, "contacts");
  ReducedSolution solution = {reduced_problem(step, demand), start, {}};
  solution.report = solve_reduced_cones(solver, solution.problem, limits, solution.impulses);
  return solution;
}

// x of a pyramid, by whoever makes and solves its problem.
template <class Solve>
ReducedSolution solve_pyramid(int directions, const Step& step, const Demand& demand, const std::string& where,
                              const std::vector<std::size_t>& bodies, Solve&& solve) {
  expect_moderate(where, Index(demand.contacts.size()) * (2 + directions) + 6 * Index(bodies.size()), most_unknowns,
                  "unknowns");
  const AssembledProblem assembled = assembled_problem(step, demand, bodies);
  const ReducedPyramid pyramid(assembled.problem, directions);
  ReducedSolution solution = {assembled.problem, VectorXd::Zero(assembled.problem.size()), {}};
  solution.report.stop = oracle::Stop::solved;
  if (pyramid.size() == 0) return solution;
  VectorXd x;
  try {
    solution.report = solve(assembled, pyramid, x);
  } catch (const Error& error) {
    throw Error(error.failure(), where, error.what());
  }
  if (x.size() >= pyramid.size()) solution.impulses = pyramid.impulses(x.head(pyramid.size()));
  return solution;
}

ReducedSolution solve_lcp(const lcp::NamedSolver& solver, int directions, const Step& step, const Demand& demand,
                          const SolveLimits& limits, const std::string& where) {
  return solve_pyramid(directions, step, demand, where, {},
                       [&](const AssembledProblem&, const ReducedPyramid& pyramid, VectorXd& x) {
                         return solver.solve(pyramid.lcp(), limits, x);
                       });
}

ReducedSolution solve_mlcp(bool second, int directions, const Step& step, const Demand& demand,
                           const SolveLimits& limits, const std::string& where) {
  std::vector<std::size_t> bodies = second ? std::vector<std::size_t>() : touched(step.tree(), demand);
  const std::vector<std::size_t> ends = terminals(step.tree());
  bodies.insert(bodies.end(), ends.begin(), ends.end());
  return solve_pyramid(directions, step, demand, where, bodies,
                       [&](const AssembledProblem& problem, const ReducedPyramid& pyramid, VectorXd& x) {
                         const oracle::models::MixedLcp mixed =
                             second ? dca_mlcp2(problem, pyramid, bodies) : dca_mlcp1(problem, pyramid, bodies);
                         return lcp::fischer_newton(mixed.stacked(), limits, x);
                       });
}

}  // namespace

std::vector<std::string> reduced_solver_names() {
  std::vector<std::string> names;
  for (const oracle::ConeSolver& solver : oracle::cone_solvers())
    names.push_back("reduced_" + std::string(solver.name));
  for (const lcp::NamedSolver& solver : lcp::solvers()) names.push_back("reduced_pyramid_" + std::string(solver.name));
  for (const char* model : {"mlcp1", "mlcp2"}) names.push_back(std::string("reduced_") + model + "_fischer_newton");
  return names;
}

ReducedSolver find_reduced_solver(const std::string& name, int directions) {
  for (const oracle::ConeSolver& solver : oracle::cone_solvers()) {
    if (name == "reduced_" + std::string(solver.name))
      return [&solver](const Step& step, const Demand& demand, const VectorXd& start, const SolveLimits& limits,
                       const std::string& where) { return solve_cones(solver, step, demand, start, limits, where); };
  }
  for (const lcp::NamedSolver& solver : lcp::solvers()) {
    if (name == "reduced_pyramid_" + std::string(solver.name))
      return [&solver, directions](const Step& step, const Demand& demand, const VectorXd&, const SolveLimits& limits,
                                   const std::string& where) {
        return solve_lcp(solver, directions, step, demand, limits, where);
      };
  }
  const bool second = name == "reduced_mlcp2_fischer_newton";
  if (second || name == "reduced_mlcp1_fischer_newton")
    return [second, directions](const Step& step, const Demand& demand, const VectorXd&, const SolveLimits& limits,
                                const std::string& where) {
      return solve_mlcp(second, directions, step, demand, limits, where);
    };
  return {};
}

}  // namespace lockstep
