// Every pair of kinds against the oracle, float and double: poses at random, faces and sides that lie on each other,
// poses full of ties. LOCKSTEP_PAIRS=100000 tries as many random pairs of each kind, and half as many that lie on each
// other, and prints the worst of each; a usual run tries a few.
#include "cpu_reference/shapes/pairs.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>

#include "tests/shapes/cases.hpp"
#include "tests/shapes/judge.hpp"

namespace lockstep::test::pairs_test {
namespace {

u32 pair_count(u32 usual) {
  const char* wanted = std::getenv("LOCKSTEP_PAIRS");
  return wanted ? u32(std::atoi(wanted)) : usual;
}

template <class real>
oracle::Verdict judged(const Case<real>& c, bool patch) {
  const real limit = real(0.2);
  const auto m = reference::collide_shapes(c.kinds.a, c.a, c.kinds.b, c.b, hulls<real>().tables(), limit);
  oracle::Tolerances tolerances;
  tolerances.patch = patch;
  // two boxes that are apart are told by the best axis of faces and edges, a bound of their distance
  const bool boxes = c.kinds.a == SHAPE_BOX && c.kinds.b == SHAPE_BOX;
  tolerances.gap_is_distance = !boxes;
  // edges have to be better than faces by 3 %, and the faces of b than those of a by 1 % of the smallest half extent:
  // so much the normal may lose, and the deepest point
  if (boxes) {
    const auto least = [](const auto& size) { return std::min({double(size.x), double(size.y), double(size.z)}); };
    const double size = std::max(body(c.kinds.a, c.a).extent(), body(c.kinds.b, c.b).extent());
    const double preferred = 0.04 * std::min(least(c.a.size), least(c.b.size)) / size;
    tolerances.normal += preferred;
    tolerances.depth += preferred;
  }
  return oracle::judge(body(c.kinds.a, c.a), body(c.kinds.b, c.b), m, double(limit), tolerances);
}

/// The worst of many verdicts.
struct Survey {
  u32 pairs = 0, wrong = 0, wide = 0, below = 0, lengthy = 0;
  double depth_error = 0, normal_loss = 0, outside = 0, share = 1, whole_share = 1, length_share = 1;

