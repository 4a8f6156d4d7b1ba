// All solvers of linear complementarity problems on all problems: text files of a folder, and our own, as CSV on the
// standard output. A failure is a row like any other.
//   lcp_solvers_bench [FOLDER] > bench/results/<machine>/lcp_solvers.csv
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "cpu_reference/oracle/models/friction_box.hpp"
#include "cpu_reference/oracle/models/friction_pyramid.hpp"
#include "host/backends/reference_backend.hpp"
#include "host/error.hpp"
#include "host/problems/lcp_text.hpp"
#include "host/report/measures.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "host/steppers/multibody.hpp"

namespace {

using namespace lockstep;
using namespace lockstep::oracle;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr SolveLimits limits = {.tolerance = 1e-10, .iterations = 100'000, .seconds = 10};
constexpr int repetitions = 5;  // of solves below a tenth of a second: the median is written

template <class Problem, class Named>
void run(const std::string& name, const std::string& kind, const Problem& problem, const Named& solver) {
  if (solver.name == "enumeration" && problem.size() > 20) return;  // out of its reach, and said so
  std::vector<double> seconds;
  SolveReport report;
  while (int(seconds.size()) < repetitions) {
    VectorXd z;
    report = solver.solve(problem, limits, z);
    seconds.push_back(report.seconds);
    if (report.seconds > 0.1) break;
  }
  std::sort(seconds.begin(), seconds.end());
  fmt::print("{},{},{},{},{},{},{:.3g},{:.6f}\n", name, kind, problem.size(), solver.name, stop_name(report.stop),
             report.iterations, report.residual, 1e3 * seconds[seconds.size() / 2]);
}

void run_all(const std::string& name, const lcp::Lcp& problem) {
  for (const lcp::NamedSolver& solver : lcp::solvers()) run(name, "lcp", problem, solver);
}

void run_folder(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".dat") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  for (const auto& path : paths) run_all(path.filename().string(), read_lcp_text(path));
}

// Positive definite, 500 unknowns; `skew` makes it unsymmetric.
lcp::Lcp random_problem(double skew) {
  constexpr Index n = 500;
  std::mt19937 bits(1);
  const auto number = [&] { return (bits() >> 8) / 8388608.0 - 1; };
  const MatrixXd a = MatrixXd::NullaryExpr(n, n, number), b = MatrixXd::NullaryExpr(n, n, number);
  return {a * a.transpose() / double(n) + 0.1 * MatrixXd::Identity(n, n) + skew * (b - b.transpose()),
          VectorXd::NullaryExpr(n, number)};
}

// Murty's matrix, and its transpose, which does to Lemke's method what it does to the least-index one.
lcp::Lcp murty_exponential(Index n) {
  MatrixXd m = MatrixXd::Identity(n, n);
  for (Index j = 0; j < n; ++j) m.col(j).head(j).setConstant(2);
  return {m, -VectorXd::Ones(n)};
}

void run_scene(const std::string& name, u32 steps) {
  const InitialState<double> state = compile<double>(read_scene(name));
  Simulation<double> simulation(std::make_unique<ReferenceBackend<double>>(state), state.params);
  for (u32 i = 0; i < steps; ++i) simulation.step();
  const Counters counters = simulation.counters();
  const models::Multibody system = multibody(
      contact_system(simulation.backend().download(measured_buffers(simulation.backend().features())), counters));

  const models::Rows rows(system);
  const models::JointElimination joints(rows, system);
  lcp::Lcp pressed = {joints.delassus(rows.normal), joints.free_velocity(rows.normal)};
  for (std::size_t i = 0; i < system.contacts.size(); ++i) pressed.q[Index(i)] += system.contacts[i].bias;
  run_all(name + " normals", pressed);
  for (const int directions : {4, 8})
    run_all(fmt::format("{} pyramid {}", name, directions), models::FrictionPyramid(system, directions).reduced());
  const lcp::BoxedLcp box = models::FrictionBox(system).boxed();
  for (const lcp::NamedBoxedSolver& solver : lcp::boxed_solvers()) run(name + " box", "boxed", box, solver);
}

}  // namespace

int main(int count, char** arguments) {
  try {
    fmt::print("problem,kind,unknowns,solver,stopped_by,iterations,residual,ms\n");
    if (count > 1) run_folder(arguments[1]);
    for (const Index n : {6, 12, 30}) {
      const lcp::Lcp p = murty_exponential(n);
      run_all(fmt::format("murty {}", n), p);
      run_all(fmt::format("murty {} transposed", n), {p.m.transpose(), p.q});
    }
    run_all("random symmetric", random_problem(0));
    run_all("random skew", random_problem(0.05));
    for (const char* scene : {"three_cubes", "box_stack", "mass_ratio"}) run_scene(scene, 40);
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return static_cast<int>(e.failure());
  }
}
