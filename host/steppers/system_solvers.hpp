// The oracles that solve the constraint system of a step, by name: those of Coulomb's cone, also with joints as a part
// of their own, and those of linear complementarity problems on the friction pyramid (Model-LCP) and the friction box
// (M9), which are other models.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "cpu_reference/oracle/solve.hpp"
#include "host/report/contact_system.hpp"

namespace lockstep {

/// Gives the contacts and joints of a system the impulses that the solver finds, and its bodies their velocities.
/// Returns how it went; the residual is in the measure of the model that was solved: docs/reference/error_measures.md
/// has that of cones, lcp/lcp.hpp that of the others. Throws Error (input) that starts with `where` for a system that
/// is too large, and for what the model does not have.
using SystemSolver =
    std::function<oracle::SolveReport(ContactSystem& system, const oracle::SolveLimits&, const std::string& where)>;

/// Names of cone solvers, of mixed ones (joints/mixed.hpp), pyramid_NAME and box_NAME.
std::vector<std::string> system_solver_names();

/// `directions`: sides of the friction pyramid, at least 3. Empty where there is none of this name.
SystemSolver find_system_solver(const std::string& name, int directions);

/// Throws Error (input) that starts with `where` for more contacts, rows or unknowns (`what`) than a solver takes.
void expect_moderate(const std::string& where, Eigen::Index count, Eigen::Index most, const char* what);

}  // namespace lockstep
