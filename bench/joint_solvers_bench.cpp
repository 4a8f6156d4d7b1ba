// Joints by direct and iterative solvers, and joints with contacts: time against size and against the residual. CSV.
//   joint_solvers_bench chains > joint_chains.csv     one solve of R x = c of chains, trees and nets: factors, then the
//                                                     solve; medians
//   joint_solvers_bench scenes > joint_contacts.csv   a step of scenes from zero, to two residuals, all that it takes
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>

#include "bench/median.hpp"
#include "cpu_reference/oracle/cone/whole.hpp"
#include "cpu_reference/oracle/dense.hpp"
#include "cpu_reference/oracle/joints/joint_solver.hpp"
#include "host/error.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "host/steppers/oracle_backend.hpp"
#include "host/steppers/system_problem.hpp"

namespace {

using namespace lockstep;
using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

std::string link(int k, double x, double y, double z, bool collides) {
  return fmt::format(
      R"({{"name": "b{}", "mass": 1, "position": [{}, {}, {}], "shapes": [{{"type": "box", "size": [0.4, 0.2, 0.2]{}}}]}})",
      k, x, y, z, collides ? "" : R"(, "collides_with": [])");
}

std::string ball(const std::string& a, const std::string& b, double x, double y, double z) {
  return fmt::format(R"({{"type": "ball", "bodies": ["{}", "{}"], "anchor": [{}, {}, {}]}})", a, b, x, y, z);
}

std::string name_of(int k) { return fmt::format("b{}", k); }

// Scenes of `count` boxes on ball joints, hung on the world: in a row, as a binary tree, as a net in rows of ten on two
// of its corners.
std::string jointed(const std::string& kind, int count) {
  std::string bodies, joints;
  const auto add = [](std::string& list, const std::string& item) { list += (list.empty() ? "" : ",\n") + item; };
  for (int k = 0; k < count; ++k) {
    // of a tree: a level to the right of its parent, to the left or to the right of it
    int level = 0, aside = 0;
    for (int up = k; kind == "tree" && up > 0; up = (up - 1) / 2, ++level) aside += up % 2 == 0 ? 1 : -1;
    double x = 0.5 * k, y = 0.1 * (k % 3);
    if (kind == "net") {
      x = 0.5 * (k % 10);
      y = 0.5 * (k / 10);
    } else if (kind == "tree") {
      x = 0.5 * level;
      y = 0.2 * aside;
    }
    add(bodies, link(k, x, y, 0, false));
    if (k == 0 || (kind == "net" && k == 9)) add(joints, ball("world", name_of(k), x - 0.25, y, 0.05));
    if (kind == "chain" && k > 0) add(joints, ball(name_of(k - 1), name_of(k), x - 0.25, y, 0.05));
    if (kind == "tree" && k > 0) add(joints, ball(name_of((k - 1) / 2), name_of(k), x - 0.25, y, 0.05));
    if (kind == "net" && k % 10 > 0) add(joints, ball(name_of(k - 1), name_of(k), x - 0.25, y, 0.05));
    if (kind == "net" && k >= 10) add(joints, ball(name_of(k - 10), name_of(k), x, y - 0.25, 0.05));
  }
  return fmt::format(R"({{"settings": {{"solver": "gauss_seidel"}}, "bodies": [{}], "joints": [{}]}})", bodies, joints);
}

// A chain of boxes that lies on the ground, to and fro, and a weight of 100 kg on its end.
std::string lying_chain(int count) {
  std::string bodies = R"({"type": "static", "shapes": [{"type": "plane"}]})", joints;
  for (int k = 0; k < count; ++k) {
    const double x = 0.5 * k, y = 0;
    bodies += ",\n" + link(k, x, y, 0.1, true);
    if (k > 0) joints += (k > 1 ? ",\n" : "") + ball(name_of(k - 1), name_of(k), x - 0.25, y, 0.1);
  }
  bodies += fmt::format(
      R"(, {{"name": "weight", "mass": 100, "position": [{}, 0, 0.25], "shapes": [{{"type": "box", "size": [0.4, 0.4, 0.5]}}]}})",
      0.5 * count);
  joints += ",\n" + ball(name_of(count - 1), "weight", 0.5 * count - 0.25, 0, 0.1);
  return fmt::format(R"({{"settings": {{"solver": "gauss_seidel"}}, "bodies": [{}], "joints": [{}]}})", bodies, joints);
}

// The system before the impulses of a step: the scene as it is after some steps solved to 1e-6.
WholeSystemProblem problem_at(Scene scene, u32 steps) {
  replace_solver(scene.settings, Solver::mixed_articulated);
  scene.settings.tolerance = 1e-6;
  std::optional<WholeSystemProblem> last;
  const SystemSolver inner = find_system_solver("mixed_articulated", 4);
  const SystemSolver keep = [&](ContactSystem& system, const oracle::SolveLimits& limits, const std::string& where) {
    last = whole_problem_of(system);
    return inner(system, limits, where);
  };
  const InitialState<double> state = compile<double>(scene);
  Simulation<double> simulation(std::make_unique<OracleBackend>(state, keep), state.params);
  for (u32 i = 0; i < steps; ++i) simulation.step();
  if (!last) throw Error(Failure::input, scene.name, "nothing is solved in its steps");
  return *last;
}

void print_joints(const std::string& kind, int count, const oracle::GlobalConeProblem& problem,
                  const std::string& method, const std::function<std::unique_ptr<oracle::JointSolver>()>& make) {
  std::vector<double> factor_ms, solve_ms;
  const oracle::SparseMatrix r = oracle::joint_mobility(problem);
  const Eigen::VectorXd c =
      problem.g.transpose() * oracle::inverse_times(problem.m, problem.f.sparseView()) + problem.b;
  double left = 0;
  for (double spent = 0; factor_ms.size() < 5 || (spent < 200 && factor_ms.size() < 21);) {
    const auto start = Clock::now();
    const auto solver = make();
    factor_ms.push_back(ms_since(start));
    const auto solving = Clock::now();
    const Eigen::VectorXd x = solver->solve(c);
    solve_ms.push_back(ms_since(solving));
    spent += factor_ms.back() + solve_ms.back();
    left = (c - r * x).norm() / c.norm();
    if (spent > 5000) break;
  }
  fmt::print("{},{},{},{},{:.4f},{:.4f},{:.1e}\n", kind, count, problem.g.cols(), method, bench::median(factor_ms),
             bench::median(solve_ms), left);
  std::fflush(stdout);
}

// What takes joints out for the solvers of cones: the eigenvalues of R, dense.
class Dense final : public oracle::JointSolver {
 public:
  explicit Dense(const oracle::GlobalConeProblem& problem)
      : inverse_(oracle::pseudo_inverse(Eigen::MatrixXd(oracle::joint_mobility(problem)), 1e-12)) {}
  Eigen::VectorXd solve(const Eigen::VectorXd& c) const override { return inverse_ * c; }