  template <class real>
  void add(const Case<real>& c, bool patch) {
    const oracle::Verdict v = judged(c, patch);
    depth_error = std::max(depth_error, v.depth_error);
    normal_loss = std::max(normal_loss, v.normal_loss);
    outside = std::max(outside, v.outside);
    wide += v.wide, lengthy += v.lengthy, below += v.wide && v.share < 0.9;
    if (v.wide) share = std::min(share, v.share), whole_share = std::min(whole_share, v.whole_share);
    if (v.lengthy) length_share = std::min(length_share, v.share);
    wrong += !v.complaints.empty();
    for (const std::string& complaint : v.complaints)
      if (wrong <= 5) ADD_FAILURE() << "pair " << pairs << ": " << complaint << "\n" << describe(c);
    ++pairs;
  }
};

std::ostream& operator<<(std::ostream& out, const Survey& s) {
  return out << s.pairs << " pairs, " << s.wrong << " wrong, depth error " << s.depth_error << ", normal loss "
             << s.normal_loss << ", outside " << s.outside << ", wide " << s.wide << " (" << s.below
             << " below 0.9) share " << s.share << " whole " << s.whole_share << ", long " << s.lengthy << " share "
             << s.length_share;
}

struct Kinds {
  PairOfKinds kinds;
  bool in_double;
};

class Pairs : public testing::TestWithParam<Kinds> {
 protected:
  template <class Make>
  void survey(const char* name, u32 count, u32 patch_every, const Make& make) {
    const auto [kinds, in_double] = GetParam();
    Survey survey;
    for (u32 n = 0; n < count && survey.wrong < 1000; ++n) {
      const bool patch = patch_every > 0 && n % patch_every == 0;
      if (in_double)
        survey.add(make.template operator()<double>(kinds, n), patch);
      else
        survey.add(make.template operator()<float>(kinds, n), patch);
    }
    EXPECT_EQ(survey.wrong, 0u) << "of " << survey.pairs;
    if (pair_count(0) > 0)
      std::cout << kind_names[kinds.a] << " and " << kind_names[kinds.b] << " in " << (in_double ? "double" : "float")
                << ' ' << name << ": " << survey << std::endl;
  }
  u32 seed() const { return 100 * GetParam().kinds.a + GetParam().kinds.b; }
};

TEST_P(Pairs, MeetAnyhow) {
  Random random(seed());
  survey("anyhow", pair_count(200), 0,
         [&]<class real>(PairOfKinds kinds, u32) { return meeting_anyhow<real>(kinds, random); });
}

TEST_P(Pairs, LieOnEachOther) {
  Random random(2 * seed());
  survey("lying", pair_count(200) / 2, pair_count(0) > 0 ? 1 : 5,
         [&]<class real>(PairOfKinds kinds, u32) { return lying<real>(kinds, random); });
}

TEST_P(Pairs, MeetOnALattice) {
  const u32 stride = pair_count(0) > 0 ? 1 : 7;
  survey("lattice", lattice_cases / stride, 0,
         [&]<class real>(PairOfKinds kinds, u32 n) { return on_lattice<real>(kinds, n * stride); });
}

std::vector<Kinds> all_kinds() {
  std::vector<Kinds> all;
  for (const PairOfKinds& kinds : all_pairs_of_kinds())
    for (const bool in_double : {false, true}) all.push_back({kinds, in_double});
  return all;
}

INSTANTIATE_TEST_SUITE_P(, Pairs, testing::ValuesIn(all_kinds()), [](const auto& each) {
  return std::string(kind_names[each.param.kinds.a]) + "_" + kind_names[each.param.kinds.b] +
         (each.param.in_double ? "_double" : "_float");
});

// A box that rests on another one, turned by any angle: the corners of up to eight that the patch has.
template <class real>
void expect_four_points_of_a_patch_of_two_boxes() {
  for (int n = 0; n < 90; ++n) {
    const Eigen::Quaterniond still(1, 0, 0, 0),
        rotated(Eigen::AngleAxisd(n * oracle::two_pi / 360, Eigen::Vector3d::UnitZ()));
    // about one centre, equal ones share an octagon
    for (const auto& [x, y, width] : {std::tuple{0.3, 0.1, 0.25}, {0.01, 0.02, 0.45}, {0.0, 0.0, 0.5}}) {
      const Case<real> c = {
          {SHAPE_BOX, SHAPE_BOX},
          {{0, 0, 0}, rounded<real>(still), {real(0.5), real(0.5), real(0.5)}, 0},
          {{real(x), real(y), real(0.99998)}, rounded<real>(rotated), {real(0.5), real(width), real(0.5)}, 0}};
      const oracle::Verdict verdict = judged(c, true);
      EXPECT_TRUE(verdict.wide) << n;
      EXPECT_EQ(verdict.complaints, std::vector<std::string>()) << n << " degrees " << describe(c);
    }
  }
}

TEST(PairsOfBoxes, HaveFourPointsOfTheirPatch) {
  expect_four_points_of_a_patch_of_two_boxes<float>();
  expect_four_points_of_a_patch_of_two_boxes<double>();
}

// Deep inside, the best normal is one across both rims, less than a degree from that of a cap.
template <class real>
void expect_the_best_normal_beside_a_cap() {
  const Case<real> c = {{SHAPE_CYLINDER, SHAPE_CYLINDER},
                        {{0, 0, 0},
                         {real(0.227049619), real(-0.257963687), real(0.53674686), real(-0.7705881)},
                         {real(0.78276372), real(0.113397695), 0},
                         0},
                        {{real(-0.938792408), real(-0.295070231), real(1.38674092)},
                         {real(-0.606011391), real(0.667197645), real(-0.276208043), real(0.333626419)},
                         {real(0.631465256), real(0.915502012), 0},
                         0}};
  EXPECT_EQ(judged(c, false).complaints, std::vector<std::string>()) << describe(c);
}

TEST(PairsOfCylinders, FindTheBestNormalBesideACap) {
  expect_the_best_normal_beside_a_cap<float>();
  expect_the_best_normal_beside_a_cap<double>();
}

// The side of the cylinder is farthest behind a face, but over no point of it: it meets an edge, and as deep as along
// the line to it.
template <class real>
void expect_the_depth_beside_a_face() {
  const Case<real> c = {{SHAPE_CYLINDER, SHAPE_HULL},
                        {{0, 0, 0},
                         {real(0.301254213), real(0.552270412), real(0.70183295), real(0.334176242)},
                         {real(0.101058938), real(0.24192591), 0},
                         0},
                        {{real(-0.455416709), real(0.286289245), real(0.166695103)},
                         {real(0.346263379), real(0.59770292), real(0.717929661), real(0.0861964375)},
                         {real(0.5), real(0.433012694), real(0.400000006)},
                         2}};
  EXPECT_EQ(judged(c, false).complaints, std::vector<std::string>()) << describe(c);
}

TEST(PairsOfCylinders, AreAsDeepAsTheEdgeBesideAFace) {
  expect_the_depth_beside_a_face<float>();
  expect_the_depth_beside_a_face<double>();
}

// Cubes that lie on each other, turned, shifted and a little tilted, meet on a face: two edges tell them apart almost
// as well, but hold them at one point.
template <class real>
void expect_cubes_to_lie_on_a_face() {
  Random random(9);
  for (u32 i = 0; i < 200; ++i) {
    const double yaw = random.between(-0.8, 0.8), tilt = 2e-4, toward = random.between(0, 6.2831853);
    const Eigen::Quaterniond rotation =
        Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(toward), std::sin(toward), 0)) *
        Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
    const reference::Vec3<real> half = {real(0.5), real(0.5), real(0.5)};
    const reference::WorldShape<real> lower = {{0, 0, 0}, {0, 0, 0, 1}, half, 0};
    const reference::WorldShape<real> upper = {
        {real(random.between(-0.3, 0.3)), real(random.between(-0.3, 0.3)), real(0.9999)},
        {real(rotation.x()), real(rotation.y()), real(rotation.z()), real(rotation.w())},
        half,
        0};
    const auto m = reference::box_box(upper, lower, real(0.01));
    EXPECT_NE(m.frame, u32{NORMAL_FIXED}) << i;
    EXPECT_EQ(m.count, 4u) << i;
  }
}

TEST(PairsOfBoxes, LieOnAFaceWhereEdgesAreHardlyBetter) {
  expect_cubes_to_lie_on_a_face<float>();
  expect_cubes_to_lie_on_a_face<double>();
}

}  // namespace
}  // namespace lockstep::test::pairs_test
