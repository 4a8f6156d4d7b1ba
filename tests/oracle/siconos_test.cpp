// Steps of our scenes solved by Siconos (Debian: python3-siconos, which scripts/install-packages installs): the field's
// own program reads what is exported, says of its impulses what we say of them, and solves to the same residual.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/cone/whole.hpp"
#include "host/problems/cone_file.hpp"
#include "tests/command_line.hpp"
#include "tests/oracle/cone_problems.hpp"

namespace lockstep::siconos_test {
namespace {

TEST_F(CommandLine, SiconosSolvesWhatIsExported) {
  const Outcome loaded = run_command("/usr/bin/python3 -c 'import siconos.numerics'");
  ASSERT_EQ(loaded.status, 0) << "needs Debian's python3-siconos; scripts/install-packages installs it\n" << loaded.err;
  const std::string path = file("p.dat").string(), impulses = file("r.txt").string();
  for (const char* step : {"spheres_small --at 90", "incline --at 80"}) {
    SCOPED_TRACE(step);
    ASSERT_EQ(run("export " + std::string(step) + " --device reference --quiet -o " + path).status, 0);
    const ConeFile problem = read_cone_file(path);
    for (const double tolerance : {1e-4, 1e-6}) {
      const Outcome siconos = run_command("/usr/bin/python3 " LOCKSTEP_SOURCE_DIR "/bench/siconos_solve.py " + path +
                                          " nsgs " + std::to_string(tolerance * 1e9) + "e-9 " + impulses);
      ASSERT_EQ(siconos.status, 0) << siconos.err;
      int solved = 0, iterations = 0;
      double error_said = 0;
      std::istringstream(siconos.out) >> solved >> iterations >> error_said;
      EXPECT_EQ(solved, 1) << siconos.out;

      std::ifstream stream(impulses);
      Eigen::VectorXd r(problem.problem.q.size());
      for (double& number : r) ASSERT_TRUE(stream >> number);
      const oracle::ConeError of_siconos = oracle::cone_error(problem.problem, r);
      // Siconos 4.4 divides by the largest of |q|, |r| and |u|
      EXPECT_NEAR(of_siconos.natural_largest, error_said, 1e-6 * error_said + 1e-14);

      const oracle::ConeSolution ours = oracle::solve_whole(problem.problem, *oracle::find_cone_solver("nsgs"),
                                                            {.tolerance = tolerance, .iterations = 100'000});
      EXPECT_EQ(ours.report.stop, oracle::Stop::solved);
      EXPECT_LT(ours.error.residual, 30 * of_siconos.residual + 1e-14);
      EXPECT_LT(of_siconos.residual, 30 * ours.error.residual + 1e-14);
    }
  }
}

// tests/siconos_check.py reads the problem itself, checks the equations and the laws of what `lockstep solve` wrote,
// and asks Siconos; the other way round Siconos solves, and its impulses are our guess.
TEST_F(CommandLine, SolutionsPassAMeasureThatSharesNothing) {
  const auto write = [&](const char* name, const std::string& text) {
    std::ofstream(file(name)) << text;
    return file(name).string();
  };
  const oracle::GlobalConeProblem heap = oracle::random_heap(3, 7, 0.4, 2);
  const oracle::ConeProblem local = oracle::local_form(heap);
  std::string global = "3 7\n";
  for (const Eigen::MatrixXd& m : {Eigen::MatrixXd(heap.m), Eigen::MatrixXd(heap.h)})
    global += fmt::format("0 {0} {1} {0} {1} {2}\n", m.rows(), m.cols(),
                          fmt::join(std::span(m.data(), std::size_t(m.size())), " "));
  for (const Eigen::VectorXd& v : {heap.f, heap.w, heap.mu}) global += fmt::format("{} ", fmt::join(v, " "));
  const std::pair<std::string, std::string> problems[] = {
      {write("local.dat", encode_siconos_text(local)), "local"},
      {write("global.dat", global), "global"},
      {write("rolls.dat",
             "5 1 0 5 5 5 5  1 .1 0 0 .2  .1 2 0 0 0  0 0 2 .3 0  0 0 .3 5 0  .2 0 0 0 5  -2 9 0 0 4  0.5 0.1"),
       "local"}};
  const std::string check = "/usr/bin/python3 " LOCKSTEP_SOURCE_DIR "/tests/siconos_check.py ";
  for (const auto& [path, kind] : problems) {
    SCOPED_TRACE(path);
    const std::string ours = file("ours.txt").string(), theirs = file("theirs.txt").string();
    const Outcome solved = run("solve " + path + " --tolerance 1e-10 --quiet --solution " + ours);
    ASSERT_EQ(solved.status, 0) << solved.err;
    const Outcome checked = run_command(check + path + " " + ours);
    ASSERT_EQ(checked.status, 0) << checked.err;
    const nlohmann::json found = nlohmann::json::parse(checked.out);
    EXPECT_EQ(found["kind"], kind);
    EXPECT_LT(found["equations"], 1e-12);
    EXPECT_LT(found["laws"], 1e-9);
    EXPECT_LT(found["siconos"], 1e-9);
    const Outcome siconos = run_command(check + path + " --solve " + theirs);
    ASSERT_EQ(siconos.status, 0) << siconos.err;
    ASSERT_EQ(run("solve " + path + " --quiet --guess " + theirs + " --report " + file("r.json").string()).status, 0);
    EXPECT_LT(nlohmann::json::parse(read_file(file("r.json")))["guess_residual"], 1e-8);
  }
  // a wrong solution does not hold
  const std::string wrong = write("wrong.txt", "r 5\n2 0 0 0 -0.2\nu 5\n0 9 0 0 3\n");
  const nlohmann::json found = nlohmann::json::parse(run_command(check + problems[2].first + " " + wrong).out);
  EXPECT_GT(found["equations"], 1e-3);
  EXPECT_GT(found["laws"], 1e-3);
}

}  // namespace
}  // namespace lockstep::siconos_test
