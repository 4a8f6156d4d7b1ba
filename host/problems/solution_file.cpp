#include "host/problems/solution_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "cpu_reference/oracle/inverse_mass.hpp"
#include "host/problems/formats.hpp"
#include "host/problems/number_text.hpp"
#include "host/problems/rolling.hpp"
#include "host/record/whole_file.hpp"

namespace lockstep {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

void write_section(std::string& text, const char* name, const VectorXd& values, Index a_line) {
  text += fmt::format("{} {}\n", name, values.size());
  for (Index i = 0; i < values.size(); ++i)
    text += fmt::format("{:.17g}{}", values[i], (i + 1) % a_line == 0 || i + 1 == values.size() ? '\n' : ' ');
}

// Sections by name, or numbers alone, which are those of the first of `wanted`. What is not wanted is read over.
struct Section {
  const char* name;
  Index size;
  VectorXd values;
  bool found = false;
};

void read_sections(const std::string& path, std::string_view text, std::span<Section> wanted) {
  NumberText numbers(path, text);
  if (!numbers.more()) numbers.refuse("the solution", "the file is empty");
  if (!std::isalpha(static_cast<unsigned char>(numbers.next_character()))) {
    Section& first = wanted.front();
    const long long found = numbers.words_left();
    if (found != first.size) numbers.refuse(first.name, fmt::format("must have {} numbers, has {}", first.size, found));
    first.values = numbers.vector(first.name, first.size);
    first.found = true;
    return;
  }
  while (numbers.more()) {
    const std::string name(numbers.word("name of what follows"));
    const long long size = numbers.count("how many numbers of " + name, 0, 6 * most_contacts);
    const auto section = std::ranges::find(wanted, name, [](const Section& s) { return std::string(s.name); });
    if (section != wanted.end() && size != section->size)
      numbers.refuse(name, fmt::format("must have {} numbers, has {}; it is of another problem", section->size, size));
    const VectorXd values = numbers.vector(name, size);
    if (section == wanted.end()) continue;
    section->values = values;
    section->found = true;
  }
  if (!wanted.front().found) numbers.refuse(wanted.front().name, "is missing");
}

}  // namespace

ProblemSolution solution_of(const ConeFile& file, const oracle::ConeImpulses& impulses) {
  ProblemSolution solution;
  VectorXd u = file.problem.w.times(impulses.r) + file.problem.q;
  if (file.problem.joints) u += file.problem.joints->v * impulses.l;
  solution.u = file.dimension == 5 ? joined_velocities(u) : impulses_in_file(file, u);
  solution.r = impulses_in_file(file, impulses.r);
  solution.l = impulses.l;
  if (!file.global) return solution;
  const oracle::GlobalConeProblem& global = *file.global;
  VectorXd momentum = global.f + global.h * (global.dimension == 2 ? solution.r : impulses.r);
  if (global.g.cols() > 0) momentum += global.g * impulses.l;
  solution.v = oracle::InverseMass(global.m).times(momentum).head(file.velocities());
  return solution;
}

std::vector<unsigned char> encode_solution_text(const ProblemSolution& solution, std::uint32_t dimension) {
  std::string text;
  write_section(text, "r", solution.r, dimension);
  if (solution.l.size() > 0) write_section(text, "l", solution.l, 6);
  write_section(text, "u", solution.u, dimension);
  if (solution.v.size() > 0) write_section(text, "v", solution.v, 6);
  return {text.begin(), text.end()};
}

std::vector<unsigned char> encode_solution_text(const VectorXd& z, const VectorXd& w) {
  std::string text;
  write_section(text, "z", z, 1);
  write_section(text, "w", w, 1);
  return {text.begin(), text.end()};
}

oracle::ConeImpulses read_solution_file(const std::string& path, const ConeFile& file) {
  const std::vector<unsigned char> bytes = read_whole_file(path);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.starts_with("\x89HDF")) return read_fclib_solution(path, bytes, file);
  const Index joints = file.problem.joints ? file.problem.joints->s.size() : 0;
  Section wanted[] = {{"r", Index(file.dimension) * file.contacts(), {}}, {"l", joints, {}}};
  read_sections(path, text, wanted);
  return {impulses_in_problem(file, wanted[0].values), wanted[1].values};
}

VectorXd read_solution_text(const std::string& path, Index unknowns) {
  const std::vector<unsigned char> bytes = read_whole_file(path);
  Section wanted[] = {{"z", unknowns, {}}};
  read_sections(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}, wanted);
  return wanted[0].values;
}

}  // namespace lockstep
