// Steps of our scenes solved by Siconos (Debian: python3-siconos, which scripts/install-packages installs): the field's
// own program reads what is exported, says of its impulses what we say of them, and solves to the same residual.
#include <gtest/gtest.h>

#include "cpu_reference/oracle/cone/whole.hpp"
#include "host/problems/cone_file.hpp"
#include "tests/command_line.hpp"

namespace lockstep::siconos_test {
namespace {

TEST_F(CommandLine, SiconosSolvesWhatIsExported) {
  const Outcome loaded = run_command("/usr/bin/python3 -c 'import siconos.numerics'");
  ASSERT_EQ(loaded.status, 0) << "needs Debian's python3-siconos; scripts/install-packages installs it\n" << loaded.err;
  const std::string path = file("p.dat").string(), impulses = file("r.txt").string();
  for (const char* step : {"spheres_small --at 90", "incline --at 40"}) {
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
      EXPECT_NEAR(of_siconos.natural_map, error_said, 1e-6 * error_said + 1e-14);

      const oracle::ConeSolution ours = oracle::solve_whole(problem.problem, *oracle::find_cone_solver("nsgs"),
                                                            {.tolerance = tolerance, .iterations = 100'000});
      EXPECT_EQ(ours.report.stop, oracle::Stop::solved);
      EXPECT_LT(ours.error.residual, 30 * of_siconos.residual + 1e-14);
      EXPECT_LT(of_siconos.residual, 30 * ours.error.residual + 1e-14);
    }
  }
}

}  // namespace
}  // namespace lockstep::siconos_test
