// `lockstep bench` as a user meets it: what it prints, writes and refuses.
#include <cmath>

#include "host/cases/hard_case.hpp"
#include "tests/command_line.hpp"

namespace lockstep::bench_cli_test {
namespace {

using nlohmann::json;

class BenchCommand : public CommandLine {
 protected:
  std::string out() const { return " --out " + file("bench").string(); }
  std::string written(const std::string& name) const { return read_file(file("bench") / name); }
};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// Explicit Euler is of first order: half the step, half the error; x(t) is off by g t dt / 2.
TEST_F(BenchCommand, MeasuresErrorsAgainstTheExactAnswer) {
  const Outcome outcome =
      run("bench free_flight --method 'explicit Euler' 'Runge-Kutta 4' --settings 2 --device reference" + out());
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json cases = json::parse(written("bench.json"));
  ASSERT_EQ(cases.size(), 1u);
  const json& trials = cases[0]["trials"];
  ASSERT_EQ(trials.size(), 8u) << "two methods, two precisions, two settings";
  for (const json& trial : trials) {
    SCOPED_TRACE(trial.dump());
    EXPECT_EQ(trial["device"], "reference");
    EXPECT_EQ(trial["steps"], std::lround(1 / double(trial["dt"])) - 1) << "but the first, which warms up";
    EXPECT_GT(trial["ms_per_step_median"], 0);
    EXPECT_NEAR(trial["ms_per_second"], double(trial["ms_per_step_median"]) / double(trial["dt"]), 1e-9);
    EXPECT_TRUE(trial["residual_median"].is_null()) << "nothing is solved";
    EXPECT_TRUE(trial["sweeps"].is_null());
    const json& position = trial["errors"][0];
    EXPECT_EQ(position["unit"], "m");
    if (trial["method"] == "explicit Euler")
      EXPECT_NEAR(position["error"], 9.81 * double(trial["dt"]) / 2, 1e-4);
    else
      EXPECT_LT(position["error"], trial["precision"] == "double" ? 1e-13 : 1e-5);
  }
}

TEST_F(BenchCommand, WritesTheSameFiguresInEveryFile) {
  const Outcome outcome =
      run("bench incline --method gauss_seidel \"oracle auto\" --settings 1 --device reference" + out());
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json trials = json::parse(written("bench.json"))[0]["trials"];
  ASSERT_EQ(trials.size(), 3u) << "an oracle works in double";
  const std::vector<std::string> rows = lines_of(written("bench.csv"));
  ASSERT_EQ(rows.size(), 1 + 2 * trials.size()) << "a row for each quantity";
  const std::string page = written("index.html");
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const double error = trials[i]["errors"][0]["error"];
    std::ostringstream in_table, in_page;
    in_table.precision(4), in_page.precision(3);
    in_table << error, in_page << error;
    EXPECT_NE(rows[1 + 2 * i].find("," + in_table.str() + ","), std::string::npos) << rows[1 + 2 * i];
    EXPECT_NE(page.find("<td>" + in_page.str() + "</td>"), std::string::npos) << in_page.str();
    EXPECT_NE(outcome.out.find(" " + in_page.str() + " "), std::string::npos) << in_page.str();
  }
  EXPECT_EQ(trials[0]["sweeps"], 5);
  EXPECT_TRUE(trials[2]["sweeps"].is_null()) << "of an oracle";
  EXPECT_LT(trials[2]["residual_median"], 1e-10);
  EXPECT_TRUE(page.ends_with("</html>\n"));
}

// The oracle cannot keep joints that are more than needed to the last digit: a row, and no reason to stop.
TEST_F(BenchCommand, TellsOfATrialThatFails) {
  const Outcome outcome = run("bench bricard incline --method 'oracle auto' --settings 1" + out());
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json cases = json::parse(written("bench.json"));
  ASSERT_EQ(cases.size(), 2u);
  const std::string failure = cases[0]["trials"][0]["failure"];
  EXPECT_NE(failure.find("stalled"), std::string::npos) << failure;
  EXPECT_TRUE(cases[0]["trials"][0]["errors"].empty());
  EXPECT_TRUE(cases[1]["trials"][0]["failure"].is_null());
  const std::vector<std::string> rows = lines_of(written("bench.csv"));
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_NE(rows[1].find("stalled"), std::string::npos) << rows[1];
  const auto commas = [](const std::string& row) {  // that part fields
    bool quoted = false;
    return std::count_if(row.begin(), row.end(), [&](char c) { return quoted ^= c == '"', c == ',' && !quoted; });
  };
  for (const std::string& row : rows) EXPECT_EQ(commas(row), commas(rows[0])) << row;
  EXPECT_NE(outcome.out.find("stalled"), std::string::npos);
  EXPECT_NE(written("index.html").find("stalled"), std::string::npos);
}

TEST_F(BenchCommand, PlotsWhereGnuplotIsInstalled) {
  const std::string bench = "bench free_flight --settings 2 --device reference" + out();
  ASSERT_EQ(run_command("command -v gnuplot").status, 0) << "scripts/install-packages installs it";
  ASSERT_EQ(run(bench).status, 0);
  EXPECT_NE(written("free_flight.svg").find("Runge-Kutta 4, double"), std::string::npos);
  EXPECT_NE(written("index.html").find("<svg"), std::string::npos);

  const Outcome without = run_command("PATH=" + file("nowhere").string() + " " LOCKSTEP_PROGRAM " " + bench);
  EXPECT_EQ(without.status, 0) << without.err;
  EXPECT_NE(without.out.find("install gnuplot"), std::string::npos);
  EXPECT_EQ(written("index.html").find("<svg"), std::string::npos);
}

TEST_F(BenchCommand, ListsAndRefuses) {
  const Outcome list = run("bench --list");
  EXPECT_EQ(list.status, 0);
  EXPECT_EQ(lines_of(list.out).size(), hard_cases().size());
  expect_refused("bench nothing_of_this_name" + out(), 2, "there is no such case");
  expect_refused("bench free_flight --precision half" + out(), 2, "half");
  expect_refused("bench free_flight --method Verlet" + out(), 2, "Verlet");
  expect_refused("bench free_flight --device 99" + out(), 2, "99");
  EXPECT_FALSE(fs::exists(file("bench"))) << "refused before anything is written";
  expect_refused("bench free_flight --device reference --out /dev/null/x", 2, "/dev/null/x");
}

}  // namespace
}  // namespace lockstep::bench_cli_test
