// How far bodies rotate and what they keep while nothing stops them: against closed forms, and against Euler's
// equations integrated by another method in small steps.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "cpu_reference/gyroscopic.hpp"
#include "host/scene/read.hpp"
#include "tests/bodies.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::free_rotation_test {
namespace {

const double pi = std::acos(-1.0);

Vector3 times(const Vector3& a, const Vector3& b) { return {a[0] * b[0], a[1] * b[1], a[2] * b[2]}; }

/// A body alone in space; `more` is what else the scene has.
std::string body_alone(const Vector3& inertia, const Vector3& w, double dt, const std::string& more = "",
                       const std::string& settings = "") {
  return fmt::format(R"({{"gravity": [0, 0, 0], "settings": {{"dt": {} {}}},
      "bodies": [{{"name": "body", "mass": 1, "inertia": [{}, {}, {}], "angular_velocity": [{}, {}, {}]}}] {}}})",
                     dt, settings, inertia[0], inertia[1], inertia[2], w[0], w[1], w[2], more);
}

struct Rotation {
  Quaternion q;  // body to world
  Vector3 w;     // world
};
Vector3 angular_momentum_of(const Rotation& r, const Vector3& inertia) {
  return exact::rotate(r.q, times(inertia, unrotate(r.q, r.w)));
}
double energy_of(const Rotation& r, const Vector3& inertia) { return 0.5 * dot(r.w, angular_momentum_of(r, inertia)); }

/// Euler's equations and q' = 1/2 q (w, 0) by the classical Runge-Kutta method.
Rotation integrated(const Vector3& inertia, const Vector3& start_w, double time, int steps) {
  struct State {
    std::array<double, 7> x;
  };
  const auto rate = [&](const State& s) {
    const auto [x, y, z, r, a, b, c] = s.x;
    return State{{0.5 * (r * a + y * c - z * b), 0.5 * (r * b + z * a - x * c), 0.5 * (r * c + x * b - y * a),
                  -0.5 * (x * a + y * b + z * c), (inertia[1] - inertia[2]) * b * c / inertia[0],
                  (inertia[2] - inertia[0]) * c * a / inertia[1], (inertia[0] - inertia[1]) * a * b / inertia[2]}};
  };
  const auto plus = [](State s, double h, const State& change) {
    for (unsigned i = 0; i < 7; ++i) s.x[i] += h * change.x[i];
    return s;
  };
  State s = {{0, 0, 0, 1, start_w[0], start_w[1], start_w[2]}};
  const double h = time / steps;
  for (int i = 0; i < steps; ++i) {
    const State a = rate(s), b = rate(plus(s, h / 2, a)), c = rate(plus(s, h / 2, b)), d = rate(plus(s, h, c));
    s = plus(plus(plus(plus(s, h / 6, a), h / 3, b), h / 3, c), h / 6, d);
  }
  const Quaternion q = exact::unit({s.x[0], s.x[1], s.x[2], s.x[3]});
  return {q, exact::rotate(q, {s.x[4], s.x[5], s.x[6]})};
}

struct Method {
  const char *solver, *precision;
  bool is_double() const { return std::string(precision) == "double"; }
};
void PrintTo(const Method& m, std::ostream* out) { *out << m.solver << " in " << m.precision; }

class FreeRotation : public testing::TestWithParam<Method> {
 protected:
  World world(const std::string& scene) const {
    return World(parse_scene(scene, "free_rotation_test"),
                 {.device = "reference", .precision = GetParam().precision, .solver = GetParam().solver});
  }
  static Rotation rotation(World& w, const char* name = "body") {
    const BodyHandle body = *w.find(name);
    return {w.pose(body).orientation, w.velocity(body).angular};
  }
  /// 1e-3 of what is kept in float, rounding in double.
  double kept() const { return GetParam().is_double() ? 1e-11 : 1e-3; }
  /// By how far an angle may be off for rounding after so many steps.
  double rounding(double steps) const { return (GetParam().is_double() ? 1e-14 : 5e-6) * std::max(steps, 10.0); }
};

// A book, a rod and a plate, each about axes that are not principal ones, and about the middle one.
TEST_P(FreeRotation, KeepsItsEnergyAndItsAngularMomentum) {
  struct Case {
    Vector3 inertia, w;
    double dt, duration;
  };
  for (const Case& c :
       {Case{{0.0016, 0.0037, 0.0052}, {0.05, 12, 0.05}, 1.0 / 60, 100},
        Case{{0.0037, 0.0016, 0.0052}, {12, 0.05, 0.05}, 1.0 / 60, 100}, Case{{1, 1, 0.002}, {3, 2, 60}, 1.0 / 60, 20},
        Case{{1, 2, 2.9}, {1, 60, 1}, 1.0 / 60, 20}, Case{{0.5, 0.6, 1.1}, {70, 70, 7}, 1.0 / 30, 20},
        Case{{1, 2, 2.5}, {200, 1, 200}, 1.0 / 60, 5}}) {
    World w = world(body_alone(c.inertia, c.w, c.dt));
    const Rotation start = rotation(w);
    w.step(u32(std::lround(c.duration / c.dt)));
    const Rotation end = rotation(w);
    const Vector3 before = angular_momentum_of(start, c.inertia);
    EXPECT_LT(length(angular_momentum_of(end, c.inertia) - before) / length(before), kept()) << c.w[0];
    EXPECT_NEAR(energy_of(end, c.inertia) / energy_of(start, c.inertia), 1, kept()) << c.w[0];
  }
}

