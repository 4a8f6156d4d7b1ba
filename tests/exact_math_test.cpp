// The arithmetic between scene and state: against values of 300 bits, and against the properties that scenes rely on.
#include "host/scene/exact_math.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

namespace lockstep::exact_math_test {
namespace {

// Distance in units in the last place of `expected`.
double ulps(double actual, double expected) {
  const double ulp = std::nextafter(std::abs(expected), INFINITY) - std::abs(expected);
  return std::abs(actual - expected) / ulp;
}

double error_of_rotation(const Quaternion& q, const Vector3& from, const Vector3& to) {
  return exact::length(exact::subtract(exact::rotate(q, from), to));
}

struct KnownAngle {
  double angle, sine, cosine;  // the nearest doubles to the true values, from 300-bit arithmetic
};

// The last six are the doubles nearest to a multiple of pi/2 in relative terms: they punish a careless reduction.
const KnownAngle known_angles[] = {
    {0x1.999999999999ap-4, 0x1.98eaecb8bcb2cp-4, 0x1.fd712f9a817c1p-1},
    {0x1p-1, 0x1.eaee8744b05fp-2, 0x1.c1528065b7d5p-1},
    {0x1.921fb54442d15p-1, 0x1.6a09e667f3bcap-1, 0x1.6a09e667f3bcfp-1},
    {0x1p+0, 0x1.aed548f090ceep-1, 0x1.14a280fb5068cp-1},
    {0x1p+1, 0x1.d18f6ead1b446p-1, -0x1.aa22657537205p-2},
    {0x1.8p+1, 0x1.210386db6d55bp-3, -0x1.fae04be85e5d2p-1},
    {0x1.4p+3, -0x1.1689ef5f34f52p-1, -0x1.ad9ac890c6b1fp-1},
    {0x1.9p+6, -0x1.03425b78c4db8p-1, 0x1.b981dbf665fdfp-1},
    {0x1.34ap+10, 0x1.29c531dfd031bp-3, -0x1.fa8f2ceb78372p-1},
    {0x1.387ep+13, -0x1.efff5c19e51fdp-5, -0x1.ff0f88268ad9fp-1},
    {-0x1.e612p+12, 0x1.fcc51c4806d0bp-1, 0x1.cb5d61f9fac68p-4},
    {0x1.5798ee2308c3ap-27, 0x1.5798ee2308c3ap-27, 0x1p+0},
    {0x1.6c6cbc45dc8dep+5, 0x1p+0, -0x1.6d61b58c99c43p-61},
    {0x1.6c6cbc45dc8dep+6, -0x1.6d61b58c99c43p-60, -0x1p+0},
    {0x1.6c6cbc45dc8dep+7, 0x1.6d61b58c99c43p-59, 0x1p+0},
    {0x1.6c6cbc45dc8dep+8, 0x1.6d61b58c99c43p-58, 0x1p+0},
    {0x1.6c6cbc45dc8dep+9, 0x1.6d61b58c99c43p-57, 0x1p+0},
    {0x1.6c6cbc45dc8dep+10, 0x1.6d61b58c99c43p-56, 0x1p+0},
};

TEST(ExactMath, SineAndCosineAreWithinOneUlpOfTheTruth) {
  for (const KnownAngle& known : known_angles) {
    EXPECT_LE(ulps(exact::sine(known.angle), known.sine), 1) << std::hexfloat << known.angle;
    EXPECT_LE(ulps(exact::cosine(known.angle), known.cosine), 1) << std::hexfloat << known.angle;
    EXPECT_EQ(exact::sine(-known.angle), -exact::sine(known.angle));
    EXPECT_EQ(exact::cosine(-known.angle), exact::cosine(known.angle));
  }
}

TEST(ExactMath, SineAndCosineAgreeWithTheCLibraryOverTheWholeRange) {
  // long double has more digits on most machines, and the same on the others, where libm itself is within 1 ulp
  for (std::uint32_t i = 0; i < 200000; ++i) {
    exact::LcgByIndex random(i);
    const double angle = (i % 2 == 0 ? 1.6 : exact::largest_angle) * random.next_symmetric();
    EXPECT_LE(ulps(exact::sine(angle), static_cast<double>(std::sin(static_cast<long double>(angle)))), 2) << angle;
    EXPECT_LE(ulps(exact::cosine(angle), static_cast<double>(std::cos(static_cast<long double>(angle)))), 2) << angle;
  }
}

TEST(ExactMath, DegreesAreExactAtRightAngles) {
  for (int n = -8; n <= 8; ++n) {
    const int quadrant = ((n % 4) + 4) % 4;
    const double sines[] = {0, 1, 0, -1}, cosines[] = {1, 0, -1, 0};
    EXPECT_EQ(exact::sine_of_degrees(90.0 * n), sines[quadrant]) << n;
    EXPECT_EQ(exact::cosine_of_degrees(90.0 * n), cosines[quadrant]) << n;
  }
  EXPECT_LE(ulps(exact::sine_of_degrees(30), 0.5), 1);
  EXPECT_LE(ulps(exact::cosine_of_degrees(60), 0.5), 1);
  EXPECT_LE(ulps(exact::sine_of_degrees(999990), -1), 0);  // 2777 turns and 270 degrees
}

TEST(ExactMath, SquareRootIsCorrectlyRounded) {
  // In units of 2^-52, with r the root of x: (r - 1/2)^2 < 2^52 x < (r + 1/2)^2, in integers of 128 bits.
  __extension__ typedef unsigned __int128 Wide;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    exact::LcgByIndex random(i);
    const double x = 1 + 3 * (random.next() + 0x1p-24 * random.next());
    const Wide root = static_cast<std::uint64_t>(0x1p52 * exact::square_root(x));
    const Wide square = static_cast<Wide>(static_cast<std::uint64_t>(0x1p52 * x)) << 52;
    EXPECT_TRUE(root * root - root < square && square <= root * root + root) << std::hexfloat << x;
  }
}

TEST(ExactMath, RotationsAboutAnAxisTakeXToY) {
  const double s = exact::sine_of_degrees(45), c = exact::cosine_of_degrees(45);
  EXPECT_LT(error_of_rotation(exact::rotation({0, 0, 3}, s, c), {1, 0, 0}, {0, 1, 0}), 1e-15);
  EXPECT_LT(error_of_rotation(exact::rotation({1e-200, 0, 0}, s, c), {0, 1, 0}, {0, 0, 1}), 1e-15);
  EXPECT_LT(error_of_rotation(exact::rotation({0, 1e200, 0}, s, c), {0, 0, 1}, {1, 0, 0}), 1e-15);
}

TEST(ExactMath, EulerAnglesRotateAboutFixedAxesInTheOrderXYZ) {
  // x first: y goes to z; then about z: x goes to y
  const Quaternion q = exact::rotation_from_euler_degrees({90, 0, 90});
  EXPECT_LT(error_of_rotation(q, {1, 0, 0}, {0, 1, 0}), 1e-15);
  EXPECT_LT(error_of_rotation(q, {0, 1, 0}, {0, 0, 1}), 1e-15);
  const Quaternion pitch = exact::rotation_from_euler_degrees({0, 30, 0});
  EXPECT_LT(error_of_rotation(pitch, {1, 0, 0}, {std::cos(exact::pi / 6), 0, -0.5}), 1e-15);
}

TEST(ExactMath, ZIsRotatedToAnyDirection) {
  const Vector3 z = {0, 0, 1};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      Vector3 n = {0, 0, 0};
      n[static_cast<unsigned>(axis)] = sign;
      const Quaternion q = exact::rotation_from_z_to(exact::scale(7, n));
      EXPECT_EQ(exact::rotate(q, z), n) << axis << ' ' << sign;  // to the bit
      EXPECT_EQ(exact::length(q), 1);
    }
  }
  for (std::uint32_t i = 0; i < 1000; ++i) {
    exact::LcgByIndex random(i);
    Vector3 n = {random.next_symmetric(), random.next_symmetric(), random.next_symmetric()};
    if (i % 10 == 0) n = {1e-9 * n[0], 1e-9 * n[1], -1};  // all but opposite: digits must survive
    EXPECT_LT(error_of_rotation(exact::rotation_from_z_to(n), z, exact::unit(n)), 1e-15) << i;
  }
}

