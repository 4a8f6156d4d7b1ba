// The one type of exception: what went wrong, where, and what to do about it.
#pragma once

#include <stdexcept>
#include <string>

namespace lockstep {

/// The exit status that the program ends with: a comparison failed or a run went bad; bad usage or input; the device
/// failed.
enum class Failure { comparison = 1, input = 2, device = 3 };

/// One clear line: "where: what is wrong and the cure". `where` is a file and JSON path (scenes/x.json:
/// /bodies/3/mass), or a stage and device. `what()` is the whole line; a device build log follows it on further lines.
class Error : public std::runtime_error {
 public:
  Error(Failure failure, const std::string& where, const std::string& what)
      : std::runtime_error(where.empty() ? what : where + ": " + what), failure_(failure) {}

  Failure failure() const { return failure_; }

 private:
  Failure failure_;
};

}  // namespace lockstep
