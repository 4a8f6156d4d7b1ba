// A semicircular arch of stones without mortar. It stands where a line of thrust fits into its thickness (Couplet 1730,
// Milankovitch 1907, Heyman 1969: at least 0.1075 of the radius of its centre line if it has joints everywhere).
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "host/cases/rest.hpp"
#include "host/scene/read.hpp"

namespace lockstep::arch_test {
namespace {

// Of the scene: 27 stones; radius of the centre line 1 m.
constexpr u32 stones = 27;
constexpr double half_stone = std::numbers::pi / stones / 2;  // rad
constexpr double depth = 0.2;                                 // m, of the arch along y

/// Whether thrust can pass through all joints of an arch of this thickness. Right of the crown, weights in parts of
/// density, depth and g: the horizontal thrust H acts at a height z at the crown, the weight W of the stones above a
/// joint at x. In a joint at the angle a from the crown their resultant passes at the radius
/// r = (H z + W x) / (W sin a + H cos a), which has to be within the stone. That is linear in H and H z.
bool thrust_fits(double thickness) {
  const double inner = 1 - thickness / 2, outer = 1 + thickness / 2;
  const auto room_for = [&](double thrust) {  // for H z, over all joints
    double least = -std::numeric_limits<double>::infinity(), most = -least;
    for (u32 joint = 0; 2 * joint < stones; ++joint) {
      const double a = (2 * joint + 1) * half_stone;
      const double weight = (outer * outer - inner * inner) / 2 * a;
      const double moment = (outer * outer * outer - inner * inner * inner) / 3 * (1 - std::cos(a));
      const double per_radius = weight * std::sin(a) + thrust * std::cos(a);
      least = std::max(least, inner * per_radius - moment);
      most = std::min(most, outer * per_radius - moment);
    }
    return most - least;
  };
  double low = 0, high = 1;  // the room is a concave function of the thrust
  for (int i = 0; i < 100; ++i) {
    const double third = (high - low) / 3;
    const bool increases = room_for(low + third) < room_for(high - third);
    (increases ? low : high) = increases ? low + third : high - third;
  }
  return room_for((low + high) / 2) >= 0;
}

double least_thickness() {
  double falls = 0.05, rests = 0.2;
  for (int i = 0; i < 40; ++i) {
    const double middle = (falls + rests) / 2;
    (thrust_fits(middle) ? rests : falls) = middle;
  }
  return rests;
}

/// The corners of the stone at the crown.
std::vector<Vector3> stone_of(double thickness) {
  std::vector<Vector3> corners;
  for (const double r : {1 - thickness / 2, 1 + thickness / 2}) {
    for (const double side : {-1, 1}) {
      for (const double y : {-depth / 2, depth / 2})
        corners.push_back({side * r * std::sin(half_stone), y, r * std::cos(half_stone)});
    }
  }
  return corners;
}

nlohmann::json scene_text(const std::string& name) {
  return nlohmann::json::parse(std::ifstream(LOCKSTEP_SOURCE_DIR "/scenes/" + name + ".json"));
}

nlohmann::json& points_of(nlohmann::json& arch) { return arch["bodies"][1]["bodies"][0]["shapes"][0]["points"]; }

void expect_stones_of(const std::string& name, double thickness) {
  nlohmann::json arch = scene_text(name);
  const auto points = points_of(arch).get<std::vector<Vector3>>();
  const std::vector<Vector3> corners = stone_of(thickness);
  ASSERT_EQ(points.size(), corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (unsigned k = 0; k < 3; ++k) EXPECT_NEAR(points[i][k], corners[i][k], 1e-14);
  }
}

/// An arch of this thickness in sub-steps so short that its limit comes close, for five seconds.
RestMeasures measure_rest_finely(double thickness) {
  nlohmann::json arch = scene_text("arch");
  points_of(arch) = stone_of(thickness);
  Scene scene = parse_scene(arch.dump(), "arch.json");
  scene.settings.substeps = 128;
  scene.settings.slop = 1e-5;
  scene.settings.steps = 300;
  return measure_rest(scene);
}

TEST(Arch, LimitIsThatOfTheLiterature) {
  EXPECT_NEAR(least_thickness(), 0.106721, 1e-4);
  EXPECT_LT(least_thickness(), 0.1075);  // fewer joints, fewer hinges
}

TEST(Arch, ScenesHaveTheThicknessTheyTell) {
  expect_stones_of("arch", 0.12);
  expect_stones_of("arch_thin", 0.095);
}

TEST(Arch, ThinOneFalls) { EXPECT_GT(measure_rest(read_scene("arch_thin")).moved, 0.5); }

TEST(Arch, StaysAtRestAboveTheLimitAndFallsBelow) {
  EXPECT_LT(measure_rest_finely(1.03 * least_thickness()).moved, 0.005);
  EXPECT_GT(measure_rest_finely(0.97 * least_thickness()).moved, 0.1);
}

}  // namespace
}  // namespace lockstep::arch_test
