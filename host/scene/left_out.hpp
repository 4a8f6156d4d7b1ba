// What a robot file says that nothing here uses: counted while it is read, and told in one line at the end.
#pragma once

#include <fmt/format.h>

#include <map>
#include <string>

#include "host/error.hpp"

namespace lockstep {

/// How robot files are read, whatever their format.
struct RobotReading {
  bool strict = false;                          // what would be left out is refused
  std::map<std::string, std::string> packages;  // folders of package://NAME, before all others
};

class LeftOut {
 public:
  explicit LeftOut(bool strict) : strict_(strict) {}

  /// One more of a kind: the name of an element, or "element attribute". Where reading is strict, throws Error (input).
  void add(const std::string& kind, const std::string& location) {
    if (strict_)
      throw Error(Failure::input, location, fmt::format("`{}` is not used here, and reading is strict", kind));
    ++counts_[kind];
  }

  /// "left out: 3 x `transmission`, 1 x `link type`"; empty where nothing was.
  std::string line() const {
    std::string line;
    for (const auto& [kind, count] : counts_)
      line += fmt::format("{}{} x `{}`", line.empty() ? "left out: " : ", ", count, kind);
    return line;
  }

 private:
  bool strict_;
  std::map<std::string, unsigned> counts_;
};

}  // namespace lockstep
