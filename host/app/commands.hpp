// The commands of the program, one file each. A command adds itself to the command line; its callback does the work and
// throws Error where that fails.
#pragma once

#include <CLI/CLI.hpp>

namespace lockstep::app {

void add_devices(CLI::App& program);
void add_scenes(CLI::App& program);
void add_run(CLI::App& program);
void add_check(CLI::App& program);
void add_verify(CLI::App& program);
void add_render(CLI::App& program);
void add_solve(CLI::App& program);
void add_export(CLI::App& program);
void add_bench(CLI::App& program);

}  // namespace lockstep::app
