// What a robot file says that nothing here uses: counted while it is read, and told in one line at the end.
#pragma once

#include <fmt/format.h>

#include <map>
#include <string>
#include <vector>

#include "host/error.hpp"

namespace lockstep {

/// The first three of a list, and how many there are beside them.
inline std::string first_few(const std::vector<std::string>& names) {
  constexpr std::size_t most = 3;
  std::string line;
  for (std::size_t i = 0; i < names.size() && i < most; ++i) line += (i == 0 ? "" : ", ") + names[i];
  return names.size() > most ? line + fmt::format(" and {} more", names.size() - most) : line;
}

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
