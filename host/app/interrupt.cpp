#include "host/app/interrupt.hpp"

#include <csignal>

namespace lockstep::app {

namespace {

volatile std::sig_atomic_t asked_to_end = 0;

extern "C" void ask_to_end(int signal) {
  asked_to_end = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

Interrupt::Interrupt() {
  std::signal(SIGINT, ask_to_end);
  std::signal(SIGTERM, ask_to_end);
}

Interrupt::~Interrupt() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

bool Interrupt::asked() { return asked_to_end != 0; }

}  // namespace lockstep::app
