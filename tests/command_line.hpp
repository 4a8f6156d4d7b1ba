// The program as a user meets it: a fixture that runs it in a folder of its own.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/temporary_folder.hpp"

namespace lockstep {

namespace fs = std::filesystem;

inline std::string read_file(const fs::path& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

struct Outcome {
  int status;
  std::string out, err;
};

// A folder of its own for each test, gone afterwards.
class CommandLine : public testing::Test {
 protected:
  fs::path file(const std::string& name) const { return folder_.file(name); }

  Outcome run(const std::string& arguments) const { return run_command(LOCKSTEP_PROGRAM " " + arguments); }

  /// `line`: for the shell, in brackets.
  Outcome run_command(const std::string& line) const {
    const fs::path out = file("stdout"), err = file("stderr");
    const std::string command = "(" + line + ") >" + out.string() + " 2>" + err.string();
    const int status = std::system(command.c_str());
    return {WEXITSTATUS(status), read_file(out), read_file(err)};
  }

  // Refused: this status, nothing on stdout, one line on stderr that contains `expected`.
  void expect_refused(const std::string& arguments, int status, const std::string& expected) const {
    SCOPED_TRACE(arguments);
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.err.rfind("lockstep: ", 0), 0u) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_NE(outcome.err.find(expected), std::string::npos) << outcome.err;
  }

  nlohmann::json report_of(const std::string& arguments) const {
    const Outcome outcome = run("run " + arguments + " --quiet --report " + file("report.json").string());
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.out + outcome.err, "") << "--quiet";
    return nlohmann::json::parse(read_file(file("report.json")));
  }

 private:
  const TemporaryFolder folder_;
};

}  // namespace lockstep
