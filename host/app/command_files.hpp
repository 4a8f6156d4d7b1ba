// The files that a command names: none takes the place of another one, or of one that the command reads.
#pragma once

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <string>

namespace lockstep::app {

/// An option that names a file; a name that is empty is refused.
CLI::Option* add_file_option(CLI::App& command, const char* names, std::string& path, const std::string& meaning);

struct CommandFile {
  const char* option;
  std::string path;  // empty: not given
};

/// Throws Error (input) where an output is the same file as another one or as an input, by whatever name. Devices and
/// pipes may be shared.
void expect_separate(std::initializer_list<CommandFile> outputs, std::initializer_list<CommandFile> inputs);

}  // namespace lockstep::app
