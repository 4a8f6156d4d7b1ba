// Ctrl-C, or a request to end: a run stops after its step, and what it wrote is closed. Another one, more than a second
// later, ends the program at once.
#pragma once

namespace lockstep::app {

class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  /// Whether the program was asked to end since the first of these was made.
  static bool asked();
};

}  // namespace lockstep::app
