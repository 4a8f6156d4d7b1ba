// The program `lockstep`. Exit statuses: 0 good, 1 a comparison failed, 2 bad usage or bad input, 3 device failure;
// 128 + the number of the signal where one asked it to end.
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>
#include <system_error>

#include "host/app/commands.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/ranks.hpp"
#include "host/error.hpp"
#include "host/scene/json_node.hpp"

namespace {

int fail(int status, const std::string& message) {
  fmt::print(stderr, "lockstep: {}\n", message);
  return status;
}

// An unknown option with the nearest that its command has; CLI11 lists all that it did not expect, the last first.
std::string unexpected(const CLI::App& program, int argc, char** argv, const CLI::ExtrasError& error) {
  std::vector<std::string> names;
  for (const CLI::App* command : program.get_subcommands())
    for (const CLI::Option* option : command->get_options())
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i], name = word.substr(0, word.find('='));
    if (!name.starts_with("--") || std::ranges::find(names, name) != names.end()) continue;
    const std::string near = lockstep::suggestion(name, names);
    return fmt::format("there is no option {}{} (try --help)", lockstep::quote(name),
                       near.starts_with("did") ? "; " + near : "");
  }
  return fmt::format("{} (try --help)", error.what());
}

// The exit status of a program that nobody asked to end.
int run_program(int argc, char** argv) {
  using namespace lockstep;
  CLI::App program(
      "A rigid-body simulator: bitwise identical results on GPU, CPU and a plain C++ reference, with error reported "
      "next to speed.",
      "lockstep");
  program.require_subcommand(1);
  program.set_version_flag("--version", std::string("lockstep ") + LOCKSTEP_VERSION, "Print the version and exit");
  program.footer(
      "Settings and solvers in full: docs/reference/settings.md\n"
      "Start with:\n"
      "  lockstep scenes\n"
      "  lockstep run slide_to_roll\n"
      "  lockstep check slide_to_roll --steps 200\n"
      "Exit status: 0 success; 1 a comparison failed, a problem stayed unsolved, or the run went bad; 2 bad usage or\n"
      "bad input; 3 device failure. SIGHUP, SIGINT (Ctrl-C) and SIGTERM stop it with 129, 130 and 143 after it has\n"
      "written its report, recording, checkpoint and pictures. A second signal stops it at once.");
  app::add_devices(program);
  app::add_scenes(program);
  app::add_run(program);
  app::add_check(program);
  app::add_verify(program);
  app::add_render(program);
  app::add_solve(program);
  app::add_export(program);
  app::add_bench(program);

  try {
    program.parse(argc, argv);
    return 0;
  } catch (const CLI::Success& help) {
    return program.exit(help);
  } catch (const CLI::RequiredError& error) {
    const bool unknown = argc > 1 && program.get_subcommands().empty();
    return fail(2, unknown ? fmt::format("there is no command '{}' (try --help)", argv[1])
                           : fmt::format("{} (try --help)", error.what()));
  } catch (const CLI::ExtrasError& error) {
    return fail(2, unexpected(program, argc, argv, error));
  } catch (const CLI::ParseError& error) {
    return fail(2, std::string(error.what()) + " (try --help)");
  } catch (const app::SilentExit& exit) {
    return exit.status;
  } catch (const Error& error) {
    return fail(static_cast<int>(error.failure()), error.what());
  } catch (const std::system_error& error) {
    // who reads no further, as head(1) does, ends the program without a word
    if (error.code() == std::errc::broken_pipe) return 128 + SIGPIPE;
    return fail(static_cast<int>(Failure::device), error.what());
  } catch (const std::bad_alloc&) {
    return fail(static_cast<int>(Failure::device), "out of memory; this machine needs a smaller scene");
  } catch (const std::exception& error) {
    return fail(static_cast<int>(Failure::device), error.what());
  }
}

}  // namespace

int main(int argc, char** argv) {
  using lockstep::app::Interrupt;
  std::signal(SIGPIPE, SIG_DFL);
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is told of by who writes it
  Interrupt::install();
  int status = run_program(argc, argv);
  errno = 0;
  if (std::fflush(stdout) != 0 && status == 0)
    status = fail(static_cast<int>(lockstep::Failure::device),
                  std::string("the output cannot be written to its end: ") + std::strerror(errno));
  return Interrupt::asked() ? Interrupt::status() : status;
}
