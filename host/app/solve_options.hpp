// What `lockstep solve` was asked for, whatever the problem is.
#pragma once

#include <string>
#include <vector>

#include "cpu_reference/oracle/solve.hpp"

namespace lockstep::app {

struct SolveOptions {
  std::string problem, solver = "auto", report;
  std::string solution, guess;  // files (host/problems/solution_file.hpp)
  oracle::SolveLimits limits = {.tolerance = 1e-8, .iterations = 1'000'000, .seconds = 60};
  bool quiet = false;
};

/// Whether a solution goes to a file of HDF5 and not to a text.
bool solution_is_hdf5(const SolveOptions& options);

/// Of linear complementarity problems.
std::vector<std::string> lcp_solver_names();

/// Solves the linear complementarity problem of a text file (host/problems/lcp_text.hpp). Throws Error (comparison)
/// where the tolerance was not reached.
void solve_lcp(const SolveOptions& options);

/// Whether the program was asked to end before the solve had arrived.
bool is_interrupted(const SolveOptions& options, const oracle::SolveReport& report);

/// How it ended: the name of its Stop, or "interrupted".
std::string end_of(const SolveOptions& options, const oracle::SolveReport& report);

/// Throws Error (comparison) for a residual that is not what was asked for.
void expect_solved(const SolveOptions& options, const std::string& solver, const oracle::SolveReport& report);

}  // namespace lockstep::app
