#include "cpu_reference/oracle/cone/solvers.hpp"

#include <algorithm>
#include <array>

namespace lockstep::oracle {

namespace {

using Eigen::VectorXd;

constexpr std::array solvers = {
    ConeSolver{"auto", "Gauss-Seidel first, then what gets further", solve_automatically},
    ConeSolver{"nsgs", "blocked Gauss-Seidel, each contact solved exactly",
               [](const ConeProblem& p, const SolveLimits& l, VectorXd& r) { return nsgs(p, l, r); }},
    ConeSolver{"nsgs_enumeration", "the same, each contact by enumeration",
               [](const ConeProblem& p, const SolveLimits& l, VectorXd& r) {
                 return nsgs(p, l, r, LocalSolver::enumeration);
               }},
    ConeSolver{
        "nsgs_splitting", "the same, each contact by splitting",
        [](const ConeProblem& p, const SolveLimits& l, VectorXd& r) { return nsgs(p, l, r, LocalSolver::splitting); }},
    ConeSolver{"staggered", "normal and friction impulses in turn", staggered},
    ConeSolver{"projected_gradient", "projected gradient with line search", projected_gradient},
    ConeSolver{"apgd", "accelerated projected gradient with De Saxce's fixed point",
               [](const ConeProblem& p, const SolveLimits& l, VectorXd& r) { return accelerated_gradient(p, l, r); }},
    ConeSolver{
        "ccp_apgd", "the same on the relaxed cone complementarity problem, another model",
        [](const ConeProblem& p, const SolveLimits& l, VectorXd& r) { return accelerated_gradient(p, l, r, true); }},
    ConeSolver{"admm", "alternating direction method of multipliers", admm},
    ConeSolver{"newton", "semi-smooth Newton on Alart and Curnier's function", newton},
    ConeSolver{"proximal_point", "proximal point around Newton", proximal_point},
};

}  // namespace

std::span<const ConeSolver> cone_solvers() { return solvers; }

const ConeSolver* find_cone_solver(std::string_view name) {
  const auto found = std::ranges::find(solvers, name, &ConeSolver::name);
  return found == solvers.end() ? nullptr : &*found;
}

}  // namespace lockstep::oracle
