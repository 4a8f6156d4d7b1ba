#include "host/steppers/system_solvers.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "cpu_reference/oracle/cone/whole.hpp"
#include "cpu_reference/oracle/joints/contradiction.hpp"
#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "cpu_reference/oracle/models/friction_box.hpp"
#include "cpu_reference/oracle/models/friction_pyramid.hpp"
#include "host/error.hpp"
#include "host/steppers/bounded_cones.hpp"
#include "host/steppers/multibody.hpp"
#include "host/steppers/system_problem.hpp"

namespace lockstep {

namespace {

using Eigen::Index;
using Eigen::VectorXd;
using oracle::SolveLimits;
using oracle::SolveReport;
namespace lcp = oracle::lcp;
namespace models = oracle::models;

// What takes minutes a step is no longer of use. Joints are taken out by dense factorisations, and complementarity
// problems are dense.
constexpr Index most_contacts_of_cones = 4000, most_contacts_of_mixed = 100'000, most_joint_rows = 1500,
                most_unknowns = 3000;

SolveReport solve_cones(const oracle::ConeSolver& solver, ContactSystem& system, const SolveLimits& limits,
                        const std::string& where) {
  const WholeSystemProblem whole = whole_problem_of(system);
  const oracle::GlobalConeProblem& problem = whole.problem.cones;
  expect_moderate(where, problem.mu.size(), most_contacts_of_cones, "contacts");
  expect_moderate(where, problem.g.cols(), most_joint_rows, "rows of joints");
  if (!whole.problem.laws.empty()) return solve_bounded_cones(solver, whole, system, limits);
  oracle::ConeSolution solution = oracle::solve_whole(oracle::local_form(problem), solver, limits, whole.impulses.r);
  if (solution.report.stop == Stop::stalled && oracle::proves_contradiction(problem, solution.beyond_joints))
    solution.report.stop = Stop::infeasible;
  set_impulses(system, impulses_of(system, oracle::MixedImpulses{solution.r, solution.l, {}}));
  return solution.report;
}

// All that a step has, and no size at which a dense factorisation would end.
SolveReport solve_by_mixed(const oracle::MixedSolver& solver, ContactSystem& system, const SolveLimits& limits,
                           const std::string& where) {
  expect_moderate(where, Index(system.contacts.size()), most_contacts_of_mixed, "contacts");
  const WholeSystemProblem whole = whole_problem_of(system);
  oracle::MixedImpulses impulses = whole.impulses;
  const SolveReport report = oracle::solve_mixed(whole.problem, solver, limits, impulses);
  set_impulses(system, impulses_of(system, impulses));
  return report;
}

// Of a pyramid or a box: the impulses of its solution.
template <class Model>
void take_over(const Model& model, const VectorXd& z, ContactSystem& system) {
  SystemImpulses impulses;
  for (std::size_t i = 0; i < system.contacts.size(); ++i) impulses.contacts.push_back(model.impulse(i, z));
  const VectorXd of_joints = model.joint_impulses(z), of_friction = model.dry_impulses(z);
  Index next = 0, next_dry = 0;
  for (const SystemJoint& j : system.joints) {
    Rows& rows = impulses.joints.emplace_back(Rows::Zero());
    for (u32 row = 0; row < JOINT_ROWS; ++row) {
      if ((j.locked >> row & 1) != 0) rows[row] = of_joints[next++];
    }
    impulses.free.push_back(has_friction(j) ? of_friction[next_dry++] : 0);
  }
  set_impulses(system, impulses);
}

// Joints and contacts that these models do not have are said with the step that has them.
models::Multibody multibody_at(const ContactSystem& system, const std::string& where) {
  try {
    return multibody(system);
  } catch (const Error& error) {
    throw Error(error.failure(), where, error.what());
  }
}

SolveReport solve_pyramid(const lcp::NamedSolver& solver, int directions, ContactSystem& system,
                          const SolveLimits& limits, const std::string& where) {
  const models::Multibody bodies = multibody_at(system, where);
  const models::FrictionPyramid pyramid(bodies, directions);
  expect_moderate(where, pyramid.size(), most_unknowns, "unknowns");
  VectorXd z;
  SolveReport report;
  try {
    report = solver.solve(pyramid.reduced(), limits, z);
  } catch (const Error& error) {
    throw Error(error.failure(), where, error.what());
  }
  if (z.size() == pyramid.size()) take_over(pyramid, z, system);
  return report;
}

SolveReport solve_box(const lcp::NamedBoxedSolver& solver, ContactSystem& system, const SolveLimits& limits,
                      const std::string& where) {
  const models::Multibody bodies = multibody_at(system, where);
  const models::FrictionBox box(bodies);
  const lcp::BoxedLcp problem = box.boxed();
  expect_moderate(where, problem.size(), most_unknowns, "unknowns");
  VectorXd z;
  const SolveReport report = solver.solve(problem, limits, z);
  if (z.size() == problem.size()) take_over(box, z, system);
  return report;
}

}  // namespace

void expect_moderate(const std::string& where, Eigen::Index count, Eigen::Index most, const char* what) {
  if (count > most)
    throw Error(
        Failure::input, where,
        fmt::format("{} {} are too many for this solver, which takes {}; take a smaller scene, or a solver that "
                    "sweeps",
                    count, what, most));
}

std::vector<std::string> system_solver_names() {
  std::vector<std::string> names;
  for (const oracle::ConeSolver& solver : oracle::cone_solvers()) names.emplace_back(solver.name);
  for (const oracle::MixedSolver& solver : oracle::mixed_solvers()) names.emplace_back(solver.name);
  for (const lcp::NamedSolver& solver : lcp::solvers()) names.push_back("pyramid_" + std::string(solver.name));
  for (const lcp::NamedBoxedSolver& solver : lcp::boxed_solvers()) names.push_back("box_" + std::string(solver.name));
  return names;
}

SystemSolver find_system_solver(const std::string& name, int directions) {
  if (const oracle::ConeSolver* solver = oracle::find_cone_solver(name)) {
    return [solver](ContactSystem& system, const SolveLimits& limits, const std::string& where) {
      return solve_cones(*solver, system, limits, where);
    };
  }
  if (const oracle::MixedSolver* solver = oracle::find_mixed_solver(name)) {
    return [solver](ContactSystem& system, const SolveLimits& limits, const std::string& where) {
      return solve_by_mixed(*solver, system, limits, where);
    };
  }
  for (const lcp::NamedSolver& solver : lcp::solvers()) {
    if (name == "pyramid_" + std::string(solver.name))
      return [&solver, directions](ContactSystem& system, const SolveLimits& limits, const std::string& where) {
        return solve_pyramid(solver, directions, system, limits, where);
      };
  }
  for (const lcp::NamedBoxedSolver& solver : lcp::boxed_solvers()) {
    if (name == "box_" + std::string(solver.name))
      return [&solver](ContactSystem& system, const SolveLimits& limits, const std::string& where) {
        return solve_box(solver, system, limits, where);
      };
  }
  return {};
}

}  // namespace lockstep