TEST(ExactMath, FramesAreRotatedToTwoDirections) {
  const Vector3 x = {1, 0, 0}, z = {0, 0, 1};
  EXPECT_EQ(exact::rotation_to_frame(z, x), (Quaternion{0, 0, 0, 1}));
  EXPECT_EQ(exact::rotation_to_frame(z, {-3, 0, 0}), (Quaternion{0, 0, 1, 0}));
  for (std::uint32_t i = 0; i < 1000; ++i) {
    exact::LcgByIndex random(i);
    const Vector3 n = {random.next_symmetric(), random.next_symmetric(), random.next_symmetric()};
    const Vector3 m = {random.next_symmetric(), random.next_symmetric(), random.next_symmetric()};
    const Vector3 along = exact::unit(n), across = exact::subtract(m, exact::scale(exact::dot(along, m), along));
    EXPECT_TRUE(exact::perpendicular(n, across));
    EXPECT_FALSE(exact::perpendicular(n, exact::add(across, exact::scale(1e-4 * exact::length(across), along))));
    const Quaternion q = exact::rotation_to_frame(n, m);
    EXPECT_LT(error_of_rotation(q, z, along), 3e-15) << i;
    EXPECT_LT(error_of_rotation(q, x, exact::unit(across)), 1e-13) << i;
  }
}

