#include "cpu_reference/joints/angle.hpp"

#include <gtest/gtest.h>

namespace lockstep::angle_test {
namespace {

// Against the C library, over all turns; the quaternion need not be unit.
TEST(RotationAngle, IsTwiceTheArcTangent) {
  for (int i = -20000; i <= 20000; ++i) {
    const double angle = 3.141592653589793 * i / 20000, size = 1 + 0.3 * std::sin(7.0 * i);
    const double z = size * std::sin(angle / 2), w = size * std::cos(angle / 2);
    if (w < 0) continue;
    EXPECT_NEAR(reference::rotation_angle(z, w), angle, 2e-15) << angle;
    EXPECT_NEAR(double(reference::rotation_angle(float(z), float(w))), angle, 1e-6) << angle;
  }
}

TEST(DirectionAngle, IsThatOfTheCLibrary) {
  for (int i = -20000; i <= 20000; ++i) {
    const double angle = 3.141592653589793 * i / 20000, size = 1 + 0.3 * std::sin(7.0 * i);
    const double x = size * std::cos(angle), y = size * std::sin(angle);
    EXPECT_NEAR(reference::direction_angle(x, y, size), std::atan2(y, x), 2e-15) << angle;
    const float x_f = float(x), y_f = float(y);
    EXPECT_NEAR(double(reference::direction_angle(x_f, y_f, std::sqrt(x_f * x_f + y_f * y_f))), std::atan2(y_f, x_f),
                2e-6)
        << angle;
  }
}

TEST(RotationAngle, OfNoQuaternionIsZero) { EXPECT_EQ(reference::rotation_angle(0.0, 0.0), 0.0); }

}  // namespace
}  // namespace lockstep::angle_test
