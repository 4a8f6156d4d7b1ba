// Requests to end: SIGINT (Ctrl-C), SIGTERM and SIGHUP. While there is nothing to keep the program ends at once. A
// command that has something defers them: the first one ends what is under way at its next chance
// (host/stop_request.hpp), and what there is, is written; another one, more than a second later, ends the program at
// once. Files are whole either way: they get their names when they are, and a recording is at any moment.
#pragma once

namespace lockstep::app {

class Interrupt {
 public:
  /// From here on requests end the program at once, with 128 + the number of the signal.
  static void install();
  /// From here on the first one waits for asked() to be looked at.
  static void defer();

  /// Whether the program was asked to end since.
  static bool asked();
  /// The exit status of a program that was asked to: 128 + the number of the signal. 0 of one that was not.
  static int status();
};

}  // namespace lockstep::app
