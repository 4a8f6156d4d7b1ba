// `lockstep run` with an oracle in the place of the sweeps: what it asks of the scene and of the other options.
#pragma once

#include "host/app/options.hpp"
#include "host/problems/reduced_backend.hpp"

namespace lockstep::app {

struct OracleOptions {
  std::string solver;  // of oracle_names(); empty: the scene's own
  int directions = 4;  // of friction pyramids
};

/// --directions, and in the footer what the names stand for.
void add_oracle_options(CLI::App& command, OracleOptions& options);

/// Changes what the scene and the options say by themselves so that the oracle can run: double, on the reference, hard
/// contacts in cones, to a residual of 1e-10. Throws Error (input) for what was asked for and is not so.
void prepare_for_oracle(const OracleOptions& oracle, SceneOptions& options, Scene& scene);

/// Throws Error (comparison) where the oracle left something unsolved.
void expect_all_solved(const std::string& scene, const OracleOptions& oracle, double tolerance,
                       const Unsolved& unsolved);

}  // namespace lockstep::app