// The axis of a symmetric body goes around its angular momentum at the rate |L| / I_x (Landau and Lifshitz, Mechanics,
// section 33).
TEST_P(FreeRotation, AFreeSymmetricTopPrecessesAboutItsAngularMomentum) {
  for (const Vector3& inertia : {Vector3{2, 2, 1}, Vector3{1, 1, 1.9}, Vector3{1, 1, 0.01}}) {
    const Vector3 w = {3, 0, 9}, momentum = times(inertia, w);
    const double size = length(momentum), angle = size / inertia[0] * 0.5;
    const Vector3 about_l = (1 / size) * momentum;
    const Vector3 exact_axis =
        exact::rotate(exact::rotation(about_l, std::sin(angle / 2), std::cos(angle / 2)), {0, 0, 1});
    const auto error = [&](u32 steps) {
      World top = world(body_alone(inertia, w, 0.5 / steps));
      top.step(steps);
      return length(exact::rotate(rotation(top).q, {0, 0, 1}) - exact_axis);
    };
    EXPECT_LT(error(30), 0.02);
    if (GetParam().is_double()) {
      EXPECT_NEAR(error(200) / error(400), 4, 0.1);
    }
  }
}

TEST_P(FreeRotation, FollowsEulersEquations) {
  const Vector3 inertia = {1, 2, 2.7}, w = {0.5, 8, 0.4};
  const Rotation exact = integrated(inertia, w, 1, 20000);
  const auto error = [&](u32 steps) {
    World body = world(body_alone(inertia, w, 1.0 / steps));
    body.step(steps);
    const Rotation end = rotation(body);
    return length(exact::rotate(end.q, {1, 0, 0}) - exact::rotate(exact.q, {1, 0, 0})) +
           length(end.w - exact.w) / length(w);
  };
  EXPECT_LT(error(60), 0.12);
  if (GetParam().is_double()) {
    EXPECT_NEAR(error(400) / error(800), 4, 0.1);
  }
}

// About a principal axis an angular velocity w turns a body by w t, of any body, at any speed: a ball, a rod about its
// length and a kinematic body.
TEST_P(FreeRotation, AngularVelocityIsTheRateOfTheAngle) {
  for (const double speed : {1.0, 12.0, 60.0, 100.0, 1000.0}) {
    for (const Vector3& inertia : {Vector3{1, 1, 1}, Vector3{1, 1, 0.002}, Vector3{1, 2, 2.5}}) {
      World w = world(body_alone(inertia, {0, 0, speed}, 1.0 / 60, "", R"(, "steps": 60)"));
      w.step(60);
      const Quaternion q = rotation(w).q;
      const double off = std::remainder(2 * std::atan2(q[2], q[3]) - speed, 2 * pi);
      EXPECT_NEAR(off, 0, rounding(60) * std::max(speed / 60, 1.0)) << speed;
      EXPECT_NEAR(std::hypot(q[0], q[1]), 0, 1e-6);
      EXPECT_EQ(rotation(w).w[2], GetParam().is_double() ? speed : double(float(speed)));
    }
  }
}

TEST_P(FreeRotation, AKinematicBodyRotatesByItsAngularVelocity) {
  for (const double speed : {12.0, 100.0, 1000.0}) {
    World w = world(fmt::format(R"({{"gravity": [0, 0, 0], "settings": {{"dt": 0.016666666666666666}},
        "bodies": [{{"name": "body", "type": "kinematic", "angular_velocity": [0, {}, 0]}}]}})",
                                speed));
    w.step(60);
    const Quaternion q = rotation(w).q;
    EXPECT_NEAR(std::remainder(2 * std::atan2(q[1], q[3]) - speed, 2 * pi), 0,
                rounding(60) * std::max(speed / 60, 1.0));
  }
}

// A wheel, round or not, at the speed of its motor; the joint says the same angle as the pose.
TEST_P(FreeRotation, AMotorRotatesAHingeByItsSpeed) {
  for (const double speed : {3.0, 30.0, 60.0, 100.0}) {
    for (const Vector3& inertia : {Vector3{0.1, 0.1, 0.1}, Vector3{0.1, 0.3, 0.35}}) {
      World w = world(body_alone(inertia, {0, 0, 0}, 1.0 / 60,
                                 fmt::format(R"(, "joints": [
          {{"name": "axle", "type": "hinge", "bodies": ["world", "body"], "anchor": [0, 0, 0], "axis": [0, 0, 1],
           "motor": {{"speed": {}, "max_torque": 1e6}}}}])",
                                             speed)));
      w.step(10);  // the sub-steps of the first step have come to its speed
      const Quaternion before = rotation(w).q;
      const double start = 2 * std::atan2(before[2], before[3]);
      w.step(290);
      const Quaternion q = rotation(w).q;
      const double angle = 2 * std::atan2(q[2], q[3]), rotated = speed * 290.0 / 60;
      const double coordinate = w.state(*w.find_joint("axle")).coordinate;
      EXPECT_NEAR(std::remainder(angle - start - rotated, 2 * pi), 0, rounding(300) * std::max(speed / 60, 1.0))
          << speed;
      EXPECT_NEAR(std::remainder(coordinate - angle, 2 * pi), 0, 1e-5) << speed;
    }
  }
}

