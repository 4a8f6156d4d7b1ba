// Solutions in files: what is written is what solves the problem, and is read back; what does not fit is refused.
#include "host/problems/solution_file.hpp"

#include "cpu_reference/oracle/cone/whole.hpp"
#include "host/record/whole_file.hpp"
#include "tests/command_line.hpp"
#include "tests/oracle/cone_problems.hpp"

namespace lockstep::solution_file_test {
namespace {

using Eigen::VectorXd;

class SolutionFile : public CommandLine {
 protected:
  // A heap two velocities of which joints keep.
  static oracle::GlobalConeProblem jointed_heap() {
    oracle::GlobalConeProblem problem = oracle::random_heap(3, 5, 0.4, 2);
    problem.g = oracle::SparseMatrix(problem.m.rows(), 2);
    problem.g.insert(0, 0) = 1;
    problem.g.insert(7, 1) = 1;
    problem.b = Eigen::Vector2d(0.1, 0);
    return problem;
  }

  std::string path(const std::string& name) const { return file(name).string(); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(file(name)) << text; }
};

TEST_F(SolutionFile, ContainsWhatSolvesTheProblem) {
  const oracle::GlobalConeProblem problem = jointed_heap();
  replace_file(path("p.hdf5"), encode_fclib(problem, "heap"));
  const ConeFile read = read_cone_file(path("p.hdf5"));
  const auto found = oracle::solve_whole(read.problem, *oracle::find_cone_solver("auto"), {.tolerance = 1e-12});
  const ProblemSolution solution = solution_of(read, {found.r, found.l});
  EXPECT_LT((problem.m * solution.v - problem.f - problem.h * solution.r - problem.g * solution.l).norm(), 1e-12);
  EXPECT_LT((problem.h.transpose() * solution.v + problem.w - solution.u).norm(), 1e-12);
  EXPECT_LT((problem.g.transpose() * solution.v + problem.b).norm(), 1e-10);
}

TEST_F(SolutionFile, IsWrittenAndReadBackAsAGuess) {
  replace_file(path("p.hdf5"), encode_fclib(jointed_heap(), "heap"));
  write("p.dat", encode_siconos_text(oracle::local_form(oracle::random_heap(3, 5, 0.4, 2))));
  write("plane.dat", "2 1 0 2 2 2 2  0.25 0 0 0.25  -2 5  0.3");
  write("rolls.dat",
        "5 1 0 5 5 5 5  1 0 0 0 0  0 2 0 0 0  0 0 2 0 0  0 0 0 5 0  0 0 0 0 5 "
        "-2 9 0 0 4  0.5 0.1");
  for (const char* problem : {"p.hdf5", "p.dat", "plane.dat", "rolls.dat"}) {
    for (const char* kept : {"s.hdf5", "s.txt"}) {
      SCOPED_TRACE(std::string(problem) + " " + kept);
      const std::string solve = "solve " + path(problem) + " --tolerance 1e-10 --report " + path("r.json");
      const Outcome first = run(solve + " --solution " + path(kept));
      ASSERT_EQ(first.status, 0) << first.err;
      const Outcome again = run(solve + " --solver nsgs --guess " + path(kept));
      EXPECT_EQ(again.status, 0) << again.err;
      EXPECT_LE(nlohmann::json::parse(read_file(path("r.json")))["iterations"], 1);
    }
  }
  // the file of FCLIB is whole: problem and solution in one
  const std::string whole = path("whole.hdf5");
  ASSERT_EQ(run("solve " + path("p.hdf5") + " --solution " + whole).status, 0);
  const ConeFile both = read_cone_file(whole);
  ASSERT_TRUE(both.stored);
  EXPECT_LE(oracle::cone_error(both.problem, both.stored->r, both.stored->l).residual, 1e-8);
  EXPECT_EQ(run("solve " + whole + " --solver mixed_ldlt --guess " + whole).status, 0);
}

TEST_F(SolutionFile, TextsNameWhatTheyContain) {
  write("plane.dat", "2 1 0 2 2 2 2  0.25 0 0 0.25  -2 5  0.3");
  ASSERT_EQ(run("solve " + path("plane.dat") + " --solver nsgs --solution " + path("s.txt")).status, 0);
  std::istringstream text(read_file(path("s.txt")));
  std::string r, u;
  int rows = 0;
  double normal = 0, tangent = 0, normal_velocity = 0, slip = 0;
  ASSERT_TRUE(text >> r >> rows >> normal >> tangent >> u >> rows >> normal_velocity >> slip);
  EXPECT_EQ(r + u, "ru");
  EXPECT_NEAR(normal, 8, 1e-7);
  EXPECT_NEAR(tangent, -2.4, 1e-7);
  EXPECT_NEAR(normal_velocity, 0, 1e-7);
  EXPECT_NEAR(slip, 4.4, 1e-7);
  // of another program: the numbers of r alone
  write("r.txt", "8\n-2.4\n");
  EXPECT_EQ(run("solve " + path("plane.dat") + " --guess " + path("r.txt")).status, 0);
}

TEST_F(SolutionFile, IsWrittenOfComplementarityProblems) {
  // M = [2 1; 1 2], q = [-5, -6]: z = (4/3, 7/3)
  write("lcp.dat", "2\n0 2 2\n2 2\n2 1 1 2\n-5 -6\n");
  ASSERT_EQ(run("solve " + path("lcp.dat") + " --solution " + path("z.txt")).status, 0);
  std::istringstream text(read_file(path("z.txt")));
  std::string name;
  int size = 0;
  double first = 0, second = 0;
  ASSERT_TRUE(text >> name >> size >> first >> second);
  EXPECT_EQ(name, "z");
  EXPECT_NEAR(first, 4.0 / 3, 1e-12);
  EXPECT_NEAR(second, 7.0 / 3, 1e-12);
  EXPECT_EQ(run("solve " + path("lcp.dat") + " --solver pgs --iterations 1 --guess " + path("z.txt")).status, 0);
  EXPECT_EQ(run("solve " + path("lcp.dat") + " --solver pgs --iterations 1").status, 1) << "not without the guess";
  expect_refused("solve " + path("lcp.dat") + " --solution " + path("z.hdf5"), 2, "are texts");
  write("short.txt", "z 1\n1\n");
  expect_refused("solve " + path("lcp.dat") + " --guess " + path("short.txt"), 2, "must have 2 numbers, has 1");
}

TEST_F(SolutionFile, OfAnotherProblemIsRefused) {
  write("plane.dat", "2 1 0 2 2 2 2  0.25 0 0 0.25  -2 5  0.3");
  const std::string solve = "solve " + path("plane.dat") + " --guess " + path("g.txt");
  const auto refused = [&](const std::string& text, const std::string& expected) {
    write("g.txt", text);
    expect_refused(solve, 2, expected);
  };
  refused("r 3\n8 -2.4 0\n", "g.txt: line 1: r: must have 2 numbers, has 3; it is of another problem");
  refused("8 -2.4 0\n", "g.txt: line 1: r: must have 2 numbers, has 3");
  refused("u 2\n0 1\n", "g.txt: line 3: r: is missing");
  refused("r 2\n8", "g.txt: line 2: r: the file ends here");
  refused("r 2\n8 nan", "must be a finite number");
  refused("", "g.txt: line 1: the solution: the file is empty");
  expect_refused("solve " + path("plane.dat") + " --guess " + path("none.txt"), 2, "no such file");
  replace_file(path("p.hdf5"), encode_fclib(jointed_heap(), "heap"));
  expect_refused("solve " + path("plane.dat") + " --guess " + path("p.hdf5"), 2, "has neither a solution nor guesses");
  write("mine.txt", "what was there");
  expect_refused("solve " + path("plane.dat") + " --solution " + path("mine.txt"), 2, "does not overwrite it");
}

}  // namespace
}  // namespace lockstep::solution_file_test
