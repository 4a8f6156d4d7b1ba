#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "host/app/bench_results.hpp"
#include "host/error.hpp"
#include "host/record/whole_file.hpp"

namespace lockstep::app {

namespace {

// As gnuplot wants it: between double quotes it would run what is between back-quotes.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("''") : std::string(1, c == '\n' ? ' ' : c);
  return result + "'";
}

struct Line {
  std::string label;
  std::size_t method, precision;  // colour, and kind of line
  std::vector<std::pair<double, double>> points;
};

// Powers of ten have no zero: exact results and steps too short to time are left to the table.
std::vector<Line> lines_of(const BenchCase& benched) {
  const bool devices = std::ranges::any_of(benched.trials, [&](const BenchTrial& t) {
    return t.device != benched.trials[0].device && t.device != "reference";
  });
  std::vector<std::string> methods;
  std::vector<Line> lines;
  for (const BenchTrial& t : benched.trials) {
    if (t.errors.empty() || !(t.errors[0].error > 0) || !(t.ms_per_step > 0)) continue;
    if (std::ranges::find(methods, t.method) == methods.end()) methods.push_back(t.method);
    const std::string label = fmt::format("{}, {}{}", t.method, t.precision, devices ? ", " + t.device : "");
    auto line = std::ranges::find(lines, label, &Line::label);
    if (line == lines.end()) {
      const auto method = static_cast<std::size_t>(std::ranges::find(methods, t.method) - methods.begin());
      line = lines.insert(lines.end(), {label, method, t.precision == "double", {}});
    }
    line->points.emplace_back(t.ms_per_second(), t.errors[0].error);
  }
  return lines;
}

std::string script_of(const BenchCase& benched, const std::vector<Line>& lines) {
  constexpr const char* colors[] = {"#0b6fa4", "#c1441e", "#3d8b37", "#7b4fa3", "#a07900", "#555555"};
  const CaseError& plotted = benched.quantities()[0];
  std::string script =
      "set terminal svg size 820,400 dynamic noenhanced font 'sans-serif,13' background '#ffffff'\n"
      "set logscale xy\nset format '%.0e'\nset grid lc rgb '#dddddd'\nset border 3\nset tics nomirror\n"
      "set key outside right top vertical Left reverse samplen 2 spacing 1.2\n"
      "set offsets graph 0.05, graph 0.05, graph 0.05, graph 0.05\n"
      "set xlabel 'ms for a second of simulated time'\n";
  const std::string unit = plotted.unit.empty() ? "" : " (" + plotted.unit + ")";
  script += fmt::format("set ylabel {}\nplot ", quoted("error: " + plotted.quantity + unit));
  for (const Line& line : lines)
    script += fmt::format("{}'-' using 1:2 with linespoints lc rgb '{}' dt {} pt {} ps 0.7 lw 1.6 title {}",
                          &line == &lines[0] ? "" : ", ", colors[line.method % std::size(colors)],
                          line.precision == 0 ? 1 : 2, line.precision == 0 ? 7 : 6, quoted(line.label));
  script += "\n";
  for (const Line& line : lines) {
    for (const auto& [cost, error] : line.points) script += fmt::format("{:.6g} {:.6g}\n", cost, error);
    script += "e\n";
  }
  return script;
}

}  // namespace

bool can_plot() { return std::system("command -v gnuplot > /dev/null 2>&1") == 0; }

bool write_plot(const BenchCase& benched, const std::string& path) {
  const std::vector<Line> lines = lines_of(benched);
  if (lines.empty()) return false;
  std::signal(SIGPIPE, SIG_IGN);  // a gnuplot that gives up is told of as an error
  // gnuplot is told no name, which could be of any bytes
  std::string name;
  const int descriptor = make_beside(path, name);
  std::FILE* gnuplot =
      descriptor < 0 ? nullptr : popen(fmt::format("gnuplot >&{} 2> /dev/null", descriptor).c_str(), "w");
  const std::string script = script_of(benched, lines);
  bool written = gnuplot != nullptr && std::fwrite(script.data(), 1, script.size(), gnuplot) == script.size();
  written = gnuplot != nullptr && pclose(gnuplot) == 0 && written;
  if (descriptor >= 0) ::close(descriptor);
  if (written && std::rename(name.c_str(), path.c_str()) == 0) return true;
  ::unlink(name.c_str());
  throw Error(Failure::device, path, "gnuplot could not write the plot");
}

}  // namespace lockstep::app