TEST(ExactMath, HamiltonProductRotatesByTheRightFactorFirst) {
  const Quaternion a = exact::unit(Quaternion{0.1, -0.4, 0.3, 0.8}), b = exact::unit(Quaternion{0.5, 0.2, -0.1, 0.6});
  const Vector3 v = {0.3, -2, 1.5};
  EXPECT_LT(error_of_rotation(exact::multiply(a, b), v, exact::rotate(a, exact::rotate(b, v))), 1e-15);
}

TEST(ExactMath, SolidSphere) {
  EXPECT_DOUBLE_EQ(exact::sphere_inertia(10, 0.5), 1.0);
  EXPECT_DOUBLE_EQ(exact::sphere_mass(1000, 0.1), 4.18879020478639098);
}

TEST(ExactMath, RandomNumbersAreThoseOfTheIndexedSequence) {
  exact::LcgByIndex random(0);
  // s = 12345; three steps of s = 1664525 s + 1013904223 (mod 2^32), the upper 24 bits of the third
  std::uint64_t s = 12345;
  for (int i = 0; i < 3; ++i) s = (1664525 * s + 1013904223) % 4294967296;
  EXPECT_EQ(random.next(), static_cast<double>(s / 256) / 16777216);
  EXPECT_NE(exact::LcgByIndex(1).next(), exact::LcgByIndex(2).next());
  double sum = 0;
  for (std::uint32_t i = 0; i < 10000; ++i) sum += exact::LcgByIndex(i).next_symmetric();
  EXPECT_LT(std::abs(sum / 10000), 0.02);  // uniform: the standard deviation of this mean is 0.0058
}

// Decimals of a scene become the nearest double: the classic hard cases, with ties and long tails.
TEST(ExactMath, DecimalsAreReadCorrectlyRounded) {
  const struct {
    const char* decimal;
    double nearest;
  } cases[] = {
      {"0.1", 0x1.999999999999ap-4},
      {"9007199254740993.0", 0x1p+53},  // a tie goes to the even one
      {"9007199254740993", 0x1p+53},    // as an integer too
      {"9007199254740993.00000000000000000000000000000001", 0x1.0000000000001p+53},
      {"2.2250738585072011e-308", 0x0.fffffffffffffp-1022},  // the largest denormal
      {"2.2250738585072014e-308", 0x1p-1022},
      {"1.7976931348623157e308", 0x1.fffffffffffffp+1023},
      {"4.9e-324", 0x1p-1074},
      {"6.0221407599999999987e23", 0x1.fe185ca57c517p+78},
      {"179769313486231580793728971405301.1", 0x1.1ba03f5b20fffp+107},
  };
  for (const auto& c : cases) {
    EXPECT_EQ(nlohmann::json::parse(c.decimal).get<double>(), c.nearest) << c.decimal;
  }
}

}  // namespace
}  // namespace lockstep::exact_math_test
