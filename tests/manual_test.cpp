// What the manual, the schema of scenes and the public header of settings say of settings, solvers, shapes and joints
// is text that follows from their tables. LOCKSTEP_WRITE_MANUAL=1 lockstep_tests --gtest_filter='Manual.*' writes it.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host/scene/manual_text.hpp"

namespace lockstep::manual_test {
namespace {

std::string slurp(const std::string& path) {
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

// The lines between `from`, the end of a line, and `to`, the beginning of one.
void expect_between(const std::string& file, const std::string& from, const std::string& to, const std::string& text) {
  const std::string path = LOCKSTEP_SOURCE_DIR "/" + file, all = slurp(path);
  const std::size_t before = all.find(from + "\n");
  ASSERT_NE(before, std::string::npos) << file << ": " << from;
  const std::size_t first = before + from.size() + 1, last = all.find(to, first);
  ASSERT_NE(last, std::string::npos) << file << ": " << to;
  const std::string found = all.substr(first, last - first);
  if (found == text) return;
  if (std::getenv("LOCKSTEP_WRITE_MANUAL") == nullptr) {
    EXPECT_EQ(found, text) << file << ": LOCKSTEP_WRITE_MANUAL=1 writes this";
    return;
  }
  std::ofstream(path) << all.substr(0, first) << text << all.substr(last);
}

void expect_in_manual(const std::string& page, const std::string& table, const std::string& what,
                      const std::string& text) {
  expect_between("docs/reference/" + page, "<!-- written from " + table + " by the test Manual.* -->",
                 "<!-- end of " + what + " -->", "\n" + text + "\n");
}

// ---- the public header of settings: the members of the tables, with what each means

struct Member {
  std::string type, name, initial, unit, meaning;
};
constexpr const char* of_solver = "BySolver<";

const std::vector<Member> sleep_members = {
#define SLEEP_SETTING(type, name, initial, bounds, unit, meaning) {#type, #name, #initial, unit, meaning},
#include "host/settings.def"
};
const std::vector<Member> members = {
#define SETTING(type, name, initial, bounds, unit, group, acts, meaning) {#type, #name, #initial, unit, meaning},
#define STEP_NUMBER(type, name, initial, bounds, unit, group, meaning) {#type, #name, #initial, unit, meaning},
#define STEP_COUNT(type, name, initial, bounds, unit, group, meaning) {#type, #name, #initial, unit, meaning},
#include "host/settings.def"
};
const std::vector<std::pair<std::string, std::string>> solver_members = {
#define SOLVER(name, substeps, iterations, tolerance, precision, what, use) {#name, what},
#include "host/solvers.def"
#define ORACLE(name, text, what) {#name, what},
#include "host/oracles.def"
};

// As lines of comment of at most 120 characters.
std::string comment_of(const std::string& text) {
  std::string comment, line = "  ///";
  std::istringstream words(text);
  for (std::string word; words >> word; line += " " + word) {
    if (line.size() + 1 + word.size() <= 120) continue;
    comment += line + "\n";
    line = "  ///";
  }
  return comment + line + "\n";
}

std::string members_text(const std::vector<Member>& rows) {
  std::string text;
  for (const Member& row : rows) {
    const bool by_solver = row.type.rfind(of_solver, 0) == 0;
    text += comment_of(row.meaning + (row.unit.empty() ? "" : ", " + row.unit) +
                       (by_solver ? "; unset: what the solver brings" : "")) +
            "  " + row.type + " " + row.name + " = " + row.initial + ";\n";
  }
  return text;
}

TEST(Manual, ThePublicHeaderHasTheSettings) {
  const std::string header = "include/lockstep/settings.hpp";
  expect_between(header, "  // written from host/settings.def by the test Manual.*: sleeping", "  // end of sleeping",
                 members_text(sleep_members));
  expect_between(header, "  // written from host/settings.def by the test Manual.*: settings", "  // end of settings",
                 members_text(members));
  std::string solvers;
  for (const auto& [name, what] : solver_members) solvers += comment_of(what) + "  " + name + ",\n";
  expect_between(header, "  // written from host/solvers.def and host/oracles.def by the test Manual.*",
                 "  // end of solvers", solvers);
}

TEST(Manual, HasTheTablesOfSettingsAndSolvers) {
  expect_in_manual("settings.md", "host/settings.def", "settings", settings_manual());
  expect_in_manual("settings.md", "host/solvers.def", "solvers", solvers_manual());
  expect_in_manual("settings.md", "host/oracles.def", "oracles", oracles_manual());
}

TEST(Manual, HasTheKindsOfShapesAndJoints) {
  expect_in_manual("bodies.md", "kernels/shape_kinds.def", "shapes", shapes_manual());
  expect_in_manual("joints.md", "kernels/joint_kinds.def", "joints", joints_manual());
}

TEST(Manual, TheSchemaHasTheSettings) {
  expect_between("scenes/scene.schema.json",
                 "    \"settings\": {\n      \"type\": \"object\",\n      \"additionalProperties\": false,\n"
                 "      \"properties\": {",
                 "      }\n    },\n    \"particles\"", settings_schema());
}

TEST(Manual, TheSchemaHasTheKindsOfShapesAndJoints) {
  expect_between("scenes/scene.schema.json",
                 "    \"shape\": {\n      \"type\": \"object\",\n      \"required\": [\"type\"],\n"
                 "      \"additionalProperties\": false,\n      \"properties\": {",
                 "        \"radius\"", shape_types_schema());
  expect_between("scenes/scene.schema.json",
                 "      \"required\": [\"type\", \"bodies\"],\n      \"additionalProperties\": false,\n"
                 "      \"properties\": {",
                 "        \"name\"", joint_types_schema());
}

}  // namespace
}  // namespace lockstep::manual_test
