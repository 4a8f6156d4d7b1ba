#include "host/device/build_clock.hpp"

#include <unistd.h>

#include <cstdio>

namespace lockstep {

void tell_on_terminal(const std::string& line) {
  if (isatty(STDERR_FILENO) == 0) return;
  std::fprintf(stderr, "lockstep: %s\n", line.c_str());
  std::fflush(stderr);
}

}  // namespace lockstep
