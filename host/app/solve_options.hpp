// What `lockstep solve` was asked for, whatever the problem is.
#pragma once

#include <string>
#include <vector>

#include "cpu_reference/oracle/solve.hpp"

namespace lockstep::app {

struct SolveOptions {
  std::string problem, solver = "auto", report;
  oracle::SolveLimits limits = {.tolerance = 1e-8, .iterations = 1'000'000, .seconds = 60};
  bool quiet = false;
};

/// Of linear complementarity problems.
std::vector<std::string> lcp_solver_names();

/// Solves the linear complementarity problem of a text file (host/problems/lcp_text.hpp). Throws Error (comparison)
/// where the tolerance was not reached.
void solve_lcp(const SolveOptions& options);

/// Says of a solve that the program was asked to end that it was interrupted, unless it had arrived.
void note_interruption(const SolveOptions& options, oracle::SolveReport& report);

/// Throws Error (comparison) for a residual that is not what was asked for.
void expect_solved(const SolveOptions& options, const std::string& solver, const oracle::SolveReport& report);

}  // namespace lockstep::app
