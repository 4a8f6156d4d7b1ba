// Newton's cradle: balls that touch are hit at the same time, by the law of docs/theory/impacts.md; with gaps, one
// after another.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "host/scene/read.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::test::cradle_test {
namespace {

struct Method {
  const char* solver;
  const char* settings;  // of the scene, as JSON
};
void PrintTo(const Method& m, std::ostream* out) { *out << m.solver << m.settings; }

class Cradle : public testing::TestWithParam<Method> {
 protected:
  /// The velocities of five equal balls, `gap` apart and listed in `order`, after the first has hit the others at 1
  /// m/s, without friction and with e = 1.
  std::vector<double> after_a_blow(const std::array<int, 5>& order, double gap) const {
    std::string bodies;
    for (const int i : order)
      bodies += fmt::format(R"({}{{"name": "{}", "mass": 1, "position": [{}, 0, 0], "velocity": [{}, 0, 0],
                                 "shapes": [{{"type": "sphere", "radius": 0.05}}]}})",
                            bodies.empty() ? "" : ", ", i, i == 0 ? -0.0035 : i * (0.1 + gap), i == 0 ? 1 : 0);
    World w(parse_scene(fmt::format(R"({{"gravity": [0, 0, 0], "settings": {{"dt": 0.001, "solver": "{}"{}}},
                                       "materials": [{{"name": "m", "friction": 0, "restitution": 1}}],
                                       "bodies": [{}]}})",
                                    GetParam().solver, GetParam().settings, bodies),
                        "cradle_test"),
            {.device = "reference", .precision = "double"});
    w.step(40);
    std::vector<double> speeds;
    for (int i = 0; i < 5; ++i) speeds.push_back(w.velocity(*w.find(std::to_string(i))).linear[0]);
    return speeds;
  }
};
INSTANTIATE_TEST_SUITE_P(Methods, Cradle,
                         testing::Values(Method{"gauss_seidel", R"(, "iterations": 20)"},
                                         Method{"dense_gauss_seidel", R"(, "iterations": 20)"},
                                         Method{"small_steps", R"(, "iterations": 10, "relaxations": 10)"},
                                         Method{"auto", ""}));

// u+ >= -e u of all contacts, and no impulse where it is more: what Moreau's law makes of Newton's.
TEST_P(Cradle, OfBallsThatTouchIsHitAtOnce) {
  for (const auto& order : {std::array{0, 1, 2, 3, 4}, std::array{4, 3, 2, 1, 0}, std::array{2, 0, 4, 1, 3}}) {
    const std::vector<double> speeds = after_a_blow(order, 0);
    double energy = 0;
    for (int i = 0; i < 5; ++i) {
      EXPECT_NEAR(speeds[std::size_t(i)], i == 0 ? -0.6 : 0.4, 0.01) << i;
      energy += speeds[std::size_t(i)] * speeds[std::size_t(i)];
    }
    EXPECT_NEAR(energy, 1, 0.02);
  }
}

// A gap of half of what the first ball goes in a step, or more.
TEST_P(Cradle, WithGapsIsHitOneBallAfterAnother) {
  for (const double gap : {0.0005, 0.0012}) {
    const std::vector<double> speeds = after_a_blow({2, 0, 4, 1, 3}, gap);
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(speeds[std::size_t(i)], i == 4 ? 1 : 0, 1e-9) << gap << " " << i;
  }
}

}  // namespace
}  // namespace lockstep::test::cradle_test
