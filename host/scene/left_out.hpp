// What a reader leaves out of a robot's file, counted, so that a line at the end of loading says it.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/error.hpp"
#include "host/scene/robot_reading.hpp"

namespace lockstep {

/// The first three of a list, and how many there are beside them.
inline std::string first_few(const std::vector<std::string>& names) {
  constexpr std::size_t most = 3;
  std::string line;
  for (std::size_t i = 0; i < names.size() && i < most; ++i) line += (i == 0 ? "" : ", ") + names[i];
  return names.size() > most ? line + " and " + std::to_string(names.size() - most) + " more" : line;
}

class LeftOut {
 public:
  explicit LeftOut(const RobotReading& reading) : reading_(reading) {}

  const RobotReading& reading() const { return reading_; }

  /// `what` stands at `location`, and moves nothing.
  void add(const std::string& location, const std::string& what) {
    if (reading_.strict) throw Error(Failure::input, location, "is not simulated: it would be left out (--strict)");
    count(idle_, what);
  }
  /// `what` is how soft a constraint is.
  void add_softness(const std::string& location, const std::string& what) {
    if (reading_.strict) throw Error(Failure::input, location, "is not simulated: constraints are hard (--strict)");
    count(soft_, what);
  }
  /// `what` changes the motion: refused as `rule` says it, unless an approximation will do.
  void approximate(const std::string& location, const std::string& rule, const std::string& what) {
    if (!reading_.approximate) throw Error(Failure::input, location, rule);
    count(wrong_, what);
  }

  /// `what` is replaced by what is nearly the same.
  void replace(const std::string& what, const std::string& by) { count(replaced_, what + "` by `" + by); }

  /// A line for each kind: "left out: 3 x `camera`, 2 x `light`".
  std::vector<std::string> lines() const {
    std::vector<std::string> lines;
    add_line("left out: ", idle_, lines);
    add_line("hard here: ", soft_, lines);
    add_line("replaced: ", replaced_, lines);
    add_line("APPROXIMATED, the motion is another one: ", wrong_, lines);
    return lines;
  }

 private:
  using Counts = std::vector<std::pair<std::string, unsigned>>;  // as they were met

  static void count(Counts& counts, const std::string& what) {
    for (auto& [name, times] : counts)
      if (name == what) {
        ++times;
        return;
      }
    counts.emplace_back(what, 1);
  }
  static void add_line(const char* begin, const Counts& counts, std::vector<std::string>& lines) {
    std::string line;
    for (const auto& [name, times] : counts)
      line += (line.empty() ? begin : ", ") + std::to_string(times) + " x `" + name + "`";
    if (!line.empty()) lines.push_back(line);
  }

  RobotReading reading_;
  Counts idle_, soft_, replaced_, wrong_;
};

}  // namespace lockstep
