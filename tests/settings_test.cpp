// The table of settings: each row is read, refused and described alike by scenes, options, the library and the manual.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/scene/read.hpp"
#include "host/scene/setting_table.hpp"
#include "tests/refusal.hpp"

namespace lockstep::settings_test {
namespace {

Scene scene_with(const std::string& settings) {
  return parse_scene(R"({"settings": )" + settings + R"(, "bodies": [{"type": "static"}]})", "s.json");
}

// Values, as options write them, that a setting of these bounds refuses.
std::vector<std::string> bad_values(const Bounds& bounds) {
  switch (bounds.kind) {
    case Bounds::Kind::positive: return {"0", "-1", "nan", "much"};
    case Bounds::Kind::not_negative: return {"-1", "nan", "much"};
    case Bounds::Kind::fraction: return {"-0.5", "1.5", "much"};
    case Bounds::Kind::integers:
      return {std::to_string(bounds.least - 1), std::to_string(std::uint64_t(bounds.most) + 1), "1.5", "-1", "many"};
    case Bounds::Kind::name: return {"qqqqqqqq"};
    case Bounds::Kind::any: return {"perhaps"};
  }
  return {};
}

TEST(Settings, ValuesThatAreNotSetAreWithinTheirBounds) {
  EXPECT_EQ(refusal([] { expect_in_bounds(Settings()); }), "accepted");
  for (const auto& [name, solver] : solver_names) {
    Settings settings;
    settings.solver = solver;
    EXPECT_EQ(refusal([&] { expect_in_bounds(resolved(settings)); }), "accepted") << name;
  }
}

TEST(Settings, AScenesFileAndAnOptionRefuseTheSameValuesInTheSameWords) {
  for (const SettingInfo& row : setting_infos()) {
    for (const std::string& bad : bad_values(row.bounds)) {
      SCOPED_TRACE(std::string(row.name) + " " + bad);
      Settings ignored;
      const std::string of_option = refusal([&] { read_setting(bad, row, ignored); });
      EXPECT_NE(of_option, "accepted");
      const bool is_number = bad.find_first_not_of("0123456789.-") == std::string::npos;
      const std::string written = is_number ? bad : '"' + bad + '"';
      EXPECT_EQ(refusal([&] { scene_with("{\"" + std::string(row.name) + "\": " + written + "}"); }),
                "s.json: /settings/" + std::string(row.name) + ": " + of_option);
    }
  }
}

TEST(Settings, TheLibraryRefusesWhatAFileWouldNotHave) {
  const auto of = [](auto&& set) {
    Settings settings;
    set(settings);
    return refusal([&] { expect_in_bounds(settings); });
  };
  EXPECT_EQ(of([](Settings& s) { s.dt = 0; }), "settings.dt: must be > 0, is 0");
  EXPECT_EQ(of([](Settings& s) { s.slop = -1; }), "settings.slop: must be >= 0, is -1");
  EXPECT_EQ(of([](Settings& s) { s.correction = 2; }), "settings.correction: must be 0 .. 1, is 2");
  EXPECT_EQ(of([](Settings& s) { s.substeps = 0; }), "settings.substeps: must be 1 .. 10000, is 0");
  EXPECT_EQ(of([](Settings& s) { s.precision = "half"; }), "settings.precision: must be float or double, is half");
  EXPECT_EQ(of([](Settings& s) { s.sleeping = {.after = 0}; }), "settings.after: must be > 0, is 0");
}

TEST(Settings, WhatIsWrittenIsReadAgain) {
  Settings settings;
  settings.solver = Solver::jacobi;
  settings.iterations = 7;
  settings.broad_phase = BroadPhase::bvh;
  settings.sleeping = {.after = 2};
  const nlohmann::ordered_json written = to_json(settings);
  EXPECT_EQ(written["substeps"], 1);
  EXPECT_EQ(written["broad_phase"], "bvh");
  EXPECT_EQ(to_json(scene_with(written.dump()).settings), written);
  for (const SettingInfo& row : setting_infos()) {  // and so is an option
    if (std::string_view(row.name) == "sleeping" || !written.contains(row.name)) continue;
    const nlohmann::ordered_json& value = written[row.name];
    Settings one;
    read_setting(value.is_string() ? value.get<std::string>() : value.dump(), row, one);
    EXPECT_EQ(to_json(one)[row.name], value) << row.name;
  }
}

// What a solver brings is the same in a file and in code.
TEST(Settings, NamingASolverIsEnough) {
  for (const auto& [name, solver] : solver_names) {
    SCOPED_TRACE(name);
    Settings in_code;
    in_code.solver = solver;
    EXPECT_EQ(substeps_of(in_code), info(solver).substeps);
    EXPECT_EQ(iterations_of(in_code), info(solver).iterations);
    EXPECT_EQ(to_json(in_code), to_json(scene_with(R"({"solver": ")" + std::string(name) + "\"}").settings));
  }
  Settings small;
  small.solver = Solver::small_steps;
  EXPECT_EQ(substeps_of(small), 5u);
  EXPECT_EQ(iterations_of(small), 1u);
  small.iterations = 3;
  EXPECT_EQ(substeps_of(small), 5u);
  EXPECT_EQ(iterations_of(small), 3u);
  replace_solver(small, Solver::jacobi);
  EXPECT_EQ(substeps_of(small), 1u);
  EXPECT_EQ(iterations_of(small), 30u);
}

// More than any integer holds is told as it is.
TEST(Settings, AnOptionTooLargeForAnIntegerIsRefusedWithItsValue) {
  Settings settings;
  try {
    read_setting("18446744073709551617", setting_info("substeps"), settings);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("is 1.844"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace lockstep::settings_test
