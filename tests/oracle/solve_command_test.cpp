// `lockstep solve` and `lockstep export` as a user meets them.
#include "tests/command_line.hpp"

namespace lockstep::solve_command_test {
namespace {

TEST_F(CommandLine, ExportsAndSolves) {
  const std::string path = file("step.hdf5").string(), report = file("report.json").string();
  const Outcome exported = run("export spheres_small --at 90 -o " + path + " --device reference");
  ASSERT_EQ(exported.status, 0) << exported.err;
  EXPECT_NE(exported.out.find("spheres_small, step 90: "), std::string::npos) << exported.out;
  const Outcome solved = run("solve " + path + " --report " + report);
  ASSERT_EQ(solved.status, 0) << solved.err;
  for (const char* word : {"FCLIB, global", "stopped by", "residual", "MERIT_1", "residual of the stored"})
    EXPECT_NE(solved.out.find(word), std::string::npos) << solved.out;
  const nlohmann::json json = nlohmann::json::parse(read_file(report));
  EXPECT_TRUE(json["converged"]);
  EXPECT_LE(json["residual"], 1e-8);
  EXPECT_EQ(json["solver"], "auto");
  EXPECT_GT(json["contacts"], 10);
  for (const char* key :
       {"natural_map", "natural_largest", "alart_curnier", "jean_moreau", "merit_1", "iterations", "seconds", "stop",
        "residual_floor", "defect_velocity_max", "tolerance", "form", "joint_rows"})
    EXPECT_TRUE(json.contains(key)) << key;
  ASSERT_EQ(run("export spheres_small --at 90 --local --quiet -o " + path + " --device reference").out, "");
  EXPECT_NE(run("solve " + path + " --solver nsgs").out.find("FCLIB, local"), std::string::npos);
}

TEST_F(CommandLine, TellsWhereASolveDidNotGetThere) {
  std::ofstream(file("one.dat")) << "3 1 0 3 3 3 3  15 -1 -2  -1 14 1  -2 1 16  -1 2 3  0.1";
  const std::string path = file("one.dat").string();
  EXPECT_EQ(run("solve " + path).status, 0);
  const Outcome relaxed = run("solve " + path + " --solver ccp_apgd");
  EXPECT_EQ(relaxed.status, 1);
  EXPECT_NE(relaxed.out.find("stopped by                stall"), std::string::npos) << relaxed.out;
  EXPECT_EQ(std::count(relaxed.err.begin(), relaxed.err.end(), '\n'), 1) << relaxed.err;
  const Outcome early = run("solve " + path + " --solver projected_gradient --iterations 1 --quiet");
  EXPECT_EQ(early.status, 1);
  EXPECT_EQ(early.out, "");
  EXPECT_NE(early.err.find("more --iterations"), std::string::npos) << early.err;
}

TEST_F(CommandLine, SolvesComplementarityProblems) {
  // M = [2 1; 1 2], q = [-5, -6]: z = (4/3, 7/3)
  std::ofstream(file("lcp.dat")) << "2\n0 2 2\n2 2\n2 1 1 2\n-5 -6\n";
  const std::string path = file("lcp.dat").string(), report = file("lcp.json").string();
  for (const char* solver : {"auto", "lemke", "keller", "pgs", "enumeration"}) {
    const Outcome solved = run("solve " + path + " --solver " + solver + " --report " + report);
    EXPECT_EQ(solved.status, 0) << solved.err;
    EXPECT_NE(solved.out.find("linear complementarity, 2 unknowns"), std::string::npos) << solved.out;
    const nlohmann::json json = nlohmann::json::parse(read_file(report));
    EXPECT_NEAR(json["solution"][0], 4.0 / 3, 1e-7);
    EXPECT_NEAR(json["solution"][1], 7.0 / 3, 1e-7);
  }
  std::ofstream(file("none.dat")) << "1\n0 1 1\n1 1\n0\n-1\n";  // 0 z - 1 >= 0
  EXPECT_EQ(run("solve " + file("none.dat").string()).status, 1);
  expect_refused("solve " + path + " --solver admm", 2, "is not for those; try enumeration, lemke");
  std::ofstream(file("cut.dat")) << "2\n0 2 2\n2 2\n2 1 1";
  expect_refused("solve " + file("cut.dat").string(), 2, "cut.dat: line 4: the matrix: the file ends");
  std::ofstream(file("cone.dat")) << "3 1 0 3 3 3 3  15 -1 -2  -1 14 1  -2 1 16  -1 2 3  0.1";
  expect_refused("solve " + file("cone.dat").string() + " --solver lemke", 2, "is a contact problem");
}

// The tables of 3.6 and 3.7 for ten bodies, of which nine rest on others, and a scene with motors.
TEST_F(CommandLine, PrintsModelSizes) {
  const Outcome stack = run("export box_stack --at 3 --sizes --directions 6 --quiet --device reference");
  ASSERT_EQ(stack.status, 0) << stack.err;
  EXPECT_NE(stack.out.find("box_stack, step 3: 10 bodies that move, 10 of them in contact; 0 joints, 40 contacts"),
            std::string::npos)
      << stack.out;
  const auto unknowns = [](const std::string& text, const std::string& model) {
    const std::size_t at = text.find("  " + model + " ");
    return at == std::string::npos ? -1 : std::stoi(text.substr(at + 2 + model.size()));
  };
  EXPECT_EQ(unknowns(stack.out, "Model-mNCP"), 4 * 40 + 13 * 10);
  EXPECT_EQ(unknowns(stack.out, "Model-mLCP"), (2 + 6) * 40 + 6 * 10);
  EXPECT_EQ(unknowns(stack.out, "Model-LCP"), (2 + 6) * 40);
  EXPECT_EQ(unknowns(stack.out, "Model-DCA-mLCP1"), (2 + 6) * 40 + 12 + 6 * 10);
  const Outcome jointed = run("export rover --at 1 --sizes --quiet --device reference");
  EXPECT_EQ(jointed.status, 0) << jointed.err;
  EXPECT_GT(unknowns(jointed.out, "Model-mLCP"), unknowns(jointed.out, "Model-LCP"));
}

TEST_F(CommandLine, RefusesToSolveAndExportInOneLine) {
  expect_refused("solve", 2, "problem");
  expect_refused("solve " + file("none.hdf5").string(), 2, "no such file");
  std::ofstream(file("bad.dat")) << "3 1 0 3 3 3 3  15 -1";
  expect_refused("solve " + file("bad.dat").string(), 2, "bad.dat: line 1: the matrix");
  expect_refused("solve x.dat --solver magic", 2, "nsgs");
  expect_refused("solve x.dat --tolerance -1", 2, "--tolerance");
  expect_refused("solve x.dat --tolerance nan", 2, "--tolerance");
  expect_refused("export spheres_small -o x.hdf5", 2, "--at");
  expect_refused("export spheres_small --at 0 -o x.hdf5", 2, "--at");
  expect_refused("export spheres_small --at 3", 2, "--output");
  expect_refused("export spheres_small --at 3 -o /nowhere/x.hdf5", 2, "/nowhere/x.hdf5");
  std::ofstream(file("mine.txt")) << "what was there";
  expect_refused("export spheres_small --at 3 -o " + file("mine.txt").string(), 2, "does not overwrite it");
  expect_refused("export rover --at 3 --quiet --device reference -o " + file("x.hdf5").string(), 2, "motor");
  expect_refused("export free_flight --at 3 --quiet --device reference -o " + file("x.hdf5").string(), 2,
                 "neither contacts nor joints");
}

}  // namespace
}  // namespace lockstep::solve_command_test
