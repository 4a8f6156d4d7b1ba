// A request to end ends every solver between two iterations, and a step of an oracle with the state that it began with.
#include <gtest/gtest.h>

#include "cpu_reference/oracle/cone/whole.hpp"
#include "cpu_reference/oracle/joints/mixed.hpp"
#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "host/report/report.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "host/steppers/oracles.hpp"
#include "host/steppers/stepper.hpp"
#include "host/stop_request.hpp"
#include "host/world_hash.hpp"
#include "tests/oracle/cone_problems.hpp"
#include "tests/oracle/lcp_problems.hpp"

namespace lockstep::stop_test {
namespace {

struct StopIsAsked {
  StopIsAsked() { ask_to_stop(); }
  ~StopIsAsked() { stop_is_asked = false; }
};

Scene scene_by(const std::string& name, const std::string& solver) {
  Scene scene = read_scene(name);
  replace_solver(scene.settings, *find_solver(solver));
  return scene;
}

Simulation<double> simulation_of(const Scene& scene) {
  const InitialState<double> state = compile<double>(scene);
  return {make_stepper(state, target_of("reference", {}, state.oracle)).backend, state.params};
}

std::uint64_t hash_of(Simulation<double>& simulation) { return combined_state_hash(simulation.world_hashes()); }

// That no residual and no other limit ends.
constexpr oracle::SolveLimits endless = {.tolerance = 1e-300, .iterations = 4'000'000'000, .seconds = 1e9};

void expect_ended(const oracle::SolveReport& report, const Eigen::VectorXd& x) {
  EXPECT_LE(report.iterations, 1u);
  EXPECT_NE(report.stop, oracle::Stop::solved);
  EXPECT_TRUE(x.allFinite());
}

TEST(Stop, EverySolverEndsAtItsNextLookWithWhatItHas) {
  const oracle::GlobalConeProblem global = oracle::random_heap(20, 60, 0.4, 1);
  const oracle::ConeProblem local = oracle::local_form(global);
  oracle::lcp::test::Random random(1);
  const oracle::lcp::Lcp lcp = random_p_matrix(random, 12, 0.1);
  const StopIsAsked asked;
  for (const oracle::ConeSolver& solver : oracle::cone_solvers()) {
    SCOPED_TRACE(solver.name);
    Eigen::VectorXd r;
    const oracle::SolveReport report = solver.solve(local, endless, r);
    expect_ended(report, r);
    EXPECT_EQ(r.size(), local.q.size());
  }
  for (const oracle::MixedSolver& solver : oracle::mixed_solvers()) {
    SCOPED_TRACE(solver.name);
    oracle::MixedImpulses x;
    const oracle::MixedProblem problem = {global, oracle::SparseMatrix(global.m.rows(), 0), {}};
    const oracle::SolveReport report = oracle::solve_mixed(problem, solver, endless, x);
    expect_ended(report, x.r);
  }
  for (const oracle::lcp::NamedSolver& solver : oracle::lcp::solvers()) {
    SCOPED_TRACE(solver.name);
    Eigen::VectorXd z;
    const oracle::SolveReport report = solver.solve(lcp, endless, z);
    expect_ended(report, z);
    EXPECT_EQ(z.size(), lcp.size());
  }
}

TEST(Stop, AStepThatIsGivenUpLeavesTheStateBeforeItAndCanBeMadeLater) {
  const std::pair<const char*, const char*> runs[] = {{"rag_doll", "nsgs"},
                                                      {"rag_doll", "mixed_articulated"},
                                                      {"rag_doll", "impulse_based"},
                                                      {"rag_doll", "reduced_nsgs"},
                                                      {"incline", "pyramid_lemke"}};
  for (const auto& [name, solver] : runs) {
    SCOPED_TRACE(solver);
    const Scene scene = scene_by(name, solver);
    Simulation<double> simulation = simulation_of(scene), straight = simulation_of(scene);
    for (int i = 0; i < 3; ++i) {
      simulation.step();
      straight.step();
    }
    const std::uint64_t before = hash_of(simulation);
    {
      const StopIsAsked asked;
      EXPECT_THROW(simulation.step(), Stopped);
    }
    EXPECT_EQ(simulation.steps_done(), 3u);
    EXPECT_EQ(hash_of(simulation), before);
    simulation.step();
    straight.step();
    EXPECT_EQ(hash_of(simulation), hash_of(straight));
    EXPECT_NE(hash_of(simulation), before);
  }
}

}  // namespace
}  // namespace lockstep::stop_test