 private:
  Eigen::MatrixXd inverse_;
};

void chains() {
  fmt::print("problem,bodies,rows,method,factor_ms,solve_ms,left\n");
  for (const std::string kind : {"chain", "tree", "net"}) {
    for (const int count : {100, 200, 400, 1000, 2000, 4000, 10000}) {
      if (kind == "net" && count > 1000) continue;
      const WholeSystemProblem whole = problem_at(parse_scene(jointed(kind, count), kind), 1);
      const oracle::GlobalConeProblem& problem = whole.problem.cones;
      for (const oracle::JointMethod& method : oracle::joint_methods())
        print_joints(kind, count, problem, std::string(method.name), [&] { return method.make(problem, 1e-12); });
      if (problem.g.cols() <= 1200)
        print_joints(kind, count, problem, "dense", [&] { return std::make_unique<Dense>(problem); });
    }
  }
}

template <class Solve>
void print_solve(const std::string& problem, const oracle::MixedProblem& p, std::string_view solver, double tolerance,
                 Solve&& solve) {
  std::vector<double> ms;
  oracle::SolveReport report;
  for (double spent = 0; ms.empty() || (spent < 200 && ms.size() < 21); spent += ms.back()) {
    const auto start = Clock::now();
    report = solve();
    ms.push_back(ms_since(start));
  }
  fmt::print("{},{},{},{},{},{:g},{},{},{:.3f},{:.2e}\n", problem, p.cones.mu.size(), p.cones.g.cols(), p.laws.size(),
             solver, tolerance, oracle::stop_name(report.stop), report.iterations, bench::median(ms), report.residual);
  std::fflush(stdout);
}

void print_problem(const std::string& name, const oracle::MixedProblem& problem) {
  for (const double tolerance : {1e-4, 1e-8}) {
    const oracle::SolveLimits limits = {.tolerance = tolerance, .iterations = 100'000, .seconds = 20};
    for (const oracle::MixedSolver& solver : oracle::mixed_solvers())
      print_solve(name, problem, solver.name, tolerance, [&] {
        oracle::MixedImpulses x;
        return oracle::solve_mixed(problem, solver, limits, x);
      });
    if (!problem.laws.empty()) continue;  // that have no cone to be in
    for (const char* solver : {"nsgs", "auto"})
      print_solve(name, problem, solver, tolerance, [&] {
        return oracle::solve_whole(oracle::local_form(problem.cones), *oracle::find_cone_solver(solver), limits).report;
      });
  }
}

void scenes() {
  fmt::print("problem,contacts,joint_rows,bounded_rows,solver,tolerance,stop,iterations,ms,residual\n");
  const auto both = [](const std::string& name, const WholeSystemProblem& whole) {
    if (!whole.problem.laws.empty()) print_problem(name, whole.problem);
    oracle::MixedProblem bare = whole.problem;
    bare.d = oracle::SparseMatrix(bare.cones.m.rows(), 0);
    bare.laws.clear();
    print_problem(whole.problem.laws.empty() ? name : name + " without motors and limits", bare);
  };
  for (const auto& [name, steps] : {std::pair("rover", 60u), std::pair("rag_doll", 90u), std::pair("sweeper", 60u),
                                    std::pair("hanging_chain", 60u), std::pair("capstan", 60u)})
    both(name, problem_at(read_scene(name), steps));
  for (const int count : {20, 50, 100, 200, 400}) {
    const std::string name = fmt::format("lying chain of {}", count);
    both(name, problem_at(parse_scene(lying_chain(count), name), 10));
  }
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string what = argc == 2 ? argv[1] : "";
  if (what == "chains") {
    chains();
  } else if (what == "scenes") {
    scenes();
  } else {
    fmt::print(stderr, "joint_solvers_bench chains|scenes\n");
    return 2;
  }
} catch (const std::exception& error) {
  fmt::print(stderr, "joint_solvers_bench: {}\n", error.what());
  return 2;
}