// A body that joints hold where its centre of mass is feels no impulse: it is as free as without them.
TEST_P(FreeRotation, ABallJointAtItsCentreOfMassLeavesABodyFree) {
  const Vector3 inertia = {0.0016, 0.0037, 0.0052}, w = {0.05, 12, 0.05};
  World jointed = world(body_alone(
      inertia, w, 1.0 / 60, R"(, "joints": [{"type": "ball", "bodies": ["world", "body"], "anchor": [0, 0, 0]}])"));
  const Rotation start = rotation(jointed);
  jointed.step(1200);
  const Vector3 before = angular_momentum_of(start, inertia);
  EXPECT_LT(length(angular_momentum_of(rotation(jointed), inertia) - before) / length(before), kept());
}

// An unbalanced wheel: its bearing takes the gyroscopic moment, and the wheel turns about the axle, as the joint was
// solved.
TEST_P(FreeRotation, AnUnbalancedWheelStaysOnItsAxle) {
  World w = world(R"({"gravity": [0, 0, 0], "settings": {"dt": 0.016666666666666666},
      "bodies": [{"name": "body", "mass": 1, "inertia": [0.1, 0.2, 0.28],
                  "orientation": {"axis": [1, 2, 0], "angle_deg": 25}, "angular_velocity": [0, 0, 30]}],
      "joints": [{"name": "axle", "type": "hinge", "bodies": ["world", "body"], "anchor": [0, 0, 0], "axis": [0, 0, 1]}]})");
  w.step(600);
  EXPECT_LT(w.state(*w.find_joint("axle")).angle, 0.02);
}

INSTANTIATE_TEST_SUITE_P(Methods, FreeRotation,
                         testing::Values(Method{"gauss_seidel", "float"}, Method{"gauss_seidel", "double"},
                                         Method{"small_steps", "float"}, Method{"small_steps", "double"},
                                         Method{"auto", "double"}),
                         [](const auto& method) {
                           return fmt::format("{}_{}", method.param.solver, method.param.precision);
                         });

// ---- the formulas

template <class real>
class IntegrateOrientation : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(IntegrateOrientation, Precisions);

// From a millionth of a radian to thousands of turns in a step; what is left is the rounding of w dt itself.
TYPED_TEST(IntegrateOrientation, RotatesByTheAngle) {
  using real = TypeParam;
  const long double epsilon = sizeof(real) == 4 ? 6e-8L : 1.2e-16L;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 20000; ++i) {
    const double speed = std::pow(10.0, -6 + 10 * (i / 20000.0));
    const Vector3 direction = {uniform(random), uniform(random), uniform(random)};
    const real dt = real(0.5), scale = real(speed / length(direction));
    const reference::Vec3<real> w = {real(direction[0]) * scale, real(direction[1]) * scale,
                                     real(direction[2]) * scale};
    const auto q = reference::integrate_orientation<real>({0, 0, 0, 1}, w, dt);
    const long double wx = w.x, wy = w.y, wz = w.z, size = std::sqrt(wx * wx + wy * wy + wz * wz);
    const long double half = size * dt / 2, s = std::sin(half) / size, c = std::cos(half);
    const long double sign = c * q.w + s * (wx * q.x + wy * q.y + wz * q.z) < 0 ? -1 : 1;  // -q is the same rotation
    const long double tolerance = epsilon * (8 + 4 * half);
    ASSERT_NEAR(double(sign * q.w - c), 0, double(tolerance)) << speed;
    ASSERT_NEAR(double(sign * q.x - s * wx), 0, double(tolerance)) << speed;
    ASSERT_NEAR(double(sign * q.y - s * wy), 0, double(tolerance)) << speed;
    ASSERT_NEAR(double(sign * q.z - s * wz), 0, double(tolerance)) << speed;
  }
}

TYPED_TEST(IntegrateOrientation, IsOfUnitLengthOrNotANumber) {
  using real = TypeParam;
  for (double speed = 1e-30; speed < 1e30; speed *= 3) {
    const auto q = reference::integrate_orientation<real>({0, 0, 0, 1}, {real(speed), 0, real(-0.3 * speed)}, real(1));
    const double square = double(q.x) * q.x + double(q.y) * q.y + double(q.z) * q.z + double(q.w) * q.w;
    if (square == square) {
      EXPECT_NEAR(square, 1, sizeof(real) == 4 ? 1e-6 : 1e-14) << speed;
    } else {
      EXPECT_GT(speed, 1e18) << "only where the square of the angle is out of range";
    }
  }
}

}  // namespace
}  // namespace lockstep::free_rotation_test
